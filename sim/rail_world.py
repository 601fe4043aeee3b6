"""The rail world: vehicles on a plant, filmed by a rig of cameras, with exact truth."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol

from contracts import Camera, Frame, InputError, Survey
from contracts.truth import CameraTruth, Step, Truth
from rail import Plant
from sim.board import BOARD, board_views
from sim.lens import Lens
from sim.light_program import LightProgram
from sim.lights import RAIL_LIGHTS, LightPreset
from sim.plant_scene import scene_of_plant
from sim.renderer import RendererName
from sim.rig import RigSpec, nominal_cameras, true_cameras
from sim.sensor import SensorSpec
from sim.studio import PlantStudio
from sim.surroundings import Surroundings

_BARE = Surroundings()


class Motion(Protocol):
    """What moves; ``sim.rail_motion`` is the one for trains."""

    def run(self, times_ns: Sequence[int]) -> Iterator[Truth]:
        """The state at each moment, without cameras; the same each time it is called."""
        ...


class RailWorld:
    """A ``contracts.truth.World``.

    times_ns: mid-exposures of the frames.
    seed: decides the true cameras, the floor and the clutter; the motion has its own.
    noise_seed: of the sensors' noise; ``seed`` if not given.
    film: False gives the truth without frames, and needs no graphics.
    workers: processes that share the cameras; the frames are the same for any number.
    renderer: how frames are drawn.
    surroundings: what an author put round the track. sensor: of all cameras, instead of the rig's.
    """

    def __init__(
        self,
        plant: Plant,
        motion: Motion,
        times_ns: Sequence[int],
        *,
        rig: RigSpec,
        light: LightPreset | LightProgram | str,
        seed: int,
        noise_seed: int | None = None,
        film: bool = True,
        workers: int = 1,
        keep_instances: bool = True,
        renderer: RendererName | str = RendererName.LAYERED,
        surroundings: Surroundings = _BARE,
        sensor: SensorSpec | None = None,
    ) -> None:
        if not isinstance(light, LightProgram) and light not in RAIL_LIGHTS:
            raise InputError(f"light {light!r} is unknown; choose from {', '.join(RAIL_LIGHTS)}")
        if renderer not in list(RendererName):
            raise InputError(f"renderer {renderer!r} is unknown; choose from {', '.join(RendererName)}")
        self._renderer = RendererName(renderer)
        self._motion, self._times_ns, self._rig = motion, tuple(times_ns), rig
        self._light = light if isinstance(light, LightProgram) else LightPreset(light)
        self._sensor, self._highlights = sensor or rig.sensor, surroundings.highlights
        self._seed, self._noise_seed = seed, seed if noise_seed is None else noise_seed
        self._film, self._workers, self._keep_instances = film, workers, keep_instances
        self._cameras = true_cameras(rig, seed)
        self._scene = scene_of_plant(plant, self._cameras, seed, surroundings)
        self._survey = Survey(nominal_cameras(rig), self._scene.control_points_m, BOARD, self._scene.centrelines_m)

    @property
    def survey(self) -> Survey:
        """Nominal cameras, the marks on the floor, the checkerboard, the plan of the track."""
        return self._survey

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
        from sim.crew import FilmSpec, film

        spec = FilmSpec(
            PlantStudio(self._scene, self._light, self._renderer),
            self._cameras,
            self._sensor,
            noise_seed=self._noise_seed,
            keep_instances=self._keep_instances,
            highlights=self._highlights,
        )
        return map(step_of, states, film(spec, filmed, workers=self._workers))

    def board_views(self, camera: str) -> Iterator[Frame]:
        """The checkerboard in many poses before ``camera``; InputError if the rig has no such camera."""
        known = {each.name: each for each in self._cameras}
        if camera not in known:
            raise InputError(f"camera {camera} is not in this rig; it has {', '.join(known)}")
        chosen = known[camera]
        return board_views(
            chosen,
            Lens.of(chosen.intrinsics),
            self._sensor,
            BOARD,
            seed=self._seed,
            noise_seed=self._noise_seed,
        )


def step_of(state: Truth, takes: Sequence[tuple[Frame, CameraTruth]]) -> Step:
    """A step of the world from its state and what the cameras made of it."""
    frames, views = zip(*takes, strict=True)
    return Step(frames, replace(state, cameras=views))
