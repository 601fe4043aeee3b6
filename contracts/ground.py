"""Objects on the ground, in metres."""

from dataclasses import dataclass

import numpy as np

from contracts.arrays import BoolArray, FloatArray, IntArray, freeze

FUSED = "fused"  # the source of tracks that all cameras together stand for


@dataclass(frozen=True, eq=False)
class GroundTracks:
    """Tracks placed in the world; one camera's view, or all of them fused.

    source: the camera's name, or ``"fused"``.
    time_ns: of the frame.
    ids, labels: N identities and names.
    positions_m: (N, 2) x east, y north of the footprint's centre; NaN where not valid.
    covs_m2: (N, 2, 2) covariance of the position, calibration's share included; NaN where not valid.
    valid: (N,) False where the pixel's ray does not meet the plane.
    """

    source: str
    time_ns: int
    ids: IntArray
    labels: tuple[str, ...]
    positions_m: FloatArray
    covs_m2: FloatArray
    valid: BoolArray

    def __post_init__(self) -> None:
        n = len(self.labels)
        object.__setattr__(self, "labels", tuple(self.labels))
        freeze(self, "ids", shape=(n,), dtype=np.int64)
        freeze(self, "positions_m", shape=(n, 2), finite=False)
        freeze(self, "covs_m2", shape=(n, 2, 2), finite=False)
        freeze(self, "valid", shape=(n,), dtype=np.bool_)

    def __len__(self) -> int:
        return len(self.labels)
