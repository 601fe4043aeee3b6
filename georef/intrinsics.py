"""Intrinsics and lens of a camera from views of a checkerboard (Zhang 2000)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contracts import CalibrationError, Camera, Checkerboard, FloatArray, Frame, Intrinsics, Pose
from contracts.arrays import freeze
from georef.checkerboard import board_points, find_corners
from georef.homography import fit_homography
from georef.projection import project_with_derivatives
from georef.refinement import Linear, inverse_normal, moved_intrinsics, moved_pose, refine

LEAST_VIEWS = 3  # Zhang 2000, section 3.1
_LARGEST_FOCAL_ERROR = 0.05  # standard deviation over focal length beyond which views are called degenerate
_PARALLEL = "the board views do not determine the focal length: hold the board tilted, in different directions"


@dataclass(frozen=True, eq=False)
class IntrinsicCalibration:
    """Intrinsics as the board views left them.

    covariance: (9, 9) of fx, fy, cx, cy (px), k1, k2, p1, p2, k3.
    residual_rms_px: root mean square per coordinate of the corners' residuals.
    corner_noise_px: standard deviation per coordinate of a corner, estimated from the residuals.
    views: number of views in which the board was found. unused: names of the others.
    """

    intrinsics: Intrinsics
    covariance: FloatArray
    residual_rms_px: float
    corner_noise_px: float
    views: int
    unused: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "covariance", shape=(9, 9))


def calibrate_intrinsics(
    board_views: Sequence[Frame], board: Checkerboard, *, names: Sequence[str] | None = None
) -> IntrinsicCalibration:
    """Calibrate from images; ``names`` is what they are called, view 0 and so on if not given.

    Raises CalibrationError where too few views show the whole board, their sizes differ, or they are all parallel.
    """
    names = [f"view {number}" for number in range(len(board_views))] if names is None else names
    sizes = [frame.image.shape[1::-1] for frame in board_views]
    for name, size in zip(names, sizes, strict=True):
        if size != sizes[0]:
            others = f"{names[0]} {sizes[0][0]}x{sizes[0][1]}"
            raise CalibrationError(f"{name} is {size[0]}x{size[1]}, but {others}: one camera has one size")
    corners = [find_corners(frame, board) for frame in board_views]
    unused = tuple(name for name, found in zip(names, corners, strict=True) if found is None)
    found = [each for each in corners if each is not None]
    if len(found) < LEAST_VIEWS:
        where = f"not in {', '.join(unused)}" if unused else "give more of them"
        raise CalibrationError(
            f"the {board.columns} x {board.rows} checkerboard was found in {len(found)} of {len(board_views)} views, "
            f"at least {LEAST_VIEWS} are needed; {where}"
        )
    return replace(calibrate_from_corners(np.stack(found), board, *sizes[0]), unused=unused)


def calibrate_from_corners(
    corners_px: FloatArray, board: Checkerboard, width_px: int, height_px: int
) -> IntrinsicCalibration:
    """Calibrate from found corners (V, columns * rows, 2), in the order of ``georef.checkerboard.board_points``.

    Closed form (Zhang 2000, section 3.1), then all poses, K and the lens together by least squares (section 3.3).
    Raises CalibrationError for too few or degenerate views.
    """
    if len(corners_px) < LEAST_VIEWS:
        raise CalibrationError(f"{len(corners_px)} board views; at least {LEAST_VIEWS} are needed")
    points = board_points(board)
    homographies = [fit_homography(points[:, :2], view) for view in corners_px]
    start = _closed_form(homographies, width_px, height_px)
    poses = tuple(_pose_of_board(start, homography) for homography in homographies)
    (intrinsics, _), solution = refine((start, poses), lambda state: _linearise(state, points, corners_px), _move)
    residuals = solution.residuals
    noise = float(np.sqrt(solution.cost / (len(residuals) - len(solution.gradient))))
    covariance = noise**2 * inverse_normal(solution.normal)[:9, :9]
    if np.sqrt(covariance[0, 0]) > _LARGEST_FOCAL_ERROR * intrinsics.fx_px:
        raise CalibrationError(_PARALLEL)
    rms = float(np.sqrt(np.mean(residuals**2)))
    return IntrinsicCalibration(intrinsics, covariance, rms, noise, len(corners_px))


def _closed_form(homographies: list[FloatArray], width_px: int, height_px: int) -> Intrinsics:
    """K without lens or skew from the image of the absolute conic B = K^-T K^-1 (Zhang 2000, equations 3 to 9)."""
    scale = float(max(width_px, height_px))
    to_unit = np.array([[1 / scale, 0, -width_px / (2 * scale)], [0, 1 / scale, -height_px / (2 * scale)], [0, 0, 1]])
    rows = []
    for homography in homographies:
        h = to_unit @ homography
        h = h / np.linalg.norm(h)
        rows += [_conic_row(h, 0, 1), _conic_row(h, 0, 0) - _conic_row(h, 1, 1)]
    b11, b22, b13, b23, b33 = np.linalg.svd(np.stack(rows))[2][-1]
    if b11 < 0:
        b11, b22, b13, b23, b33 = -b11, -b22, -b13, -b23, -b33
    if min(b11, b22) <= 0 or (factor := b33 - b13**2 / b11 - b23**2 / b22) <= 0:
        raise CalibrationError(_PARALLEL)
    centre = scale * np.array([-b13 / b11, -b23 / b22]) + np.array([width_px, height_px]) / 2
    focal = scale * np.sqrt(factor / np.array([b11, b22]))
    return Intrinsics(
        width_px, height_px, float(focal[0]), float(focal[1]), float(centre[0]), float(centre[1]), np.zeros(5)
    )


def _conic_row(h: FloatArray, i: int, j: int) -> FloatArray:
    """v_ij with h_i^T B h_j = v_ij . (B11, B22, B13, B23, B33); the skew B12 is zero."""
    a, b = h[:, i], h[:, j]
    return np.array([a[0] * b[0], a[1] * b[1], a[2] * b[0] + a[0] * b[2], a[2] * b[1] + a[1] * b[2], a[2] * b[2]])


def _pose_of_board(intrinsics: Intrinsics, homography: FloatArray) -> Pose:
    """Camera in the board's axes, board ahead of the camera (Zhang 2000, section 3.1 and appendix C)."""
    columns = np.linalg.inv(intrinsics.matrix) @ homography
    columns = columns / np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    if columns[2, 2] < 0:
        columns = -columns
    rough = np.stack([columns[:, 0], columns[:, 1], np.cross(columns[:, 0], columns[:, 1])], axis=1)
    u, _, vt = np.linalg.svd(rough)
    camera_from_board = u @ vt
    return Pose(camera_from_board.T, -camera_from_board.T @ columns[:, 2])


_State = tuple[Intrinsics, tuple[Pose, ...]]


def _linearise(state: _State, points: FloatArray, corners_px: FloatArray) -> Linear:
    """All views together: 9 shared columns, then 6 for each view's pose; the views meet only in the shared ones."""
    intrinsics, poses = state
    residuals = np.empty((len(poses), 2 * len(points)))
    normal = np.zeros((9 + 6 * len(poses),) * 2)
    gradient = np.zeros(len(normal))
    for view, pose in enumerate(poses):
        projection = project_with_derivatives(Camera("board", intrinsics, pose), points)
        residuals[view] = (projection.pixels - corners_px[view]).ravel()
        jacobian = projection.by_parameters.reshape(-1, 15)
        columns = np.r_[0:9, 9 + 6 * view : 15 + 6 * view]
        normal[np.ix_(columns, columns)] += jacobian.T @ jacobian
        gradient[columns] += jacobian.T @ residuals[view]
    return Linear(residuals.ravel(), normal, gradient)


def _move(state: _State, step: FloatArray) -> _State:
    intrinsics, poses = state
    steps = step[9:].reshape(-1, 6)
    return moved_intrinsics(intrinsics, step[:9]), tuple(map(moved_pose, poses, steps))
