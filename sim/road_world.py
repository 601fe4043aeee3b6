"""The road world: traffic on a network under a rig of pole cameras, with exact truth. It cannot be filmed yet."""

from collections.abc import Iterator, Sequence

from contracts import Camera, Frame, InputError, Survey
from contracts.truth import Step
from sim.board import BOARD
from sim.rail_world import Motion
from sim.rig import RigSpec, nominal_cameras, true_cameras

NO_FILM = "the road cannot be filmed yet: run its scenarios at the level of truth, with --oracle locate"


class RoadWorld:
    """A ``contracts.truth.World``.

    times_ns: mid-exposures of the frames. seed: decides the true cameras; the motion has its own.
    film: must be False; InputError else.
    """

    def __init__(self, motion: Motion, times_ns: Sequence[int], *, rig: RigSpec, seed: int, film: bool = False) -> None:
        if film:
            raise InputError(NO_FILM)
        self._motion, self._times_ns = motion, tuple(times_ns)
        self._cameras = true_cameras(rig, seed)
        self._survey = Survey(nominal_cameras(rig), (), BOARD)  # type: ignore[arg-type]

    @property
    def survey(self) -> Survey:
        """Nominal cameras; what is surveyed of a road is its map."""
        return self._survey

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The true cameras."""
        return self._cameras

    def __len__(self) -> int:
        return len(self._times_ns)

    def steps(self) -> Iterator[Step]:
        """The run from its start."""
        yield from (Step((), truth) for truth in self._motion.run(self._times_ns))

    def board_views(self, camera: str) -> Iterator[Frame]:
        """Nothing: no board is held before a camera on a pole."""
        raise InputError(NO_FILM)
