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
_ACROSS, _BELOW, _ABOVE = 0.25, 0.035, 0.008  # slopes by which it falls to the sides, below and above its middle
_DIPPED = 0.030
_HIGHEST_M = 1.5  # what is higher is a destination board and lights no road
_BAND_M, _BAND_END_M = 0.30, 0.14  # half width of a band of glass that has a lamp at either end, so far from there
_RADIUS_M = 0.10  # of what shines within the glass
_NEAREST_M, _REACH_M = 0.3, 45.0
_WIDE = 1.0  # slope beyond which there is no light
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
                back, size_m = material is Material.TAIL_LAMP, state.sizes_m[row]
                if centre[2] * size_m[2] > _HIGHEST_M:
                    continue
                for aside_m in _asides_m(float(reach[1] * size_m[1])):
                    shift = (0.0, aside_m / size_m[1], 0.0)
                    places.append(world_from_unit @ (centre + shift) + state.positions_m[row])
                    facing.append((-cos, -sin, 0.0) if back else (cos, sin, 0.0))
                    red.append(float(back))
                    rows.append(row)
                    radii.append(_RADIUS_M)
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

    position_m: (3,) between its lamps.
    begins_m, ends_m: (B,) by slope to the left, how far ahead others stand in its way.
    """

    row: int
    position_m: FloatArray
    heading_rad: float
    begins_m: Array32
    ends_m: Array32

    def on_ground(self, points_m: Array32) -> Array32:
        """Irradiance on level ground at (N, 3), (N,)."""
        return self._on(points_m, None)

    def on(self, points_m: Array32, normals: Array32) -> Array32:
        """Irradiance on surfaces of road users at (N, 3) with these unit normals, (N,)."""
        return self._on(points_m, normals)

    def _on(self, points_m: Array32, normals: Array32 | None) -> Array32:
        cos, sin = np.float32(np.cos(self.heading_rad)), np.float32(np.sin(self.heading_rad))
        x, y, z = (points_m - self.position_m.astype(np.float32)).T
        ahead, left = x * cos + y * sin, y * cos - x * sin
        lit = np.flatnonzero((ahead > _NEAREST_M) & (ahead < _REACH_M) & (np.abs(left) < _WIDE * ahead))
        x, y, z, ahead, left = (part[lit] for part in (x, y, z, ahead, left))
        squared = x * x + y * y + z * z
        nearness = 1 / np.sqrt(squared)
        facing = -z if normals is None else -(x * normals[lit, 0] + y * normals[lit, 1] + z * normals[lit, 2])
        free = _free(left / ahead, ahead, self.begins_m if normals is None else self.ends_m)
        irradiance = np.zeros(len(points_m), np.float32)
        cosine = np.maximum(facing * nearness, np.float32(0.0))
        irradiance[lit] = free * cosine * _intensity_m2(left / ahead, -z * nearness) * nearness * nearness
        return irradiance


def _intensity_m2(aside: Array32, down: Array32) -> Array32:
    """Intensity towards slopes to a side and down."""
    below = down - np.float32(_DIPPED)
    fall = np.maximum(below * np.float32(1 / _BELOW), below * np.float32(-1 / _ABOVE))
    across = aside * np.float32(1 / _ACROSS)
    return np.asarray(np.float32(_INTENSITY_M2) * np.exp(-fall - np.float32(0.5) * across * across))


def _free(aside: Array32, ahead_m: Array32, blocked_m: Array32) -> Array32:
    """Share of the light that gets there, with a penumbra as wide as a bin."""
    bins = (aside + np.float32(_WIDE)) * np.float32(_BINS / (2 * _WIDE)) - np.float32(0.5)
    first = np.clip(bins.astype(np.int32), 0, _BINS - 2)
    share = np.clip(bins - first, np.float32(0.0), np.float32(1.0))
    return np.asarray((ahead_m <= blocked_m[first]) * (1 - share) + (ahead_m <= blocked_m[first + 1]) * share)


def beams_of(state: Truth, lamps: Lamps) -> Iterator[Beam]:
    """The beams of all vehicles that have headlamps."""
    corners_m = footprint_corners(state)[..., :2]
    for row in range(len(state.ids)):
        mine = (lamps.rows == row) & (lamps.red == 0)
        if mine.any():
            position = lamps.positions_m[mine].mean(axis=0)
            heading = float(state.headings_rad[row])
            others = np.delete(corners_m, row, axis=0)
            yield Beam(row, position, heading, *_blocked(position, heading, others))


def _blocked(position_m: FloatArray, heading_rad: float, corners_m: FloatArray) -> tuple[Array32, Array32]:
    """How far ahead the nearest of footprints (M, 4, 2) begins and ends, by slope; (B,) each, infinity if none."""
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    away = (corners_m - position_m[:2]) @ np.array([[cos, -sin], [sin, cos]])  # (M, 4, 2) ahead, to the left
    away = away[(away[..., 0] > _NEAREST_M).all(axis=1)]
    aside = away[..., 1] / away[..., 0]
    middle = (np.arange(_BINS) + 0.5) * 2 * _WIDE / _BINS - _WIDE
    behind = (aside.min(axis=1)[:, None] <= middle) & (aside.max(axis=1)[:, None] >= middle)  # (M, B)
    begins, ends = (
        np.where(behind, reach[:, None], np.inf).min(axis=0, initial=np.inf).astype(np.float32)
        for reach in (away[..., 0].min(axis=1), away[..., 0].max(axis=1))
    )
    return begins, ends


def _asides_m(half_width_m: float) -> tuple[float, ...]:
    """Where along a glass there are lamps: one in its middle, or one at either end of a band across the vehicle."""
    return (0.0,) if half_width_m < _BAND_M else (_BAND_END_M - half_width_m, half_width_m - _BAND_END_M)


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
