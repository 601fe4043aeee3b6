"""The ground's height beside and under the road, from the heights of the lanes."""

import numpy as np
from scipy.spatial import cKDTree

from contracts import FloatArray

_STEP_M = 1.0
_BLENDED = 8  # lane points whose heights are mixed: no cliffs between two roads of different height


class Terrain:
    """Heights anywhere near lanes.

    lines_m: middle lines of lanes, each (N, 3). On them the terrain has their height, beside them that of the nearest.
    """

    def __init__(self, lines_m: list[FloatArray]) -> None:
        points = np.concatenate([densified(line, _STEP_M) for line in lines_m])
        self._tree, self._heights_m = cKDTree(points[:, :2]), points[:, 2]
        self._level_m = float(points[0, 2]) if np.ptp(points[:, 2]) == 0.0 else None

    def height_m(self, places_m: FloatArray) -> FloatArray:
        """Heights (N,) at places (N, 2)."""
        places_m = np.asarray(places_m, np.float64)
        if self._level_m is not None:
            return np.full(len(places_m), self._level_m)
        away_m, near = self._tree.query(places_m, k=_BLENDED)
        weights = 1.0 / np.maximum(away_m, 1e-6) ** 2
        return np.asarray((weights * self._heights_m[near]).sum(axis=1) / weights.sum(axis=1))

    def lifted(self, places_m: FloatArray, above_m: float = 0.0) -> FloatArray:
        """The places (N, 2) on the ground, or so far above it; (N, 3)."""
        return np.column_stack([places_m, self.height_m(places_m) + above_m])


def densified(line_m: FloatArray, step_m: float) -> FloatArray:
    """The line (N, 3) with more points, none farther than ``step_m`` from the next; its corners stay."""
    gaps = np.linalg.norm(np.diff(line_m, axis=0), axis=1)
    parts = np.maximum(1, np.ceil(gaps / step_m)).astype(int)
    along = np.concatenate([k + np.arange(n) / n for k, n in enumerate(parts)] + [[float(len(parts))]])
    return np.column_stack([np.interp(along, np.arange(len(line_m)), line_m[:, axis]) for axis in range(3)])
