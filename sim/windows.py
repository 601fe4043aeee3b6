"""Parts of a picture: around what may be seen, merged where they meet, and looked through alone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from contracts import Camera, FloatArray
from sim.outlines import NEAR_M, seen_px, window_around
from sim.renderer import Window


def window_of(camera: Camera, points_m: FloatArray) -> Window | None:
    """The part of a pinhole's picture that shows whatever lies within points (N, 3), world; None if none does."""
    in_camera = (points_m - camera.pose.position_m) @ camera.pose.world_from_camera
    ahead = in_camera[:, 2] >= NEAR_M
    if ahead.all():
        return window_around(camera, seen_px(camera, in_camera))
    if not ahead.any():
        return None
    return slice(0, camera.intrinsics.height_px), slice(0, camera.intrinsics.width_px)


def apart(windows: Sequence[Window]) -> list[Window]:
    """The same parts, those that meet as one, so that no two overlap."""
    kept: list[Window] = []
    for window in windows:
        merged = window
        while meeting := [other for other in kept if meet(merged, other)]:
            kept = [other for other in kept if other not in meeting]
            merged = enclosing([merged, *meeting])
        kept.append(merged)
    return kept


def enclosing(windows: Sequence[Window]) -> Window:
    """The smallest part that holds all of them; at least one."""
    return (
        slice(min(rows.start for rows, _ in windows), max(rows.stop for rows, _ in windows)),
        slice(min(columns.start for _, columns in windows), max(columns.stop for _, columns in windows)),
    )


def inside(window: Window, around: Window) -> Window:
    """Where ``window`` lies in a picture of ``around`` alone."""
    (rows, columns), (top, left) = window, (around[0].start, around[1].start)
    return slice(rows.start - top, rows.stop - top), slice(columns.start - left, columns.stop - left)


def cropped(camera: Camera, window: Window) -> Camera:
    """A pinhole that sees only this part of the picture."""
    rows, columns = window
    part = replace(
        camera.intrinsics,
        width_px=columns.stop - columns.start,
        height_px=rows.stop - rows.start,
        cx_px=camera.intrinsics.cx_px - columns.start,
        cy_px=camera.intrinsics.cy_px - rows.start,
        distortion=np.zeros(5),
    )
    return replace(camera, intrinsics=part)


def meet(one: Window, other: Window) -> bool:
    """Whether they have a pixel in common."""
    return all(a.start < b.stop and b.start < a.stop for a, b in zip(one, other, strict=True))


def common(one: Window, other: Window) -> Window:
    """What two parts that meet share."""
    rows, columns = (slice(max(a.start, b.start), min(a.stop, b.stop)) for a, b in zip(one, other, strict=True))
    return rows, columns
