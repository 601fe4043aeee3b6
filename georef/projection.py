"""World points to pixels and pixels to rays, with analytic derivatives.

    point_in_camera = world_from_camera^T (point_in_world - position)
    pixel = K distort(x / z, y / z)

Source: Hartley & Zisserman 2004, section 6.1; lens: ``georef.lens``.
"""

from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, Camera, FloatArray, Intrinsics
from georef import lens
from georef.calibrated import PARAMETERS


@dataclass(frozen=True, eq=False)
class Projection:
    """Pixels with their derivatives.

    pixels: (..., 2); NaN where not valid.
    valid: (...) in front of the camera and before the lens folds.
    by_parameters: (..., 2, 15) with respect to ``georef.calibrated.PARAMETERS``.
    by_point: (..., 2, 3) with respect to the world point, px per metre.
    """

    pixels: FloatArray
    valid: BoolArray
    by_parameters: FloatArray
    by_point: FloatArray


def project(camera: Camera, points_m: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Image world points.

    points_m: (..., 3) world.
    Returns pixels (..., 2), first pixel's centre at (0, 0), and valid (...): False, with NaN pixels, behind the camera
    and where the lens folds. Points outside the image's frame are valid.
    """
    in_camera = _in_camera(camera, points_m)
    normalised, valid = _normalise(camera.intrinsics, in_camera)
    return _to_pixels(camera.intrinsics, lens.distort(camera.intrinsics.distortion, normalised)), valid


def project_with_derivatives(camera: Camera, points_m: FloatArray) -> Projection:
    """``project`` with the derivatives of each pixel by the camera's 15 parameters and by the point."""
    intrinsics, camera_from_world = camera.intrinsics, camera.pose.world_from_camera.T
    from_position = np.asarray(points_m, dtype=np.float64) - camera.pose.position_m
    in_camera = _in_camera(camera, points_m)
    normalised, valid = _normalise(intrinsics, in_camera)
    bent = lens.distort(intrinsics.distortion, normalised)
    focal = np.array([intrinsics.fx_px, intrinsics.fy_px])
    by_normalised = focal[:, None] * lens.distort_by_point(intrinsics.distortion, normalised)  # (..., 2, 2)
    by_camera = by_normalised @ _normalised_by_point(normalised, in_camera[..., 2])  # (..., 2, 3)
    by_point = by_camera @ camera_from_world

    by_parameters = np.zeros((*valid.shape, 2, len(PARAMETERS)))
    by_parameters[..., 0, 0] = bent[..., 0]
    by_parameters[..., 1, 1] = bent[..., 1]
    by_parameters[..., 0, 2] = by_parameters[..., 1, 3] = 1.0
    by_parameters[..., 4:9] = focal[:, None] * lens.distort_by_lens(normalised)
    by_parameters[..., 9:12] = by_point @ cross_matrix(from_position)  # exp(-[r]) d = d + [d] r + ...
    by_parameters[..., 12:15] = -by_point
    return Projection(_to_pixels(intrinsics, bent), valid, by_parameters, by_point)


def undistort(intrinsics: Intrinsics, pixels: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Normalised, straight image points (..., 2) of ``pixels`` (..., 2), and valid (...).

    False, with NaN, where no ray before the lens's fold meets the pixel. Exact to 1e-10 px.
    """
    focal = np.array([intrinsics.fx_px, intrinsics.fy_px])
    centre = np.array([intrinsics.cx_px, intrinsics.cy_px])
    return lens.undistort(intrinsics.distortion, (np.asarray(pixels, dtype=np.float64) - centre) / focal)


def rays(camera: Camera, pixels: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Unit directions in the world (..., 3) of the rays through ``pixels`` (..., 2), and valid (...).

    All rays start at ``camera.pose.position_m``; NaN where not valid, see ``undistort``.
    """
    normalised, valid = undistort(camera.intrinsics, pixels)
    in_camera = np.concatenate([normalised, np.ones((*valid.shape, 1))], axis=-1)
    in_camera /= np.linalg.norm(in_camera, axis=-1, keepdims=True)
    return np.where(valid[..., None], in_camera @ camera.pose.world_from_camera.T, np.nan), valid


def cross_matrix(vectors: FloatArray) -> FloatArray:
    """[v] with [v] w = v x w: (..., 3) to (..., 3, 3)."""
    x, y, z = np.moveaxis(np.asarray(vectors, dtype=np.float64), -1, 0)
    zero = np.zeros_like(x)
    rows = [np.stack(row, axis=-1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))]
    return np.stack(rows, axis=-2)


def _in_camera(camera: Camera, points_m: FloatArray) -> FloatArray:
    from_position = np.asarray(points_m, dtype=np.float64) - camera.pose.position_m
    in_camera: FloatArray = from_position @ camera.pose.world_from_camera  # rows: world_from_camera^T d
    return in_camera


def _normalise(intrinsics: Intrinsics, in_camera: FloatArray) -> tuple[FloatArray, BoolArray]:
    depth = in_camera[..., 2]
    ahead: BoolArray = depth > 0
    normalised = in_camera[..., :2] / np.where(ahead, depth, np.nan)[..., None]
    valid = ahead & lens.before_fold(intrinsics.distortion, normalised)
    return np.where(valid[..., None], normalised, np.nan), valid


def _normalised_by_point(normalised: FloatArray, depth: FloatArray) -> FloatArray:
    """Derivative of (x / z, y / z) by (x, y, z): (..., 2, 3)."""
    jacobian = np.zeros((*depth.shape, 2, 3))
    jacobian[..., 0, 0] = jacobian[..., 1, 1] = 1.0
    jacobian[..., 2] = -normalised
    return jacobian / depth[..., None, None]


def _to_pixels(intrinsics: Intrinsics, bent: FloatArray) -> FloatArray:
    focal = np.array([intrinsics.fx_px, intrinsics.fy_px])
    pixels: FloatArray = bent * focal + np.array([intrinsics.cx_px, intrinsics.cy_px])
    return pixels
