"""Where light falls: points in the picture, followed along a beam to the ground."""

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from sim.lights import Beam

_HORIZON_M = 60.0  # farther ground is not looked at


def world_points(camera: Camera, depth_m: NDArray[np.float32], *, top_px: int = 0, left_px: int = 0) -> FloatArray:
    """What each pixel of a pinhole shows, (H, W, 3) world, from its depth (H, W) along the axis.

    top_px, left_px: where in the image these pixels are.
    """
    height, width = depth_m.shape
    numbers = camera.intrinsics
    x = (np.arange(left_px, left_px + width) - numbers.cx_px) / numbers.fx_px
    y = (np.arange(top_px, top_px + height) - numbers.cy_px) / numbers.fy_px
    in_camera = np.stack([depth_m * x, depth_m * y[:, None], depth_m], axis=-1)  # (H, W, 3)
    return np.asarray(in_camera @ camera.pose.world_from_camera.T + camera.pose.position_m)


def points_at(camera: Camera, u_px: FloatArray, v_px: FloatArray, depth_m: NDArray[np.float32]) -> FloatArray:
    """What single places (N,) of a pinhole's picture show, (N, 3) world, from their depth (N,) along the axis."""
    numbers = camera.intrinsics
    x, y = (u_px - numbers.cx_px) / numbers.fx_px, (v_px - numbers.cy_px) / numbers.fy_px
    in_camera = np.column_stack([depth_m * x, depth_m * y, depth_m])
    return np.asarray(in_camera @ camera.pose.world_from_camera.T + camera.pose.position_m)


def along_beam(points_m: FloatArray, beam: Beam) -> FloatArray:
    """Where the beam through each point (..., 3) meets the ground, (..., 2)."""
    direction = beam.direction
    return np.asarray(points_m[..., :2] - points_m[..., 2:] * (direction[:2] / direction[2]))


def mixed(lit: ImageArray, unlit: ImageArray, shade: FloatArray) -> ImageArray:
    """Between two pictures (H, W, 3): ``lit`` where ``shade`` (H, W) is 0, ``unlit`` where it is 1."""
    weight = shade[..., None].astype(np.float32)
    return np.rint(lit + (unlit.astype(np.float32) - lit) * weight).astype(np.uint8)


def ground_in_view(camera: Camera) -> tuple[FloatArray, float]:
    """Centre (3,) and radius in metres of a circle around the ground that a pinhole sees."""
    numbers = camera.intrinsics
    u, v = np.array([[-0.5, -0.5], [1, -0.5], [-0.5, 1], [1, 1]]).T
    corners = np.column_stack(
        [
            (np.where(u > 0, numbers.width_px - 0.5, u) - numbers.cx_px) / numbers.fx_px,
            (np.where(v > 0, numbers.height_px - 0.5, v) - numbers.cy_px) / numbers.fy_px,
            np.ones(4),
        ]
    )
    rays = corners @ camera.pose.world_from_camera.T  # (4, 3)
    position = camera.pose.position_m
    reach = position[2] / np.maximum(-rays[:, 2], position[2] / _HORIZON_M)
    ground = position + rays * reach[:, None]
    ground[:, 2] = 0.0
    centre = (ground.min(axis=0) + ground.max(axis=0)) / 2
    return centre, float(np.hypot(*(ground - centre)[:, :2].T).max())
