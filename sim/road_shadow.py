"""The shadows of road users on the ground, as outlines: each convex piece of a body, thrown along the beam."""

from collections.abc import Iterator

import cv2
import numpy as np

from contracts import Camera, FloatArray, ImageArray
from sim.lights import Beam
from sim.outlines import NEAR_M, hull, seen_px

_SHIFT = 4  # bits of a pixel's fraction when polygons are filled


def thrown(points_m: FloatArray, beam: Beam, ground_m: float) -> FloatArray:
    """Where the beam through points (..., 3) meets the level ground at ``ground_m``; (..., 3)."""
    drop = (points_m[..., 2:] - ground_m) / beam.direction[2]
    return np.asarray(points_m - drop * beam.direction)


def shadow_mask(camera: Camera, pieces_m: Iterator[FloatArray]) -> ImageArray:
    """How much of each pixel the pieces cover, (H, W) uint8 to 255; each piece (P, 3) is flat and convex, world."""
    size = camera.intrinsics
    mask = np.zeros((size.height_px, size.width_px), np.uint8)
    for piece in pieces_m:
        outline = outline_px(camera, piece)
        if outline is not None:
            fixed = np.rint(outline * (1 << _SHIFT)).astype(np.int32)
            cv2.fillConvexPoly(mask, fixed, 255, cv2.LINE_AA, _SHIFT)
    return mask


def outline_px(camera: Camera, points_m: FloatArray) -> FloatArray | None:
    """Outline (C, 2) of a convex piece with corners (P, 3), through a pinhole; None unless all of it is ahead."""
    in_camera = (points_m - camera.pose.position_m) @ camera.pose.world_from_camera
    if in_camera[:, 2].min() < NEAR_M:
        return None
    return hull(seen_px(camera, in_camera))
