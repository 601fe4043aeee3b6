"""Pixels to the ground and back with OpenCV's own functions: the score does not rely on the code that it judges."""

import cv2
import numpy as np

from contracts import Camera, FloatArray

_ITERATE = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-14)


def to_plane(camera: Camera, pixels: FloatArray, heights_m: FloatArray) -> FloatArray:
    """Where the rays through ``pixels`` (N, 2) meet horizontal planes at ``heights_m`` (N,); (N, 2) east, north.

    NaN for a ray that does not meet its plane.
    """
    lens = camera.intrinsics
    points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
    if not len(points):
        return np.empty((0, 2))
    normalised = cv2.undistortPoints(points, lens.matrix, lens.distortion, criteria=_ITERATE).reshape(-1, 2)
    in_camera = np.column_stack([normalised, np.ones(len(normalised))])  # (N, 3)
    directions = in_camera @ camera.pose.world_from_camera.T  # (N, 3) in the world
    drop_m = heights_m - camera.pose.position_m[2]  # (N,)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = drop_m / directions[:, 2]
    reach = np.where(np.isfinite(reach) & (reach > 0), reach, np.nan)
    on_ground: FloatArray = camera.pose.position_m[:2] + reach[:, None] * directions[:, :2]
    return on_ground


def to_pixels(camera: Camera, points_m: FloatArray) -> FloatArray:
    """Images of world points (N, 3) in front of the camera; (N, 2) px."""
    camera_from_world = camera.pose.world_from_camera.T
    lens = camera.intrinsics
    rotation, _ = cv2.Rodrigues(camera_from_world)
    translation = -camera_from_world @ camera.pose.position_m
    points = np.ascontiguousarray(points_m, dtype=np.float64).reshape(-1, 1, 3)
    pixels, _ = cv2.projectPoints(points, rotation, translation, lens.matrix, lens.distortion)
    return np.asarray(pixels, dtype=np.float64).reshape(-1, 2)
