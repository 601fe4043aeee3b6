"""A camera calibrated from what it films and the map alone: no board, no picks by hand.

The owner knows about where it hangs (a nominal camera, some degrees and decimetres off, its lens unknown). First the
direction: ``perception.paint_search`` lays the map's paint over the picture. Then, in rounds, each stroke, end and
corner of the map is looked for near its image, ever closer, and the whole camera is fitted to what was found, the wrong
among it told apart by the mixture of ``georef.mixture``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import CalibrationError, Camera, FloatArray, Frame, IntArray
from georef.camera_models import Beliefs
from georef.hd_map import HdMap
from georef.map_calibration import CameraFromMap, calibrate_near
from georef.mixture import Noise
from georef.picks import LinePicks, PointPicks
from georef.projection import project
from perception.paint_map import Looks, PaintMap, looks_along, paint_of, stretch_around
from perception.paint_search import directions
from perception.road_paint import (
    Found,
    brightness,
    corners_near,
    edges_across,
    still_picture,
    strokes_across,
)

_FARTHEST_M, _EVERY_PX = 70.0, 6.0
_FIRST_GATE_PX, _STIFF = 12.0, 0.2
_GATES_PX = (5.0, 3.0, 3.0)
_STARTS = 6
_LEAST_SHARE, _CLEAR_SHARE = 0.4, 0.6  # of the paint, to be believed, and to look no further
_GATE_M, _CORNER_GATE_M = 0.5, 0.2  # nearer than the next stroke, and the next corner, of a map
_LEAST_GATE_PX, _LEAST_CORNER_PX = 1.5, 6.0
_BARS_APART_PX_PER_M = 24.0  # along a crosswalk's side: its bars must not run into each other
_ENDS_PX_PER_M = 15.0  # along the bar or the dash that ends
_STRETCH_M = 5.0
_UNEVEN, _VERY_UNEVEN = 0.12, 1.0  # sides of a stroke that is measured, and of one that is only counted
_NARROWEST_PX = 1.2  # stroke that is still looked for
_NOISE = Noise(sigma_px=0.15)


@dataclass(frozen=True)
class Mounting:
    """How far a camera may hang from where its owner believes.

    turn_rad: largest rotation. Standard deviations: position_sigma_m, per axis; focal_share of the focal length;
    principal_point_share of the image's width; k1, k2 of the lens about none.
    """

    turn_rad: float = float(np.radians(3.5))
    position_sigma_m: float = 0.08
    focal_share: float = 0.005
    principal_point_share: float = 0.008
    k1: float = 0.15
    k2: float = 0.05


_USUAL = Mounting()


def calibrate_from_frames(
    frames: Sequence[Frame], nominal: Camera, hd_map: HdMap, *, map_sigma_m: float = 0.0, mounting: Mounting = _USUAL
) -> CameraFromMap:
    """The whole camera from frames of it and the map.

    nominal: where its owner believes it to hang. map_sigma_m: standard deviation of the map's features, per axis.
    Raises CalibrationError, with the reason, where too little paint is found.
    """
    light = brightness(still_picture(frames))
    paint = paint_of(hd_map)

    def fitted(camera: Camera, gate_px: float, *, stiff: bool = False) -> CameraFromMap:
        points, lines = _matched(light, camera, paint, gate_px, map_sigma_m)
        beliefs = _beliefs(nominal, mounting, _STIFF if stiff else 1.0)
        return calibrate_near(camera, points, lines, start_noise_px=gate_px / 3, noise=_NOISE, beliefs=beliefs)

    tried: list[tuple[float, Camera]] = []
    reasons: list[CalibrationError] = []
    for start in directions(light, nominal, paint, turn_rad=mounting.turn_rad, most=_STARTS):
        try:
            camera = fitted(start, _FIRST_GATE_PX, stiff=True).calibrated.camera
            tried.append((_share_found(light, camera, paint), camera))
            if tried[-1][0] > _CLEAR_SHARE:
                break
        except CalibrationError as reason:
            reasons.append(reason)
    if not tried:
        raise reasons[0]
    share, camera = max(tried, key=lambda one: one[0])
    if share < _LEAST_SHARE:
        raise CalibrationError(
            f'camera "{nominal.name}": at best {share:.0%} of the paint shows where a camera near its place '
            f"would see it; {_LEAST_SHARE:.0%} are needed: check its place, the map and the light"
        )
    for gate_px in _GATES_PX[:-1]:
        camera = fitted(camera, gate_px).calibrated.camera
    return fitted(camera, _GATES_PX[-1])


def _share_found(light: NDArray[np.float32], camera: Camera, paint: PaintMap) -> float:
    """How much of the paint that ``camera`` should see is found there."""
    asked = found = 0
    for line in paint.lines:
        looks = looks_along(camera, line, every_px=_EVERY_PX, farthest_m=_FARTHEST_M)
        asked += len(_clear(looks, _GATES_PX[0]))
        found += int(_on_line(light, looks, _GATES_PX[0], uneven=_VERY_UNEVEN).seen.sum())
    return found / max(asked, 1)


def _beliefs(nominal: Camera, mounting: Mounting, share: float) -> Beliefs:
    """share: of the mounting's standard deviations; less lets the camera turn and bend, but hardly do anything else."""
    east, north, up = nominal.pose.position_m.tolist()
    return Beliefs(
        position_m=(east, north, up),
        position_sigma_m=share * mounting.position_sigma_m,
        focal_px=nominal.intrinsics.fx_px,
        focal_share=share * mounting.focal_share,
        principal_point_share=share * mounting.principal_point_share,
        k1=mounting.k1,
        k2=share * mounting.k2,
    )


