"""Lines beside lines: what lies left or right of a lane's middle, and points along it. All on the ground plane."""

import numpy as np

from contracts import FloatArray


def offset_line(points_m: FloatArray, left_m: float) -> FloatArray:
    """The line ``left_m`` to the left of ``points_m`` (N, 3), corner by corner; heights stay. (N, 3).

    Each corner moves along the bisector of its sides, so that the new sides are parallel to the old ones.
    """
    sides = _unit_sides(points_m)
    before, after = np.vstack([sides[:1], sides]), np.vstack([sides, sides[-1:]])
    bisector = before + after
    bisector /= np.linalg.norm(bisector, axis=1, keepdims=True)
    reach = left_m / np.maximum((bisector * after).sum(axis=1), 0.5)  # a turn beyond 120 degrees gets a blunt corner
    moved = points_m.copy()
    moved[:, 0] -= bisector[:, 1] * reach
    moved[:, 1] += bisector[:, 0] * reach
    return moved


def at_end(points_m: FloatArray, left_m: float) -> FloatArray:
    """The point ``left_m`` to the left of the line's end; (3,)."""
    east, north = _unit_sides(points_m)[-1]
    return np.asarray(points_m[-1] + left_m * np.array([-north, east, 0.0]))


def point_before_end(points_m: FloatArray, before_m: float) -> tuple[FloatArray, float]:
    """The point (3,) on the line ``before_m`` before its end, no farther than its start, and the heading there."""
    lengths = np.linalg.norm(np.diff(points_m[:, :2], axis=0), axis=1)
    reached = np.concatenate([[0.0], np.cumsum(lengths)])
    along = max(0.0, reached[-1] - before_m)
    point = np.array([np.interp(along, reached, points_m[:, axis]) for axis in range(3)])
    side = min(int(np.searchsorted(reached, along, side="right")) - 1, len(lengths) - 1)
    east, north = _unit_sides(points_m)[side]
    return point, float(np.arctan2(north, east))


def _unit_sides(points_m: FloatArray) -> FloatArray:
    sides = np.diff(points_m[:, :2], axis=0)
    return np.asarray(sides / np.linalg.norm(sides, axis=1, keepdims=True))
