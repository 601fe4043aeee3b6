"""Walks along a way that the author drew."""

from math import atan2, hypot

import numpy as np

from sim.road_users import KINDS, Size
from sim.traffic_spec import WalkerSpec


class Walk:
    """Where a walker's front is at any time: at the first corner, on the way, at the last one."""

    def __init__(self, spec: WalkerSpec, size_m: Size) -> None:
        self.kind, self.size_m = KINDS[spec.kind], size_m
        self._spec, self._corners = spec, np.array(spec.path_m)
        sides = np.diff(self._corners[:, :2], axis=0)
        self._reached = np.concatenate([[0.0], np.cumsum(np.hypot(sides[:, 0], sides[:, 1]))])

    def at(self, time_s: float) -> tuple[tuple[float, float, float], float, float]:
        """Front, slope and heading of the way at ``time_s`` of the run."""
        along = float(np.clip((time_s - self._spec.start_s) * self._spec.speed_mps, 0.0, self._reached[-1]))
        side = min(int(np.searchsorted(self._reached, along, side="right")), len(self._reached) - 1)
        dx, dy, dz = (self._corners[side] - self._corners[side - 1]).tolist()
        x, y, z = (float(np.interp(along, self._reached, self._corners[:, axis])) for axis in range(3))
        return (x, y, z), dz / hypot(dx, dy), atan2(dy, dx)