def _matched(
    light: NDArray[np.float32], camera: Camera, paint: PaintMap, gate_px: float, map_sigma_m: float
) -> tuple[PointPicks, LinePicks]:
    """Corners and pixels on lines that are found near where ``camera`` should see them."""
    names: list[str] = []
    pixels: list[FloatArray] = []
    courses: list[FloatArray] = []
    sigmas_m: list[FloatArray] = []
    for line in paint.lines:
        looks = looks_along(camera, line, every_px=_EVERY_PX, farthest_m=_FARTHEST_M)
        found = _on_line(light, looks, gate_px)
        names += int(found.seen.sum()) * [line.name]
        pixels.append(found.pixels[found.seen])
        courses += [stretch_around(line.course_m, place, _STRETCH_M) for place in looks.places_m[found.seen]]
        sigmas_m.append(np.hypot(map_sigma_m, line.sigma_px / looks.across_px_per_m[found.seen]))
    lines = LinePicks(tuple(names), np.concatenate(pixels), tuple(courses), np.concatenate(sigmas_m))
    return _corners(light, camera, paint, gate_px, map_sigma_m), lines


def _reach_px(looks: Looks, gate_px: float) -> FloatArray:
    return np.clip(_GATE_M * looks.across_px_per_m, 0.0, gate_px)


def _clear(looks: Looks, gate_px: float) -> IntArray:
    """Rows of ``looks`` that the picture is sharp enough to tell."""
    is_wide = looks.line.width_m * looks.across_px_per_m > _NARROWEST_PX
    is_apart = (looks.along_px_per_m > _BARS_APART_PX_PER_M) & (looks.across_px_per_m > _ENDS_PX_PER_M)
    clear = is_wide if looks.line.width_m > 0.0 else is_apart
    return np.flatnonzero((_reach_px(looks, gate_px) > _LEAST_GATE_PX) & clear)


def _on_line(light: NDArray[np.float32], looks: Looks, gate_px: float, *, uneven: float = _UNEVEN) -> Found:
    """One row for each place of ``looks``."""
    rows = _clear(looks, gate_px)
    reach, width = _reach_px(looks, gate_px)[rows], (looks.line.width_m * looks.across_px_per_m)[rows]
    asked = light, looks.pixels[rows], looks.normals[rows]
    if looks.line.width_m > 0.0:
        found = strokes_across(*asked, width, reach, uneven=uneven)
    else:
        found = edges_across(*asked, reach)
    pixels = np.full((len(looks.pixels), 2), np.nan)
    pixels[rows] = found.pixels
    return Found(pixels, np.isfinite(pixels[:, 0]))


def _corners(
    light: NDArray[np.float32], camera: Camera, paint: PaintMap, gate_px: float, map_sigma_m: float
) -> PointPicks:
    pixels, valid = project(camera, paint.corners_m)
    away = np.linalg.norm(paint.corners_m - camera.pose.position_m, axis=1)
    apart_px = _CORNER_GATE_M * camera.intrinsics.fx_px / np.maximum(away, 1e-6)
    rows = np.flatnonzero(valid & (apart_px > _LEAST_CORNER_PX))
    found = corners_near(light, pixels[rows], np.minimum(apart_px[rows], gate_px))
    kept = rows[found.seen]
    names = tuple(paint.corner_names[row] for row in kept)
    return PointPicks(names, found.pixels[found.seen], paint.corners_m[kept], np.full(len(kept), map_sigma_m))
