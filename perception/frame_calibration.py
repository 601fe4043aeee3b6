"""A camera calibrated from what it films and the map alone: no board, no picks by hand.

The owner knows about where it hangs (a nominal camera, some degrees and decimetres off, its lens unknown). First the
direction: the map's paint is laid over the paint of the picture, under turns about three axes and a few lenses, and the
best overlap is kept. Then, in rounds, each stroke and corner of the map is looked for near its image, ever closer, and
the whole camera is fitted to what was found, the wrong among it told apart by the mixture of ``georef.mixture``.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, FloatArray, Frame, Pose
from georef.camera_models import Beliefs
from georef.hd_map import HdMap
from georef.map_calibration import CameraFromMap, calibrate_near
from georef.mixture import Noise
from georef.picks import LinePicks, PointPicks
from georef.projection import project
from perception.paint_map import Looks, PaintMap, looks_along, paint_of, stretch_around
from perception.road_paint import (
    Found,
    brightness,
    corners_near,
    edges_across,
    paint_mask,
    still_picture,
    strokes_across,
)

_FARTHEST_M, _ROUGH_M = 70.0, 50.0
_EVERY_PX, _ROUGH_PX = 10.0, 6.0
_FIRST_GATE_PX, _STIFF = 12.0, 0.2
_GATES_PX = (5.0, 3.0, 3.0)
_TURNS, _STARTS, _LEAST_SAMPLES = 6, 6, 50
_GATE_M, _CORNER_GATE_M = 0.5, 0.2  # nearer than the next stroke, and the next corner, of a map
_LEAST_GATE_PX, _LEAST_CORNER_PX = 1.5, 6.0
_BARS_APART_PX_PER_M = 24.0  # along a crosswalk's side: its bars must not run into each other
_STRETCH_M = 5.0
_NARROWEST_PX = 1.2  # stroke that is still looked for
_LENSES, _BENDS = (0.0, -0.12), (-0.12, 0.0, 0.12)  # k1 that are tried, and how it is varied
_BLUR_PX, _SIDES_M = 5.0, 1.0
_NOISE = Noise(sigma_px=0.3)


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

    def fits(camera: Camera) -> int:
        """How much of the paint is found where the camera should see it."""
        points, lines = _matched(light, camera, paint, _GATES_PX[0], map_sigma_m)
        return len(points) + len(lines)

    tried: list[Camera] = []
    reasons: list[CalibrationError] = []
    for start in _turned_to_paint(light, nominal, paint, mounting):
        try:
            tried.append(fitted(start, _FIRST_GATE_PX, stiff=True).calibrated.camera)
        except CalibrationError as reason:
            reasons.append(reason)
    if not tried:
        raise reasons[0]
    camera = max(tried, key=fits)
    for gate_px in _GATES_PX[:-1]:
        camera = fitted(camera, gate_px).calibrated.camera
    return fitted(camera, _GATES_PX[-1])


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


def _turned_to_paint(light: NDArray[np.float32], nominal: Camera, paint: PaintMap, mounting: Mounting) -> list[Camera]:
    """The nominal camera, turned, and with lenses, under which the map's paint lies best on the picture's.

    Several, the best first: where paint repeats itself, overlap alone does not tell.
    """
    score = np.asarray(cv2.GaussianBlur(paint_mask(light).astype(np.float32), (0, 0), _BLUR_PX), np.float32)
    on, beside = _samples(nominal, paint)
    if len(on) < _LEAST_SAMPLES:
        raise CalibrationError(f'camera "{nominal.name}": hardly any paint of the map lies before it: check its place')

    def overlap(camera: Camera) -> float:
        return _overlap(score, camera, on) - _overlap(score, camera, beside)

    step = mounting.turn_rad / _TURNS
    turns = _grid(_TURNS) * step
    rough = [(overlap(_turned(nominal, turn, k1)), k1, turn) for k1 in _LENSES for turn in turns]
    chosen: list[tuple[float, FloatArray]] = []
    for _, k1, turn in sorted(rough, key=lambda one: -one[0]):
        if all(np.abs(turn - other).max() > 1.5 * step for _, other in chosen):
            chosen.append((k1, turn))
        if len(chosen) == _STARTS:
            break
    found = []
    for best in chosen:
        for share in (1 / 3, 1 / 9):
            k1, turn = best
            near = [(k1 + bend * share, turn + shift * share * step) for bend in _BENDS for shift in _grid(2)]
            best = max(near, key=lambda each: overlap(_turned(nominal, each[1], each[0])))  # noqa: PLW2901
        found.append(_turned(nominal, best[1], best[0]))
    return found


def _grid(steps: int) -> FloatArray:
    """Whole numbers from ``-steps`` to ``steps`` on three axes, (N, 3)."""
    axis = np.arange(-steps, steps + 1, dtype=np.float64)
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def _turned(camera: Camera, turn: FloatArray, k1: float) -> Camera:
    """``turn``: a rotation vector (3,) in the camera's own axes."""
    rotation = camera.pose.world_from_camera @ Rotation.from_rotvec(turn).as_matrix()
    lens = replace(camera.intrinsics, distortion=np.array([k1, 0.0, 0.0, 0.0, 0.0]))
    return replace(camera, intrinsics=lens, pose=Pose(rotation, camera.pose.position_m))


