"""World points into pixels, by OpenCV: the simulator's own projection, which shares no code with ``georef``."""

from functools import lru_cache

import cv2
import numpy as np

from contracts import BoolArray, Camera, FloatArray, Intrinsics

_FIELD_MARGIN = 2.0  # the lens is trusted up to this multiple of the radius at the image's farthest corner


def project(camera: Camera, points_m: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Images of world points.

    points_m: (..., 3) world.
    Returns pixels (..., 2) and valid (...): False, and NaN, behind the camera and so far outside of the image that
    the lens polynomial folds back on itself (Brown 1971 holds inside the field only).
    """
    points = np.asarray(points_m, dtype=np.float64)
    camera_from_world = camera.pose.world_from_camera.T
    in_camera = (points - camera.pose.position_m) @ camera_from_world.T  # (..., 3)
    depth = in_camera[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.hypot(in_camera[..., 0], in_camera[..., 1]) / depth
        valid = (depth > 1e-6) & (radius < trusted_radius(camera.intrinsics))
    pixels = np.full((*points.shape[:-1], 2), np.nan)
    if valid.any():
        pixels[valid] = cv2.projectPoints(
            in_camera[valid], np.zeros(3), np.zeros(3), camera.intrinsics.matrix, camera.intrinsics.distortion
        )[0].reshape(-1, 2)
    return pixels, valid


def undistorted(intrinsics: Intrinsics, pixels: FloatArray) -> FloatArray:
    """Normalised pinhole coordinates x/z, y/z of pixels (N, 2), the lens taken out; (N, 2)."""
    # the default of five iterations leaves 0.01 px at the corners of a wide lens
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
    points = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
    straight = cv2.undistortPoints(
        points, intrinsics.matrix, intrinsics.distortion, None, np.eye(3), np.eye(3), criteria
    )
    return np.asarray(straight, np.float64).reshape(-1, 2)


@lru_cache(maxsize=64)  # the same few cameras, every frame
def trusted_radius(intrinsics: Intrinsics) -> float:
    """Largest distance from the axis, in normalised coordinates, at which the lens model may be used."""
    width, height = intrinsics.width_px, intrinsics.height_px
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float64)
    farthest = float(np.linalg.norm(undistorted(intrinsics, corners), axis=1).max())
    k1, k2, _, _, k3 = intrinsics.distortion
    radii = np.linspace(0.0, _FIELD_MARGIN * farthest, 256)
    slope = 1 + 3 * k1 * radii**2 + 5 * k2 * radii**4 + 7 * k3 * radii**6  # d/dr of r (1 + k1 r2 + k2 r4 + k3 r6)
    folded = np.flatnonzero(slope <= 0.0)
    return float(radii[folded[0] - 1] if folded.size else radii[-1])
