"""What all worlds have in common: something moves, and a rig of cameras films it, with exact truth."""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

from contracts import Camera, Frame, InputError, Survey
from contracts.truth import CameraTruth, Step, Truth
from sim.board import BOARD, board_views
from sim.lens import Lens
from sim.renderer import RendererName
from sim.rig import RigSpec, true_cameras
from sim.sensor import SensorSpec

if TYPE_CHECKING:
    from sim.crew import FilmSpec


class Motion(Protocol):
    """What moves; ``sim.rail_motion`` is the one for trains, ``sim.traffic`` the one for roads."""

    def run(self, times_ns: Sequence[int]) -> Iterator[Truth]:
        """The state at each moment, without cameras; the same each time it is called."""
        ...


@dataclass(frozen=True)
class Filming:
    """How a world is filmed.

    seed: decides the true cameras and what stands about; the motion has its own.
    noise_seed: of the sensors' noise; ``seed`` if not given.
    film: False gives the truth without frames, and needs no graphics.
    workers: processes that share the cameras; the frames are the same for any number.
    renderer: how frames are drawn. sensor: of all cameras, instead of the rig's.
    """

    rig: RigSpec
    seed: int
    noise_seed: int | None = None
    film: bool = True
    workers: int = 1
    keep_instances: bool = True
    renderer: RendererName | str = RendererName.LAYERED
    sensor: SensorSpec | None = None

    def __post_init__(self) -> None:
        if self.renderer not in list(RendererName):
            raise InputError(f"renderer {self.renderer!r} is unknown; choose from {', '.join(RendererName)}")


class FilmedWorld(ABC):
    """A ``contracts.truth.World``, but for its survey and the place where it is filmed.

    times_ns: mid-exposures of the frames.
    """

    def __init__(self, motion: Motion, times_ns: Sequence[int], filming: Filming) -> None:
        self._motion, self._times_ns = motion, tuple(times_ns)
        self._film, self._workers, self._keep_instances = filming.film, filming.workers, filming.keep_instances
        self._seed = filming.seed
        self._noise_seed = filming.seed if filming.noise_seed is None else filming.noise_seed
        self._renderer = RendererName(filming.renderer)
        self._sensor = filming.sensor or filming.rig.sensor
        self._cameras = true_cameras(filming.rig, filming.seed)

    @property
    @abstractmethod
    def survey(self) -> Survey:
        """What the owner knows beforehand."""

    @abstractmethod
    def _film_spec(self) -> "FilmSpec":
        """All that decides the film; graphics are loaded here and no sooner."""

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The true cameras."""
        return self._cameras

    def __len__(self) -> int:
        return len(self._times_ns)

    def steps(self) -> Iterator[Step]:
        """Film the run from its start; other processes begin with it at once, before the first step is asked for."""
        states, filmed = itertools.tee(self._motion.run(self._times_ns))
        if not self._film:
            return (Step((), state) for state in states)
        from sim.crew import film

        return map(_step_of, states, film(self._film_spec(), filmed, workers=self._workers))

    def board_views(self, camera: str) -> Iterator[Frame]:
        """The checkerboard in many poses before ``camera``; InputError if the rig has no such camera."""
        known = {each.name: each for each in self._cameras}
        if camera not in known:
            raise InputError(f"camera {camera} is not in this rig; it has {', '.join(known)}")
        chosen = known[camera]
        lens = Lens.of(chosen.intrinsics)
        return board_views(chosen, lens, self._sensor, BOARD, seed=self._seed, noise_seed=self._noise_seed)


def _step_of(state: Truth, takes: Sequence[tuple[Frame, CameraTruth]]) -> Step:
    """A step of the world from its state and what the cameras made of it."""
    frames, views = zip(*takes, strict=True)
    return Step(frames, replace(state, cameras=views))