def _samples(camera: Camera, paint: PaintMap) -> tuple[FloatArray, FloatArray]:
    """Places (N, 3) on the map's paint, evenly over the image, and others (M, 3) a metre beside it."""
    on, beside = [], []
    for line in paint.lines:
        looks = looks_along(camera, line, every_px=_ROUGH_PX, farthest_m=_ROUGH_M)
        places, side = looks.places_m, _SIDES_M * looks.right
        is_stroke = line.width_m > 0
        on.append(places if is_stroke else places - side)
        beside += [places + side, places - side] if is_stroke else [places + side]
    return np.concatenate(on), np.concatenate(beside)


def _overlap(score: NDArray[np.float32], camera: Camera, places_m: FloatArray) -> float:
    """Mean of the blurred paint under the images of places (N, 3); outside of the picture it is 0."""
    pixels, valid = project(camera, places_m)
    height, width = score.shape
    columns, rows = np.nan_to_num(np.rint(pixels), nan=-1.0).astype(np.int64).T
    inside = valid & (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
    return float(score[rows[inside], columns[inside]].sum()) / len(places_m)


def _matched(
    light: NDArray[np.float32], camera: Camera, paint: PaintMap, gate_px: float, map_sigma_m: float
) -> tuple[PointPicks, LinePicks]:
    """Corners and pixels on lines that are found near where ``camera`` should see them."""
    names: list[str] = []
    pixels: list[FloatArray] = []
    courses: list[FloatArray] = []
    for line in paint.lines:
        looks = looks_along(camera, line, every_px=_EVERY_PX, farthest_m=_FARTHEST_M)
        found = _on_line(light, looks, gate_px)
        names += int(found.seen.sum()) * [line.name]
        pixels.append(found.pixels[found.seen])
        courses += [stretch_around(line.points_m, place, _STRETCH_M) for place in looks.places_m[found.seen]]
    lines = LinePicks(tuple(names), np.concatenate(pixels), tuple(courses), np.full(len(names), map_sigma_m))
    return _corners(light, camera, paint, gate_px, map_sigma_m), lines


def _on_line(light: NDArray[np.float32], looks: Looks, gate_px: float) -> Found:
    """One row for each place of ``looks``."""
    reach = np.clip(_GATE_M * looks.across_px_per_m, 0.0, gate_px)
    width = looks.line.width_m * looks.across_px_per_m
    is_stroke = looks.line.width_m > 0.0
    clear = width > _NARROWEST_PX if is_stroke else looks.along_px_per_m > _BARS_APART_PX_PER_M
    rows = np.flatnonzero((reach > _LEAST_GATE_PX) & clear)
    asked = light, looks.pixels[rows], looks.normals[rows]
    found = strokes_across(*asked, width[rows], reach[rows]) if is_stroke else edges_across(*asked, reach[rows])
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
