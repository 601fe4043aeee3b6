"""Non-linear least squares over cameras: Levenberg-Marquardt with a caller's own way to move."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, FloatArray, Intrinsics, Pose

State = TypeVar("State")


@dataclass(frozen=True, eq=False)
class Linear:
    """A least-squares problem made linear at one state.

    residuals: (n,); NaN marks a state outside the model's domain.
    normal, gradient: J^T J (p, p) and J^T residuals (p,) of the residuals' jacobian J (n, p), which need not be formed.
    """

    residuals: FloatArray
    normal: FloatArray
    gradient: FloatArray

    @classmethod
    def of(cls, residuals: FloatArray, jacobian: FloatArray) -> "Linear":
        """From a jacobian (n, p)."""
        return cls(residuals, jacobian.T @ jacobian, jacobian.T @ residuals)

    @property
    def cost(self) -> float:
        """Sum of squared residuals."""
        return float(self.residuals @ self.residuals)


_MAX_STEPS = 200  # lines that run one way leave a long valley
_MAX_DAMPING = 1e12


def refine(
    start: State,
    linearise: Callable[[State], Linear],
    move: Callable[[State, FloatArray], State],
) -> tuple[State, Linear]:
    """The state with the least sum of squared residuals near ``start``.

    move: the state after a step (p,).
    Raises CalibrationError if it does not converge. Source: Marquardt 1963; Nocedal & Wright 2006, section 10.3.
    """
    state, here, damping = start, linearise(start), 1e-4
    if not np.isfinite(here.residuals).all():
        raise CalibrationError("the refinement starts outside the camera model's domain")
    for _ in range(_MAX_STEPS):
        scale, scaled = _unit_diagonal(here.normal)
        while True:
            factor = cho_factor(scaled + damping * np.eye(len(scale)))
            candidate = move(state, -scale * cho_solve(factor, scale * here.gradient))
            there = linearise(candidate)
            gain = here.cost - there.cost
            if gain >= 0 or damping > _MAX_DAMPING:  # NaN is no gain
                break
            damping *= 10.0
        if not gain >= 0:
            return state, here  # no step of any size improves it: at the minimum to rounding
        state, here, damping = candidate, there, max(damping * 0.1, 1e-15)
        if gain <= 1e-12 * here.cost + 1e-18:
            return state, here
    raise CalibrationError(f"the refinement did not converge in {_MAX_STEPS} steps")


def inverse_normal(normal: FloatArray) -> FloatArray:
    """(J^T J)^-1, (p, p): the covariance of a least-squares solution whose residuals have unit variance.

    Raises CalibrationError where the observations leave a direction of the parameters open.
    """
    scale, scaled = _unit_diagonal(normal)
    if np.linalg.cond(scaled) > 1e13:
        raise CalibrationError("the observations do not determine all parameters of the camera")
    inverse = np.linalg.inv(scaled) * np.outer(scale, scale)
    return 0.5 * (inverse + inverse.T)


def _unit_diagonal(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Scales (p,) that give ``normal`` a diagonal of ones, since units differ; and the scaled matrix."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    return scale, normal * np.outer(scale, scale)


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
