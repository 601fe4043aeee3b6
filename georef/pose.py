"""Where a camera stands, from points with known places; and pose and intrinsics together."""

import cv2
import numpy as np

from contracts import CalibrationError, Camera, FloatArray, InputError, Intrinsics, Pose
from georef.calibrated import CalibratedCamera
from georef.projection import Projection, project_with_derivatives, undistort
from georef.refinement import Linear, inverse_normal, moved_camera, moved_intrinsics, moved_pose, refine

LEAST_POINTS = 4
_NOISE_PX = 0.05  # what a mark's error is believed to be beforehand ...
_NOISE_WEIGHT = 6.0  # ... and how many residuals that belief is worth
_OUTLIER_SIGMAS = 4.5
_OUTLIER_FLOOR_PX = 0.05
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

    points_m: (N, 3) world; pixels (N, 2). The points' noise is estimated from their residuals, helped by a weak belief
    in 0.05 px; points that do not fit (half hidden, for example) are dropped, the worst first.
    Raises CalibrationError for fewer than four points or more than a third of outliers.
    """
    total = len(points_m)
    while True:
        calibrated, residuals, noise_px = _joint_fit(start, intrinsics_covariance, points_m, pixels)
        sizes = np.hypot(*residuals.T)
        worst = int(sizes.argmax())
        freedom = 1 - 6 / (2 * len(sizes))  # share of the residuals' variance that the fitted pose has left
        typical = float(np.median(sizes)) / 1.1774 / np.sqrt(freedom)  # 1.1774: Rayleigh's median for sigma 1
        if sizes[worst] <= max(_OUTLIER_SIGMAS * min(noise_px, typical), _OUTLIER_FLOOR_PX):
            return calibrated
        points_m, pixels = np.delete(points_m, worst, axis=0), np.delete(pixels, worst, axis=0)
        if len(points_m) < max(LEAST_POINTS, (1 - _LARGEST_OUTLIER_SHARE) * total):
            raise CalibrationError(
                f'camera "{start.name}": {total - len(points_m)} of {total} control points do not fit one pose'
            )


def _joint_fit(
    start: Camera, intrinsics_covariance: FloatArray, points_m: FloatArray, pixels: FloatArray
) -> tuple[CalibratedCamera, FloatArray, float]:
    """Maximum a posteriori in u ~ N(0, 1) and the pose, with intrinsics = start + L u and L L^T the prior's covariance.

    Any of the prior's variances may be zero. Returns the camera, residuals (N, 2) px and the noise px.
    """
    _check(points_m, pixels)
    root = _square_root(intrinsics_covariance)
    noise_px = _NOISE_PX
    state = (np.zeros(9), start.pose)

    def camera_of(state: tuple[FloatArray, Pose]) -> Camera:
        return Camera(start.name, moved_intrinsics(start.intrinsics, root @ state[0]), state[1])

    def linearise(state: tuple[FloatArray, Pose]) -> Linear:
        projection = project_with_derivatives(camera_of(state), points_m)
        rows = _rows(projection) / noise_px
        seen = np.concatenate([rows[:, :9] @ root, rows[:, 9:]], axis=1)
        residuals = np.concatenate([(projection.pixels - pixels).ravel() / noise_px, state[0]])
        return Linear.of(residuals, np.concatenate([seen, np.eye(9, 15)]))

    def move(state: tuple[FloatArray, Pose], step: FloatArray) -> tuple[FloatArray, Pose]:
        return state[0] + step[:9], moved_pose(state[1], step[9:])

    for _ in range(4):  # residuals and noise settle each other
        state, solution = refine(state, linearise, move)
        spread = inverse_normal(solution.normal)
        in_pixels = noise_px * solution.residuals[:-9]
        fitted = 15.0 - float(np.trace(spread[:9, :9]))  # parameters that the points, not the prior, decided
        squares = _NOISE_WEIGHT * _NOISE_PX**2 + float(in_pixels @ in_pixels)
        noise_px = float(np.sqrt(squares / (_NOISE_WEIGHT + len(in_pixels) - fitted)))
    to_parameters = np.eye(15)
    to_parameters[:9, :9] = root
    covariance = to_parameters @ spread @ to_parameters.T
    calibrated = CalibratedCamera(camera_of(state), 0.5 * (covariance + covariance.T))
    return calibrated, in_pixels.reshape(-1, 2), noise_px


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
