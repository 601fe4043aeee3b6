"""The lamps of vehicles: where they are, and what the dipped beams ahead of them light.

A beam ends above its cut-off, like ECE R112's, and behind the first that stands in its way.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from contracts import FloatArray
from contracts.truth import Truth
from sim.air import Array32
from sim.bodies import Design
from sim.body_pieces import Material
from sim.body_shapes import Wardrobe, affine
from sim.camera_truth import footprint_corners

_INTENSITY_M2 = 2100.0  # in the middle of the beam, relative to the light of streetlamps
_ACROSS_RAD, _BELOW_RAD, _ABOVE_RAD = 0.25, 0.035, 0.008  # how fast it falls to the sides, below and above its middle
_DIPPED_RAD = 0.030
_HIGHEST_M = 1.5  # higher lamps light a destination board, not the road
REACH_M, _WIDE_RAD, _TALL_M = 45.0, 0.80, 1.6
_BINS = 64


@dataclass(frozen=True, eq=False)
class Lamps:
    """The lamps of all road users at one moment.

    positions_m: (K, 3). facing: (K, 3) unit vectors along their axes. red: (K,) whether they look back.
    rows: (K,) of the truth. radii_m: (K,).
    """

    positions_m: FloatArray
    facing: FloatArray
    red: FloatArray
    rows: FloatArray
    radii_m: FloatArray

    @staticmethod
    def of(state: Truth, wardrobe: Wardrobe) -> "Lamps":
        """Those of everybody."""
        places, facing, red, rows, radii = [], [], [], [], []
        for row in range(len(state.ids)):
            cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
            world_from_unit = affine(state, row)
            for material, centre, reach in _lamps_of(wardrobe.appearance(state.kinds[row], state.ids[row]).design):
                back = material is Material.TAIL_LAMP
                places.append(world_from_unit @ centre + state.positions_m[row])
                facing.append((-cos, -sin, 0.0) if back else (cos, sin, 0.0))
                red.append(float(back))
                rows.append(row)
                radii.append(float((reach * state.sizes_m[row])[1:].mean()))
        return Lamps(
            np.array(places).reshape(-1, 3),
            np.array(facing).reshape(-1, 3),
            np.array(red),
            np.array(rows, int),
            np.array(radii),
        )


@dataclass(frozen=True, eq=False)
class Beam:
    """The dipped light of one vehicle.

    position_m: (3,) between its lamps. begins_m, ends_m: (B,) by azimuth, how far away others stand in its way.
    """

    row: int
    position_m: FloatArray
    heading_rad: float
    begins_m: Array32
    ends_m: Array32

    @property
    def corners_m(self) -> FloatArray:
        """(8, 3) around all that it lights to speak of."""
        angles = self.heading_rad + np.array([-_WIDE_RAD, 0.0, _WIDE_RAD]) * 0.8
        rim = self.position_m[:2] + REACH_M * np.column_stack([np.cos(angles), np.sin(angles)])
        ground = np.vstack([self.position_m[:2], rim])
        foot = self.position_m[2] - _TALL_M / 2
        return np.concatenate([np.insert(ground, 2, height, axis=1) for height in (foot, foot + _TALL_M)])

    def on_ground(self, points_m: Array32) -> Array32:
        """Irradiance on level ground at (N, 3), (N,)."""
        towards, range_m, azimuth = self._polar(points_m)
        cosine = np.maximum(-towards[:, 2] / range_m, np.float32(0.0))
        return np.asarray(self._falling(towards, range_m, azimuth, self.begins_m) * cosine)

    def on(self, points_m: Array32, normals: Array32) -> Array32:
        """Irradiance on surfaces of road users at (N, 3) with these unit normals, (N,)."""
        towards, range_m, azimuth = self._polar(points_m)
        cosine = np.maximum(-(towards * normals).sum(axis=1) / range_m, np.float32(0.0))
        return np.asarray(self._falling(towards, range_m, azimuth, self.ends_m) * cosine)

    def _polar(self, points_m: Array32) -> tuple[Array32, Array32, Array32]:
        towards = points_m - self.position_m.astype(np.float32)
        range_m = np.maximum(np.sqrt((towards * towards).sum(axis=1)), np.float32(0.3))
        azimuth = np.arctan2(towards[:, 1], towards[:, 0]) - np.float32(self.heading_rad)
        return towards, range_m, np.mod(azimuth + np.float32(np.pi), np.float32(2 * np.pi)) - np.float32(np.pi)

    def _falling(self, towards: Array32, range_m: Array32, azimuth: Array32, blocked_m: Array32) -> Array32:
        """Irradiance on a surface that faces the lamps."""
        below = -towards[:, 2] / range_m - np.float32(_DIPPED_RAD)
        fall = np.where(below > 0, below * np.float32(1 / _BELOW_RAD), below * np.float32(-1 / _ABOVE_RAD))
        across = azimuth * np.float32(1 / _ACROSS_RAD)
        light = np.float32(_INTENSITY_M2) * np.exp(-fall - np.float32(0.5) * across * across) / (range_m * range_m)
        bins = (azimuth + np.float32(_WIDE_RAD)) * np.float32(_BINS / (2 * _WIDE_RAD)) - np.float32(0.5)
        first = np.clip(bins.astype(np.int32), 0, _BINS - 2)
        share = np.clip(bins - first, np.float32(0.0), np.float32(1.0))
        left, right = range_m <= blocked_m[first], range_m <= blocked_m[first + 1]  # a penumbra as wide as a bin
        return np.asarray(light * (left * (1 - share) + right * share) * (np.abs(azimuth) < _WIDE_RAD), np.float32)


def beams_of(state: Truth, lamps: Lamps) -> Iterator[Beam]:
    """The beams of all vehicles that have headlamps."""
    corners_m = footprint_corners(state)[..., :2]
    for row in range(len(state.ids)):
        mine = (
            (lamps.rows == row) & (lamps.red == 0) & (lamps.positions_m[:, 2] - state.positions_m[row, 2] < _HIGHEST_M)
        )
        if mine.any():
            position = lamps.positions_m[mine].mean(axis=0)
            heading = float(state.headings_rad[row])
            others = np.delete(corners_m, row, axis=0)
            yield Beam(row, position, heading, *_blocked(position, heading, others))


def _blocked(position_m: FloatArray, heading_rad: float, corners_m: FloatArray) -> tuple[Array32, Array32]:
    """How far away the nearest of footprints (M, 4, 2) begins and ends, by azimuth; (B,) each, infinity if none."""
    away = corners_m - position_m[:2]
    ranges = np.linalg.norm(away, axis=2)
    angles = np.arctan2(away[..., 1], away[..., 0]) - heading_rad
    angles = np.mod(angles + np.pi, 2 * np.pi) - np.pi
    ahead = (np.abs(angles) < np.pi / 2).all(axis=1)
    ranges, angles = ranges[ahead], angles[ahead]
    middle = (np.arange(_BINS) + 0.5) * 2 * _WIDE_RAD / _BINS - _WIDE_RAD
    behind = (angles.min(axis=1)[:, None] <= middle) & (angles.max(axis=1)[:, None] >= middle)  # (M, B)
    begins, ends = (
        np.where(behind, reach[:, None], np.inf).min(axis=0, initial=np.inf).astype(np.float32)
        for reach in (ranges.min(axis=1), ranges.max(axis=1))
    )
    return begins, ends


@cache
def _lamps_of(design: Design) -> tuple[tuple[Material, FloatArray, FloatArray], ...]:
    """Material, centre and half size of each lamp, in the unit box."""
    found = []
    for part in design.parts:
        if part.material in (Material.HEADLAMP, Material.TAIL_LAMP):
            for piece in part.pieces:
                low, high = piece.vertices_m.min(axis=0), piece.vertices_m.max(axis=0)
                found.append((part.material, (low + high) / 2, (high - low) / 2))
    return tuple(found)
