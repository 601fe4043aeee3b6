"""Which way a camera looks: the map's paint laid over its picture, under turns about three axes and a few lenses.

At each place where paint should lie, the picture is asked for a stroke of its width with darker ground on both sides,
or for an edge; walls, grass and kerbs rarely pass for one. Where paint repeats itself overlap alone does not tell:
many directions are given, the best first.
"""

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, FloatArray, Pose
from georef.projection import project
from perception.paint_map import PaintMap, looks_along

_FARTHEST_M, _EVERY_PX = 50.0, 8.0
_TURNS, _APART = 6, 1.5  # steps to either side; steps between two directions
_LEAST_PLACES, _MOST_PLACES = 30, 200
_LENSES, _BENDS = (0.0, -0.12), (-0.12, 0.0, 0.12)  # k1 that are tried, and how it is varied
_ROUGH_PX, _FINE_PX = np.linspace(-6.0, 6.0, 9), np.linspace(-2.5, 2.5, 5)  # how far off paint may lie
_BESIDE_PX, _BLUR_PX = 2.0, 0.8
_FULL_CONTRAST = 36.0  # levels between paint and asphalt that count as certain


@dataclass(frozen=True, eq=False)
class _Wanted:
    """What the picture is asked for. places_m: (N, 3). normals: (N, 2). half_px: (N,) of a stroke; 0 for an edge."""

    places_m: FloatArray
    normals: FloatArray
    half_px: FloatArray


def directions(
    light: NDArray[np.float32], nominal: Camera, paint: PaintMap, *, turn_rad: float, most: int
) -> list[Camera]:
    """The nominal camera, turned, and with lenses, under which the paint is there; the best first.

    light: (H, W) levels. turn_rad: largest turn about each axis. most: so many directions, all apart.
    Raises CalibrationError where the map has hardly any paint before the camera.
    """
    wanted = _wanted(nominal, paint)
    if len(wanted.places_m) < _LEAST_PLACES:
        raise CalibrationError(f'camera "{nominal.name}": hardly any paint of the map lies before it: check its place')
    smooth = np.asarray(cv2.GaussianBlur(light, (0, 0), _BLUR_PX), np.float32)
    step = turn_rad / _TURNS

    def share(k1: float, turn: FloatArray, slack_px: FloatArray) -> float:
        return _share(smooth, _turned(nominal, turn, k1), wanted, slack_px)

    rough = [(share(k1, turn, _ROUGH_PX), k1, turn) for k1 in _LENSES for turn in _grid(_TURNS) * step]
    chosen: list[tuple[float, FloatArray]] = []
    for _, k1, turn in sorted(rough, key=lambda one: -one[0]):
        if len(chosen) < most and all(np.abs(turn - other).max() > _APART * step for _, other in chosen):
            chosen.append((k1, turn))
    found = []
    for best in chosen:
        for finer in (1 / 3, 1 / 9):
            near = [(best[0] + bend * finer, best[1] + shift * finer * step) for bend in _BENDS for shift in _grid(1)]
            best = max(near, key=lambda each: share(each[0], each[1], _FINE_PX))  # noqa: PLW2901
        k1, turn = best
        found.append((share(k1, turn, _FINE_PX), _turned(nominal, turn, k1)))
    return [camera for _, camera in sorted(found, key=lambda one: -one[0])]


def _turned(camera: Camera, turn: FloatArray, k1: float) -> Camera:
    """``turn``: a rotation vector (3,) in the camera's own axes."""
    rotation = camera.pose.world_from_camera @ Rotation.from_rotvec(turn).as_matrix()
    lens = replace(camera.intrinsics, distortion=np.array([k1, 0.0, 0.0, 0.0, 0.0]))
    return replace(camera, intrinsics=lens, pose=Pose(rotation, camera.pose.position_m))


def _grid(steps: int) -> FloatArray:
    """Whole numbers from ``-steps`` to ``steps`` on three axes, (N, 3)."""
    axis = np.arange(-steps, steps + 1, dtype=np.float64)
    return np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)


def _wanted(camera: Camera, paint: PaintMap) -> _Wanted:
    looks = [looks_along(camera, line, every_px=_EVERY_PX, farthest_m=_FARTHEST_M) for line in paint.lines]
    places = np.concatenate([each.places_m for each in looks])
    normals = np.concatenate([each.normals for each in looks])
    half = np.concatenate([0.5 * each.line.width_m * each.across_px_per_m for each in looks])
    some = slice(None, None, 1 + len(places) // _MOST_PLACES)
    return _Wanted(places[some], normals[some], half[some])


def _share(light: NDArray[np.float32], camera: Camera, wanted: _Wanted, slack_px: FloatArray) -> float:
    """How much of the paint is there, within ``slack_px`` (S,) across; what lies outside of the picture is not."""
    pixels, valid = project(camera, wanted.places_m)
    height, width = light.shape
    inside = valid & (pixels > 0).all(axis=1) & (pixels < (width - 1, height - 1)).all(axis=1)
    middle, normal = pixels[inside].astype(np.float32), wanted.normals[inside].astype(np.float32)
    half = wanted.half_px[inside].astype(np.float32)
    is_stroke = half > 0
    beside = half + np.float32(_BESIDE_PX)

    def level(offset_px: NDArray[np.float32]) -> NDArray[np.float32]:
        """(K, S) at offsets (K, S) along the normals."""
        at = np.rint(middle[:, None] + offset_px[..., None] * normal[:, None]).astype(np.int32)
        return light[np.clip(at[..., 1], 0, height - 1), np.clip(at[..., 0], 0, width - 1)]

    slack = np.broadcast_to(slack_px.astype(np.float32), (len(middle), len(slack_px)))
    left, right = level(slack - beside[:, None]), level(slack + beside[:, None])
    stroke = level(slack) - np.maximum(left, right)
    contrast = np.where(is_stroke[:, None], stroke, left - right).max(axis=1)
    return float(np.clip(contrast / _FULL_CONTRAST, 0.0, 1.0).sum()) / len(wanted.places_m)
