"""Upright prisms that stand still: their outline, and what they keep from the light."""

from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, FloatArray
from contracts.arrays import freeze
from sim.lights import Beam

_SKIN_M = 1e-3  # a beam must run this far inside to be stopped, as for vehicles
_PARALLEL = 1e-9


@dataclass(frozen=True, eq=False)
class Solid:
    """A prism between two heights whose outline (2 K, 2), counter-clockwise, is symmetric about its centre, convex."""

    outline_m: FloatArray
    bottom_m: float
    top_m: float

    def __post_init__(self) -> None:
        freeze(self, "outline_m", shape=(None, 2))

    @property
    def centre_m(self) -> FloatArray:
        """(2,) of the outline."""
        return np.asarray(self.outline_m.mean(axis=0))

    @property
    def corners_m(self) -> FloatArray:
        """(4 K, 3) world."""
        heights = np.repeat([self.bottom_m, self.top_m], len(self.outline_m))
        return np.column_stack([np.tile(self.outline_m, (2, 1)), heights])

    def gap_m(self, points_m: FloatArray) -> FloatArray:
        """How far points (N, 2) are outside of the outline, (N,); negative inside, too small beyond a corner."""
        normals, halves = self._sides()
        return np.asarray((np.abs((points_m - self.centre_m) @ normals.T) - halves).max(axis=1))

    def shades(self, points_m: FloatArray, beam: Beam) -> BoolArray:
        """Whether it keeps the beam from points (N, 3); (N,). Slabs, as Kay & Kajiya (1986)."""
        normals, halves = self._sides()
        normals = np.vstack([np.column_stack([normals, np.zeros(len(normals))]), [0.0, 0.0, 1.0]])  # (K + 1, 3)
        halves = np.append(halves, (self.top_m - self.bottom_m) / 2)
        centre = np.append(self.centre_m, (self.top_m + self.bottom_m) / 2)
        slope = normals @ -beam.direction
        slope = np.where(np.abs(slope) < _PARALLEL, _PARALLEL, slope)
        middle = (points_m - centre) @ normals.T / -slope  # (N, K + 1) metres along the beam
        reach = halves / np.abs(slope)
        entry, leave = (middle - reach).max(axis=1), (middle + reach).min(axis=1)
        return np.asarray(leave - np.maximum(entry, 0.0) > _SKIN_M)

    def _sides(self) -> tuple[FloatArray, FloatArray]:
        """Outward normals (K, 2) of half of the sides, and the distances (K,) of these from the centre."""
        edges = np.roll(self.outline_m, -1, axis=0) - self.outline_m
        edges = edges[: len(edges) // 2]
        normals = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1, keepdims=True)
        return normals, np.einsum("kj,kj->k", normals, self.outline_m[: len(edges)] - self.centre_m)
