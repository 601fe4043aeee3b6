"""Where a camera stands, from points with known places; and pose and intrinsics together."""

from dataclasses import dataclass

import cv2
import numpy as np

from contracts import CalibrationError, Camera, FloatArray, InputError, Intrinsics, Pose
from georef.calibrated import CalibratedCamera
from georef.projection import Projection, project_with_derivatives, undistort
from georef.refinement import Linear, inverse_normal, moved_camera, moved_intrinsics, moved_pose, refine

LEAST_POINTS = 4
_NOISE_PX = (
    0.025  # a mark's error as measured on filmed frames (benchmarks.calibration_coverage), believed beforehand ...
)
_NOISE_WEIGHT = 4.0  # ... and how many residuals that belief is worth
_OUTLIER_SIGMAS = 4.5
_OUTLIER_FLOOR_PX = 0.05
_RAYLEIGH_MEDIAN = 1.1774  # of the length of a plane vector with unit variance per axis
_LARGEST_NOISE_PX = 5.0
_LARGEST_OUTLIER_SHARE = 0.34


def pose_from_points(intrinsics: Intrinsics, points_m: FloatArray, pixels: FloatArray) -> Pose:
    """Pose from at least four points without a first guess: points_m (N, 3) world, pixels (N, 2).

    By OpenCV's SQPnP (Terzakis & Lourakis 2020); refine it afterwards. Raises CalibrationError where that fails.
    """
    _check(points_m, pixels)
    straight, valid = undistort(intrinsics, pixels)
    if not valid.all():
        raise CalibrationError("a point lies where the lens model folds")
    origin = points_m.mean(axis=0)
    found, turn, shift = cv2.solvePnP(points_m - origin, straight, np.eye(3), None, flags=cv2.SOLVEPNP_SQPNP)
    if not found or not np.isfinite(turn).all():
        raise CalibrationError("the points determine no pose")
    camera_from_world, _ = cv2.Rodrigues(turn)
    rotation = np.asarray(camera_from_world, dtype=np.float64).T
    return Pose(rotation, origin - rotation @ shift[:, 0])


def fit_pose(start: Camera, points_m: FloatArray, pixels: FloatArray) -> tuple[Camera, FloatArray]:
    """The pose near ``start`` with the least squared residuals, intrinsics held; and the residuals (N, 2) in pixels."""
    _check(points_m, pixels)

    def linearise(camera: Camera) -> Linear:
        projection = project_with_derivatives(camera, points_m)
        return Linear.of((projection.pixels - pixels).ravel(), _rows(projection)[:, 9:])

    def move(camera: Camera, step: FloatArray) -> Camera:
        return moved_camera(camera, np.concatenate([np.zeros(9), step]))

    camera, solution = refine(start, linearise, move)
    return camera, solution.residuals.reshape(-1, 2)


def calibrate_pose(
    start: Camera, intrinsics_covariance: FloatArray, points_m: FloatArray, pixels: FloatArray
) -> CalibratedCamera:
    """Pose and intrinsics together, the intrinsics being known beforehand to ``intrinsics_covariance`` (9, 9).

    points_m: (N, 3) world; pixels (N, 2). The points' noise is estimated from their residuals, helped by a weak belief;
    points that do not fit (half hidden, for example) are dropped, the worst first.
    Raises CalibrationError for fewer than four points, more than a third of outliers, or no fit at all.
    """
    total = len(points_m)
    while True:
        try:
            fit = _joint_fit(start, intrinsics_covariance, points_m, pixels)
        except CalibrationError as error:
            raise CalibrationError(f'camera "{start.name}": the control points do not fit one pose: {error}') from error
        worst = int(fit.misfits_px.argmax())
        if fit.misfits_px[worst] <= max(_OUTLIER_SIGMAS * _typical_px(fit, worst), _OUTLIER_FLOOR_PX):
            break
        points_m, pixels = np.delete(points_m, worst, axis=0), np.delete(pixels, worst, axis=0)
        if len(points_m) < max(LEAST_POINTS, (1 - _LARGEST_OUTLIER_SHARE) * total):
            raise CalibrationError(
                f'camera "{start.name}": {total - len(points_m)} of {total} control points do not fit one pose'
            )
    if fit.noise_px > _LARGEST_NOISE_PX:
        raise CalibrationError(
            f'camera "{start.name}": the control points do not fit one pose; their residuals are {fit.noise_px:.1f} px'
        )
    return fit.calibrated


@dataclass(frozen=True, eq=False)
class _Fit:
    """A joint fit of N points.

    misfits_px: (N,) sqrt(r^T (I - H)^-1 r) of each point's residual r (2,), H being the share of the point in its own
        prediction: its square is what the sum of squares would lose without the point (Cook & Weisberg 1982, 2.2).
    freedom: residuals less fitted parameters.
    """

    calibrated: CalibratedCamera
    misfits_px: FloatArray
    squares_px2: float
    freedom: float
    noise_px: float


