"""Lamps as a camera sees them: so much brighter than all else that optics and air spread their light around them.

A lamp is a spot with a narrow halo, and a wide one in fog, added to the picture.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.air import Air, Array32
from sim.body_shapes import Wardrobe
from sim.headlamps import Lamps
from sim.outlines import NEAR_M, seen_px
from sim.renderer import Window
from sim.signals import Aspect, Shown, SignalHead

_HEAD_BGR, _TAIL_BGR = (1750.0, 1880.0, 2000.0), (80.0, 70.0, 1100.0)
_STREET_BGR = (560.0, 860.0, 1080.0)
_STREET_RADIUS_M = 0.28
_SIGNAL_BGR = {Aspect.RED: (38.0, 48.0, 460.0), Aspect.AMBER: (12.0, 150.0, 460.0), Aspect.GREEN: (135.0, 400.0, 36.0)}
_SIGNAL_RADIUS_M, _SIGNAL_HALF_M = 0.14, 0.19  # of a light; from its middle to its face
_AT_NIGHT = 1.5  # signals are dimmed, but exposures are longer
_BEHIND_M = 0.7  # by which the surface of a luminaire may be before its middle
_SHARPEST_PX = 0.7  # standard deviation; a smaller spot dims, but less than its area: lamps are far beyond white
_HALO, _HALO_PX = 0.045, 0.0042  # share of the spot's level; length over which it falls, of the focal length
_MIST, _MIST_PX = 0.10, 0.034  # the same of what fog adds, where all light is scattered once
_ENDS = 4.0  # halos are cut at so many lengths
_LOOKS_RAD = 0.15  # sine of the angle from behind which a lamp cannot be seen


@dataclass(frozen=True, eq=False)
class Spot:
    """What one lamp adds to a picture: levels (h, w, 3) in a window."""

    window: Window
    levels: Array32


def street_spots(camera: Camera, lamps_m: FloatArray, depth_m: NDArray[np.float32], air: Air) -> Iterator[Spot]:
    """Luminaires at (L, 3); depth_m: (H, W) of all that stands still."""
    for lamp in lamps_m:
        at = _in_picture(camera, lamp)
        if at is not None:
            free = _share(depth_m > at.depth_m - _BEHIND_M, at)
            yield from _spot(camera, at, free * np.array(_STREET_BGR), _STREET_RADIUS_M, air)


def signal_spots(
    camera: Camera, heads: Sequence[SignalHead], shown: Shown, depth_m: NDArray[np.float32], air: Air, *, lamplit: bool
) -> Iterator[Spot]:
    """Lights of signals; depth_m: (H, W) of all that stands still. lamplit: whether streetlamps are on."""
    for head, lit in zip(heads, shown, strict=True):
        for aspect, middle in zip(Aspect, head.lights_m, strict=True):
            away = camera.pose.position_m - middle
            looks = float(head.facing @ away) / float(np.linalg.norm(away))
            at = _in_picture(camera, middle + np.copysign(_SIGNAL_HALF_M, looks) * head.facing)
            if aspect in lit and at is not None:
                level = np.array(_SIGNAL_BGR[aspect]) * abs(looks) * (_AT_NIGHT if lamplit else 1.0)
                free = _share(depth_m > at.depth_m - 2 * _SIGNAL_HALF_M, at)
                yield from _spot(camera, at, free * level, _SIGNAL_RADIUS_M, air)


def vehicle_spots(camera: Camera, state: Truth, wardrobe: Wardrobe, instances: ImageArray, air: Air) -> Iterator[Spot]:
    """Lamps of road users; instances: (H, W) as in ``Rendered``."""
    lamps = Lamps.of(state, wardrobe)
    for k, place in enumerate(lamps.positions_m):
        at = _in_picture(camera, place)
        if at is None:
            continue
        looks = float(lamps.facing[k] @ (camera.pose.position_m - place)) / at.range_m
        free = _share(instances == lamps.rows[k] + 1, at)
        if looks > _LOOKS_RAD and free:
            level = np.array(_TAIL_BGR if lamps.red[k] else _HEAD_BGR) * free * (0.2 + 0.8 * looks**2)
            yield from _spot(camera, at, level, float(lamps.radii_m[k]), air)


def added(spots: Iterable[Spot], shape: tuple[int, ...]) -> Array32:
    """What all spots add to a picture (H, W, 3)."""
    total = np.zeros(shape, np.float32)
    for spot in spots:
        total[spot.window] += spot.levels
    return total


@dataclass(frozen=True)
class _Place:
    """Where something is in a picture."""

    u_px: float
    v_px: float
    depth_m: float
    range_m: float


def _in_picture(camera: Camera, place_m: FloatArray) -> _Place | None:
    """Where a place (3,) is seen; None if it is outside of the picture."""
    in_camera = (place_m - camera.pose.position_m) @ camera.pose.world_from_camera
    if in_camera[2] < NEAR_M:
        return None
    u, v = seen_px(camera, in_camera).tolist()
    size = camera.intrinsics
    if not (-0.5 <= u < size.width_px - 0.5 and -0.5 <= v < size.height_px - 0.5):
        return None
    return _Place(u, v, float(in_camera[2]), float(np.linalg.norm(in_camera)))


def _share(free: NDArray[np.bool_], at: _Place) -> float:
    """Which share of the pixels around a place is free."""
    column, row = round(at.u_px), round(at.v_px)
    return float(free[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].mean())


def _spot(camera: Camera, at: _Place, bgr: FloatArray, radius_m: float, air: Air) -> Iterator[Spot]:
    """The spot of a lamp of that level; none if nothing of it is seen."""
    if not bgr.any():
        return
    focal, through = camera.intrinsics.fx_px, math.exp(-air.extinction_per_m * at.range_m)
    size = 0.5 * focal * radius_m / at.depth_m
    sigma = max(_SHARPEST_PX, size)
    halo = max(1.5 * sigma, _HALO_PX * focal)
    mist = 0.0 if air.is_clear else _MIST * (1 - through)
    reach = _ENDS * (_MIST_PX * focal if mist else halo)
    height, width = camera.intrinsics.height_px, camera.intrinsics.width_px
    rows = slice(max(0, int(at.v_px - reach)), min(height, int(at.v_px + reach) + 2))
    columns = slice(max(0, int(at.u_px - reach)), min(width, int(at.u_px + reach) + 2))
    v, u = np.arange(rows.start, rows.stop) - at.v_px, np.arange(columns.start, columns.stop) - at.u_px
    away = np.hypot(u, v[:, None])
    profile = np.exp(-0.5 * (away / sigma) ** 2) + _faded(away, halo, _HALO)
    if mist:
        profile += _faded(away, _MIST_PX * focal, mist)
    yield Spot((rows, columns), (profile[..., None] * (through * size / sigma * bgr)).astype(np.float32))


def _faded(away_px: FloatArray, length_px: float, level: float) -> FloatArray:
    """A halo that falls off exponentially and ends at nothing."""
    edge = np.exp(-_ENDS)
    return np.asarray(level * np.maximum(np.exp(-away_px / length_px) - edge, 0.0) / (1 - edge))
