"""Non-linear least squares over cameras: Levenberg-Marquardt with a caller's own way to move."""

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, FloatArray, Intrinsics, Pose

State = TypeVar("State")

_MAX_STEPS = 60
_MAX_DAMPING = 1e12


def refine(
    start: State,
    linearise: Callable[[State], tuple[FloatArray, FloatArray]],
    move: Callable[[State, FloatArray], State],
) -> tuple[State, FloatArray, FloatArray]:
    """The state with the least sum of squared residuals near ``start``.

    linearise: residuals (n,) and their jacobian (n, p); NaN residuals mark a state out of the model's domain.
    move: the state after a step (p,).
    Returns the state, its residuals and jacobian.
    Raises CalibrationError if it does not converge. Source: Marquardt 1963; Nocedal & Wright 2006, section 10.3.
    """
    state, damping = start, 1e-4
    residuals, jacobian = linearise(state)
    if not np.isfinite(residuals).all():
        raise CalibrationError("the refinement starts outside the camera model's domain")
    for _ in range(_MAX_STEPS):
        normal, gradient = jacobian.T @ jacobian, jacobian.T @ residuals
        scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
        scaled = normal * np.outer(scale, scale)
        while True:
            factor = cho_factor(scaled + damping * np.eye(len(scale)))
            step = -scale * cho_solve(factor, scale * gradient)
            candidate = move(state, step)
            new_residuals, new_jacobian = linearise(candidate)
            gain = float(residuals @ residuals - new_residuals @ new_residuals)  # NaN counts as no gain
            if gain >= 0 or damping > _MAX_DAMPING:
                break
            damping *= 10.0
        if not gain >= 0:
            return state, residuals, jacobian  # no step of any size improves it: at the minimum to rounding
        state, residuals, jacobian = candidate, new_residuals, new_jacobian
        damping = max(damping * 0.1, 1e-15)
        if gain <= 1e-12 * float(residuals @ residuals) + 1e-18:
            return state, residuals, jacobian
    raise CalibrationError(f"the refinement did not converge in {_MAX_STEPS} steps")


def inverse_normal(jacobian: FloatArray) -> FloatArray:
    """(J^T J)^-1, (p, p): the covariance of a least-squares solution whose residuals have unit variance.

    Raises CalibrationError where the observations leave a direction of the parameters open.
    """
    normal = jacobian.T @ jacobian
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = normal * np.outer(scale, scale)
    if np.linalg.cond(scaled) > 1e13:
        raise CalibrationError("the observations do not determine all parameters of the camera")
    inverse = np.linalg.inv(scaled) * np.outer(scale, scale)
    return 0.5 * (inverse + inverse.T)


def moved_intrinsics(intrinsics: Intrinsics, step: FloatArray) -> Intrinsics:
    """Intrinsics after a step (9,) in fx, fy, cx, cy, k1, k2, p1, p2, k3."""
    fx, fy, cx, cy = np.array([intrinsics.fx_px, intrinsics.fy_px, intrinsics.cx_px, intrinsics.cy_px]) + step[:4]
    focal = max(float(fx), 1.0), max(float(fy), 1.0)  # a wild step is refused by its residuals, not by an exception
    return Intrinsics(
        intrinsics.width_px, intrinsics.height_px, *focal, float(cx), float(cy), intrinsics.distortion + step[4:]
    )


def moved_pose(pose: Pose, step: FloatArray) -> Pose:
    """Pose after a step (6,): a rotation vector in world axes from the left, then metres."""
    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    return Pose(turn @ pose.world_from_camera, pose.position_m + step[3:])


def moved_camera(camera: Camera, step: FloatArray) -> Camera:
    """Camera after a step (15,) in ``georef.calibrated.PARAMETERS``."""
    return Camera(camera.name, moved_intrinsics(camera.intrinsics, step[:9]), moved_pose(camera.pose, step[9:]))
