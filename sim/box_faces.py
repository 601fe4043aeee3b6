"""The faces that a camera sees of a box, and how near they are."""

from dataclasses import dataclass

import numpy as np

from contracts import Camera, FloatArray
from sim.box_rays import CORNERS, Array32, Box
from sim.outlines import NEAR_M, ahead, seen_px
from sim.renderer import Window

_RIM = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])  # of a face, along its own two axes


def _corners_of(axis: int, side: int) -> list[int]:
    """Rows of ``CORNERS`` around a face."""
    signs = np.full((4, 3), side)
    signs[:, [axis - 2, axis - 1]] = _RIM
    return [int(np.flatnonzero((corner == CORNERS).all(axis=1))[0]) for corner in signs]


_FACES = {(axis, side): _corners_of(axis, side) for axis in range(3) for side in (-1, 1)}


@dataclass(frozen=True, eq=False)
class Faces:
    """The faces of one box that a pinhole sees; at most one per axis.

    axes: the axis of the box that each face stands on. outlines_px: each (C, 2), convex.
    nearness: (F, 3); with (a, b, c) of a face, one over its depth in metres is a u + b v + c.
    """

    axes: tuple[int, ...]
    outlines_px: tuple[FloatArray, ...]
    nearness: FloatArray

    @property
    def points_px(self) -> FloatArray:
        """All corners, (N, 2)."""
        return np.concatenate([np.empty((0, 2)), *self.outlines_px])


def faces_of(box: Box, camera: Camera) -> Faces:
    """The faces of ``box`` that look at ``camera`` and lie ahead of it."""
    numbers, turn = camera.intrinsics, camera.pose.world_from_camera
    in_camera = (box.corners_m - camera.pose.position_m) @ turn  # (8, 3)
    if in_camera[:, 2].min() >= NEAR_M:
        corners_px, whole = seen_px(camera, in_camera), True
    elif in_camera[:, 2].max() >= NEAR_M:
        corners_px, whole = in_camera, False
    else:
        return Faces((), (), np.empty((0, 3)))
    eye = (camera.pose.position_m - box.centre_m) @ box.world_from_box  # in the box's axes
    normals = (box.world_from_box.T @ turn).tolist()  # in the camera's axes
    axes, outlines, nearness = [], [], []
    for axis, (at, half) in enumerate(zip(eye.tolist(), box.half_m.tolist(), strict=True)):
        side = 1 if at > 0 else -1
        rim = corners_px[_FACES[axis, side]]
        outline = rim if whole else seen_px(camera, ahead(rim))
        if abs(at) > half and len(outline):
            scale = -side / (abs(at) - half)
            a, b, c = (scale * part for part in normals[axis])
            a, b = a / numbers.fx_px, b / numbers.fy_px
            axes.append(axis)
            outlines.append(outline)
            nearness.append((a, b, c - a * numbers.cx_px - b * numbers.cy_px))
    return Faces(tuple(axes), tuple(outlines), np.array(nearness).reshape(-1, 3))


def nearness_in(faces: Faces, window: Window, samples_px: FloatArray) -> Array32:
    """One over the depth of a box at each sample of a window that it covers, (S, h, w); elsewhere it means nothing.

    A ray enters a convex body where it has met the last of the faces that look at it.
    """
    rows, columns = window
    u = np.arange(columns.start, columns.stop) + samples_px[:, :1]  # (S, w)
    v = np.arange(rows.start, rows.stop) + samples_px[:, 1:]  # (S, h)
    entry: Array32 | None = None
    for a, b, c in faces.nearness.tolist():
        near = (a * u).astype(np.float32)[:, None, :] + (b * v + c).astype(np.float32)[:, :, None]
        entry = near if entry is None else np.minimum(entry, near, out=entry)
    assert entry is not None
    return entry
