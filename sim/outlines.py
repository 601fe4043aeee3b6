"""Convex outlines in a picture, and the samples that they cover: two numbers per row instead of a test per sample."""

from collections.abc import Sequence

import cv2
import numpy as np

from contracts import BoolArray, Camera, FloatArray
from sim.renderer import Window

NEAR_M = 0.05  # nearer than this to the camera's plane nothing is drawn
_LEVEL_PX = 1e-9  # a side that rises less is level and bounds no row


def seen_px(camera: Camera, in_camera: FloatArray) -> FloatArray:
    """Pixels (..., 2) of points (..., 3) ahead of a pinhole, in its own axes."""
    numbers = camera.intrinsics
    return np.asarray(
        in_camera[..., :2] / in_camera[..., 2:] * (numbers.fx_px, numbers.fy_px) + (numbers.cx_px, numbers.cy_px)
    )


def ahead(polygon: FloatArray) -> FloatArray:
    """The part (D, 3) of a flat convex polygon (C, 3), in a camera's axes, ahead of it (Sutherland & Hodgman 1974)."""
    if polygon[:, 2].min() >= NEAR_M:
        return polygon
    kept = []
    for point, other in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        if point[2] >= NEAR_M:
            kept.append(point)
        if (point[2] >= NEAR_M) != (other[2] >= NEAR_M):
            kept.append(point + (other - point) * ((NEAR_M - point[2]) / (other[2] - point[2])))
    return np.array(kept).reshape(-1, 3)


def hull(points_px: FloatArray) -> FloatArray:
    """Convex hull (C, 2) of points (N, 2), to 1e-4 px."""
    middle = points_px[0]  # OpenCV's hull is of single precision: stay near zero
    around = cv2.convexHull((points_px - middle).astype(np.float32))
    return np.asarray(around.reshape(-1, 2) + middle)


def window_around(camera: Camera, points_px: FloatArray) -> Window | None:
    """The part of the image that holds all ``points_px`` (N, 2) and a pixel around; None if it is empty."""
    if not len(points_px):
        return None
    (u0, v0), (u1, v1) = points_px.min(axis=0).tolist(), points_px.max(axis=0).tolist()
    width, height = camera.intrinsics.width_px, camera.intrinsics.height_px
    if u1 < -1 or v1 < -1 or u0 > width or v0 > height:
        return None
    left, right = max(0, int(max(u0, 0.0)) - 1), min(width, int(min(u1, width)) + 3)
    top, bottom = max(0, int(max(v0, 0.0)) - 1), min(height, int(min(v1, height)) + 3)
    return slice(top, bottom), slice(left, right)


def covered(outlines_px: Sequence[FloatArray], window: Window, samples_px: FloatArray) -> BoolArray:
    """Which samples of a window lie inside convex outlines, each (C, 2) in either sense: (P, S, h, w).

    samples_px: (S, 2) where pixels are looked at, from their centres.
    """
    rows, columns = window
    height, width = rows.stop - rows.start, columns.stop - columns.start
    v = (np.arange(height) + samples_px[:, 1:]).ravel()  # (S h,)
    enter, leave = _crossings(_padded(outlines_px) - (columns.start, rows.start), v)  # (P, S h)
    shift = samples_px[:, 0].repeat(height)
    first = np.ceil((enter - shift).clip(-1.0, width)).astype(np.int16)
    last = np.floor((leave - shift).clip(-1.0, width)).astype(np.int16)
    shape = (len(outlines_px), len(samples_px), height, 1)
    u = np.arange(width, dtype=np.int16)
    inside: BoolArray = u >= first.reshape(shape)
    inside &= u <= last.reshape(shape)
    return inside


def _padded(outlines_px: Sequence[FloatArray]) -> FloatArray:
    """Outlines of different length in one array (P, C, 2): the last corner again and again adds no side."""
    most = max(len(outline) for outline in outlines_px)
    padded = np.empty((len(outlines_px), most, 2))
    for row, outline in zip(padded, outlines_px, strict=True):
        row[: len(outline)] = outline
        row[len(outline) :] = outline[-1]
    return padded


def _crossings(outlines_px: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where lines of constant v (R,) enter and leave convex outlines (P, C, 2): u (P, R) each; leave < enter outside.

    Each side bounds u from the left or from the right, all along its line.
    """
    u0, v0 = outlines_px[..., 0], outlines_px[..., 1]
    u1, v1 = np.concatenate([outlines_px[:, 1:], outlines_px[:, :1]], axis=1).transpose(2, 0, 1)
    twice_area = (u0 * v1 - u1 * v0).sum(axis=1, keepdims=True)
    rise = (v1 - v0) * np.sign(twice_area)  # (P, C) > 0: the inside lies at smaller u
    bounds = np.abs(rise) > _LEVEL_PX
    slope = (u1 - u0) / np.where(bounds, v1 - v0, 1.0)
    crossing = (u0 - v0 * slope)[..., None] + slope[..., None] * v  # (P, C, R)
    enter = np.where((bounds & (rise < 0))[..., None], crossing, -np.inf).max(axis=1)
    leave = np.where((bounds & (rise > 0))[..., None], crossing, np.inf).min(axis=1)
    beside = (v < v0.min(axis=1)[:, None]) | (v > v0.max(axis=1)[:, None])
    enter[beside] = np.inf
    return enter, leave