def _typical_px(fit: _Fit, without: int) -> float:
    """Noise by which one point is judged: without that point, and robust against others like it."""
    rest = np.delete(fit.misfits_px, without)
    squares = _NOISE_WEIGHT * _NOISE_PX**2 + max(fit.squares_px2 - float(fit.misfits_px[without]) ** 2, 0.0)
    deleted = np.sqrt(squares / (_NOISE_WEIGHT + max(fit.freedom - 2.0, 0.0)))
    return float(min(deleted, np.median(rest) / _RAYLEIGH_MEDIAN))


def _joint_fit(start: Camera, intrinsics_covariance: FloatArray, points_m: FloatArray, pixels: FloatArray) -> _Fit:
    """Maximum a posteriori in u ~ N(0, 1) and the pose, with intrinsics = start + L u and L L^T the prior's covariance.

    Any of the prior's variances may be zero.
    """
    _check(points_m, pixels)
    root = _square_root(intrinsics_covariance)
    noise_px = _NOISE_PX
    state = (np.zeros(9), start.pose)

    def camera_of(state: tuple[FloatArray, Pose]) -> Camera:
        return Camera(start.name, moved_intrinsics(start.intrinsics, root @ state[0]), state[1])

    def seen(state: tuple[FloatArray, Pose]) -> tuple[FloatArray, FloatArray]:
        projection = project_with_derivatives(camera_of(state), points_m)
        rows = _rows(projection)
        return (projection.pixels - pixels).ravel(), np.concatenate([rows[:, :9] @ root, rows[:, 9:]], axis=1)

    def linearise(state: tuple[FloatArray, Pose]) -> Linear:
        residuals, jacobian = seen(state)
        return Linear.of(
            np.concatenate([residuals / noise_px, state[0]]), np.concatenate([jacobian / noise_px, np.eye(9, 15)])
        )

    def move(state: tuple[FloatArray, Pose], step: FloatArray) -> tuple[FloatArray, Pose]:
        return state[0] + step[:9], moved_pose(state[1], step[9:])

    for _ in range(4):  # residuals and noise settle each other
        state, solution = refine(state, linearise, move)
        spread = inverse_normal(solution.normal)
        squares = float(noise_px**2 * solution.residuals[:-9] @ solution.residuals[:-9])
        freedom = len(solution.residuals) - 9 - 15.0 + float(np.trace(spread[:9, :9]))  # the prior decided the trace
        believed = noise_px
        # Noise that is itself estimated makes Student's t of the errors; its variance is larger by n / (n - 2)
        noise_px = float(np.sqrt((_NOISE_WEIGHT * _NOISE_PX**2 + squares) / (_NOISE_WEIGHT + freedom - 2.0)))
    residuals, jacobian = seen(state)
    misfits_px = _misfits(residuals.reshape(-1, 2), jacobian.reshape(-1, 2, 15) / believed, spread)
    to_parameters = np.eye(15)
    to_parameters[:9, :9] = root
    covariance = to_parameters @ spread @ to_parameters.T
    calibrated = CalibratedCamera(camera_of(state), 0.5 * (covariance + covariance.T))
    return _Fit(calibrated, misfits_px, squares, freedom, noise_px)


def _misfits(residuals: FloatArray, rows: FloatArray, spread: FloatArray) -> FloatArray:
    """``_Fit.misfits_px`` of residuals (N, 2) px with whitened derivatives (N, 2, 15)."""
    own = np.eye(2) - rows @ spread @ np.swapaxes(rows, 1, 2)
    scores = np.einsum("ni,nij,nj->n", residuals, np.linalg.pinv(own, rcond=1e-6, hermitian=True), residuals)
    misfits: FloatArray = np.sqrt(np.maximum(scores, 0.0))
    return misfits


def _square_root(covariance: FloatArray) -> FloatArray:
    """L with L L^T = covariance, for any positive semi-definite matrix; scaled first, since units differ."""
    scale = np.sqrt(np.diag(covariance))
    safe = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(safe, safe))
    if values.min() < -1e-6:
        raise InputError("the intrinsics' covariance is not positive semi-definite")
    root: FloatArray = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _rows(projection: Projection) -> FloatArray:
    """(2 N, 15) derivatives by the parameters, u and v of each point in turn."""
    return projection.by_parameters.reshape(-1, projection.by_parameters.shape[-1])


def _check(points_m: FloatArray, pixels: FloatArray) -> None:
    if len(points_m) != len(pixels):
        raise InputError(f"{len(points_m)} points in the world but {len(pixels)} in the image")
    if len(points_m) < LEAST_POINTS:
        raise CalibrationError(f"{len(points_m)} control points; a pose needs at least {LEAST_POINTS}")
