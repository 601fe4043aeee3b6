"""What the owner of the cameras knows before any calibration: the plan on paper, not the truth."""

from dataclasses import dataclass

from contracts.arrays import FloatArray, freeze
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
    """Nominal cameras and surveyed marks.

    cameras: where each camera should be; the true pose departs from it.
    control_points_m: (N, 3) world positions of the marks on the floor.
    board: the checkerboard that is held before the cameras.
    """

    cameras: tuple[Camera, ...]
    control_points_m: FloatArray
    board: Checkerboard

    def __post_init__(self) -> None:
        freeze(self, "control_points_m", shape=(None, 3))
