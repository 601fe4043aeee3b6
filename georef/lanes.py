"""Where a position lies among the lanes of a map: nearest centreline, perpendicular foot, offset and heading."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import ArrayLike

from contracts import FloatArray, InputError, IntArray
from contracts.arrays import BoolArray, freeze
from georef.hd_map import HdMap, LaneCentreline


@dataclass(frozen=True, eq=False)
class LanePlaces:
    """N positions against their nearest centrelines, on the ground plane.

    lanes: (N,) row of the centreline in ``LaneIndex.centrelines``.
    feet_m: (N, 2) nearest point of that centreline.
    along_m: (N,) from the centreline's start to the foot.
    across_m: (N,) from the centreline's direction to the position, left positive; beyond the centreline's
        ends its size is less than the distance from the foot.
    distances_m: (N,) from the foot.
    headings_rad: (N,) of the lane at the foot, counter-clockwise from east.
    valid: (N,) False where no centreline is near enough; every other array is NaN, or -1, there.
    """

    lanes: IntArray
    feet_m: FloatArray
    along_m: FloatArray
    across_m: FloatArray
    distances_m: FloatArray
    headings_rad: FloatArray
    valid: BoolArray

    def __post_init__(self) -> None:
        n = len(self.lanes)
        freeze(self, "lanes", shape=(n,), dtype=np.int64)
        freeze(self, "feet_m", shape=(n, 2), finite=False)
        for name in ("along_m", "across_m", "distances_m", "headings_rad"):
            freeze(self, name, shape=(n,), finite=False)
        freeze(self, "valid", shape=(n,), dtype=np.bool_)


class LaneIndex:
    """Finds lanes. Built once, asked often; raises InputError for a map without centrelines."""

    def __init__(self, centrelines: Sequence[LaneCentreline]) -> None:
        if not centrelines:
            raise InputError("the map has no centrelines of lanes to look for")
        self.centrelines = tuple(centrelines)
        self._lines = shapely.remove_repeated_points(
            [shapely.LineString(lane.points_m[:, :2]) for lane in self.centrelines]
        )
        self._tree = shapely.STRtree(self._lines)

    @classmethod
    def of(cls, hd_map: HdMap) -> "LaneIndex":
        """All lanes of ``hd_map``."""
        return cls(hd_map.centrelines)

    def locate(self, positions_m: ArrayLike, *, within_m: float = np.inf) -> LanePlaces:
        """The nearest lane of every position; (N, 2) metres. NaN finds nothing.

        within_m: farther lanes do not count.
        """
        positions = np.asarray(positions_m, dtype=np.float64)
        if positions.ndim != 2 or positions.shape[1] != 2:
            raise InputError(f"positions_m has shape {positions.shape}, expected N x 2")
        lanes = np.full(len(positions), -1)
        asked = np.flatnonzero(np.isfinite(positions).all(axis=1))
        points = shapely.points(positions[asked])
        rows, found = self._tree.query_nearest(points, all_matches=False)
        lanes[asked[rows]] = found
        return self.places_on(lanes, positions, within_m=within_m)

    def places_on(self, lanes: ArrayLike, positions_m: ArrayLike, *, within_m: float = np.inf) -> LanePlaces:
        """Every position against the lane that is named for it; ``lanes`` (N,) rows, -1 for none."""
        rows, positions = np.array(lanes, dtype=np.int64), np.asarray(positions_m, dtype=np.float64)
        if rows.ndim != 1 or positions.shape != (len(rows), 2) or (rows >= len(self._lines)).any():
            raise InputError(f"there are {len(self._lines)} lanes, for positions N x 2 and one lane each")
        feet, headings = np.full((len(rows), 2), np.nan), np.full(len(rows), np.nan)
        along, across, distances = headings.copy(), headings.copy(), headings.copy()
        known = np.flatnonzero((rows >= 0) & np.isfinite(positions).all(axis=1))
        for lane in np.unique(rows[known]):
            mine = known[rows[known] == lane]
            feet[mine], along[mine], headings[mine] = self._feet(lane, positions[mine])
        away = positions - feet
        distances[known] = np.hypot(away[known, 0], away[known, 1])
        across[known] = away[known, 1] * np.cos(headings[known]) - away[known, 0] * np.sin(headings[known])
        valid = np.nan_to_num(distances, nan=np.inf) <= within_m
        valid &= np.isfinite(distances)
        for array in (feet, along, across, distances, headings):
            array[~valid] = np.nan
        return LanePlaces(np.where(valid, rows, -1), feet, along, across, distances, headings, valid)

    def _feet(self, lane: int, positions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Nearest points (N, 2) of one centreline, how far along it they lie, and its headings there."""
        line = self._lines[lane]
        along = np.asarray(shapely.line_locate_point(line, shapely.points(positions)))
        corners = shapely.get_coordinates(line)
        sides = np.diff(corners, axis=0)
        lengths = np.hypot(sides[:, 0], sides[:, 1])
        reached = np.cumsum(lengths)
        side = np.minimum(np.searchsorted(reached, along, side="right"), len(sides) - 1)
        unit = sides[side] / lengths[side, None]
        start = np.concatenate([[0.0], reached])[side]
        feet = corners[side] + (along - start)[:, None] * unit
        return feet, along, np.arctan2(unit[:, 1], unit[:, 0])
