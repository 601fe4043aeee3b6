"""What the owner of the cameras knows before any calibration: the plan on paper, not the truth."""

from dataclasses import dataclass

from contracts.arrays import FloatArray, freeze, frozen_array
from contracts.camera import Camera
from contracts.errors import InputError


@dataclass(frozen=True)
class Checkerboard:
    """A calibration board with ``columns`` x ``rows`` *inner* corners and squares of ``square_m`` metres."""

    columns: int
    rows: int
    square_m: float

    def __post_init__(self) -> None:
        if min(self.columns, self.rows) < 3 or not self.square_m > 0:
            raise InputError(
                f"Checkerboard {self.columns} x {self.rows} of {self.square_m} m: at least 3 x 3 inner corners"
            )


@dataclass(frozen=True, eq=False)
class Survey:
    """Nominal cameras, surveyed marks, and the plan of the track.

    cameras: where each camera should be; the true pose departs from it.
    control_points_m: (N, 3) world positions of the marks on the floor.
    board: the checkerboard that is held before the cameras.
    centrelines_m: (N, 2) points in order along the middle of each piece of track, two or more; none without a plan.
    """

    cameras: tuple[Camera, ...]
    control_points_m: FloatArray
    board: Checkerboard
    centrelines_m: tuple[FloatArray, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "control_points_m", shape=(None, 3))
        lines = (frozen_array(line, name="Survey.centrelines_m", shape=(None, 2)) for line in self.centrelines_m)
        object.__setattr__(self, "centrelines_m", tuple(lines))
        if any(len(line) < 2 for line in self.centrelines_m):
            raise InputError("Survey.centrelines_m: a line has two points or more")
