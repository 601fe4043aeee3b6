import cv2
import numpy as np
import pytest
from georef_cases import board_poses, overhead, rotation

from contracts import CalibrationError, Camera, Checkerboard, Frame, Pose
from georef.checkerboard import board_points, find_corners
from georef.intrinsics import calibrate_from_corners, calibrate_intrinsics
from georef.projection import project

BOARD = Checkerboard(9, 6, 0.03)
POINTS = board_points(BOARD)
CAMERA = overhead()
NOISE_PX = 0.05


def numbers(k):
    return np.array([k.fx_px, k.fy_px, k.cx_px, k.cy_px, *k.distortion])


def exact_views(count, seed=1):
    return board_poses(CAMERA, POINTS, count, np.random.default_rng(seed))


def test_exact_corners_give_the_exact_camera():
    found = calibrate_from_corners(exact_views(8), BOARD, 1280, 720)
    error = np.abs(numbers(found.intrinsics) - numbers(CAMERA.intrinsics))
    assert error[:4].max() < 1e-5
    assert error[4:].max() < 1e-6
    assert found.residual_rms_px < 1e-8


def test_result_agrees_with_opencv_on_noisy_corners():
    views = exact_views(12) + np.random.default_rng(5).normal(0, NOISE_PX, (12, len(POINTS), 2))
    ours = calibrate_from_corners(views, BOARD, 1280, 720)
    board = [POINTS.astype(np.float32)] * len(views)
    image = [view[:, None].astype(np.float32) for view in views]
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 200, 1e-14)
    rms, matrix, lens, *_ = cv2.calibrateCamera(board, image, (1280, 720), None, None, criteria=criteria)
    assert np.abs(ours.intrinsics.matrix - matrix).max() < 0.01
    assert np.abs(ours.intrinsics.distortion - lens.ravel()).max() < 1e-3
    assert abs(ours.residual_rms_px * np.sqrt(2) - rms) < 1e-5  # OpenCV counts a corner as one, we count u and v


def test_corner_noise_is_measured_and_the_covariance_is_true():
    rng, exact = np.random.default_rng(7), exact_views(8)
    distances, noises = [], []
    for _ in range(12):
        found = calibrate_from_corners(exact + rng.normal(0, NOISE_PX, exact.shape), BOARD, 1280, 720)
        error = numbers(found.intrinsics) - numbers(CAMERA.intrinsics)
        distances.append(error @ np.linalg.solve(found.covariance, error))
        noises.append(found.corner_noise_px)
    assert abs(np.mean(noises) - NOISE_PX) < 0.001
    assert abs(np.mean(distances) - 9.0) < 4.0  # chi-square of 9: 12 draws scatter by 1.2


def parallel_views():
    centre = POINTS.mean(axis=0)
    shifts = [[0.0, 0.0, 0.5], [0.05, 0.02, 0.6], [-0.06, 0.03, 0.7], [0.02, -0.05, 0.55]]
    poses = [Pose(np.eye(3), centre - shift) for shift in np.array(shifts)]
    views = np.array([project(Camera("b", CAMERA.intrinsics, pose), POINTS)[0] for pose in poses])
    return views + np.random.default_rng(3).normal(0, NOISE_PX, views.shape)


def test_parallel_boards_are_refused():
    with pytest.raises(CalibrationError, match="tilted"):
        calibrate_from_corners(parallel_views(), BOARD, 1280, 720)


def test_too_few_views_are_refused():
    with pytest.raises(CalibrationError, match="2 board views; at least 3"):
        calibrate_from_corners(exact_views(2), BOARD, 1280, 720)


def drawn(camera, noise=1.5, seed=0):
    """The board in a 640 x 360 image, each pixel the mean of 16 rays through the exact lens."""
    offsets = (np.arange(4) + 0.5) / 4 - 0.5
    u, v = np.meshgrid(np.arange(640), np.arange(360))
    grey = np.zeros((360, 640))
    for du in offsets:
        for dv in offsets:
            normal = cv2.undistortPoints(
                np.stack([u + du, v + dv], axis=-1).reshape(-1, 1, 2).astype(np.float64),
                camera.intrinsics.matrix,
                camera.intrinsics.distortion,
            ).reshape(360, 640, 2)
            ray = np.concatenate([normal, np.ones((360, 640, 1))], axis=-1) @ camera.pose.world_from_camera.T
            place = camera.pose.position_m - ray * (camera.pose.position_m[2] / ray[..., 2])[..., None]
            square = np.floor(place[..., :2] / BOARD.square_m).astype(int)
            x, y = square[..., 0], square[..., 1]
            inside = (x >= -1) & (x < BOARD.columns) & (y >= -1) & (y < BOARD.rows)
            paper = (x >= -2) & (x <= BOARD.columns) & (y >= -2) & (y <= BOARD.rows)
            grey += np.where(inside & ((x + y) % 2 == 0), 30, np.where(paper, 220, 90)) / 16
    grey += np.random.default_rng(seed).normal(0, noise, grey.shape)
    image = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
    return Frame("west", 0, 0, np.repeat(image[..., None], 3, axis=2))


def board_camera(tilt, yaw):
    small = overhead(focal_px=700.0).intrinsics
    k = type(small)(640, 360, 700.0, 701.0, 318.4, 181.2, np.array([-0.1, 0.03, 0.0005, -0.0003, 0.0]))
    camera_from_board = rotation(*tilt, 0.0) @ rotation(0.0, 0.0, yaw)
    centre = POINTS.mean(axis=0)
    return Camera("west", k, Pose(camera_from_board.T, centre - camera_from_board.T @ [0.01, 0.005, 0.5]))


def test_corners_in_an_image_are_found_without_bias():
    errors = []
    for seed, (tilt, yaw) in enumerate([((0.3, 0.1), 0.2), ((-0.2, 0.35), -0.1)]):
        camera = board_camera(tilt, yaw)
        found = find_corners(drawn(camera, seed=seed), BOARD)
        exact, _ = project(camera, POINTS)
        errors.append(min(found - exact, found[::-1] - exact, key=lambda error: np.abs(error).sum()))
    assert np.abs(np.mean(errors, axis=(0, 1))).max() < 0.02
    assert np.sqrt(np.mean(np.square(errors))) < 0.06


def test_images_without_a_board_are_refused_with_the_count():
    empty = Frame("west", 0, 0, np.full((360, 640, 3), 90, np.uint8))
    assert find_corners(empty, BOARD) is None
    with pytest.raises(CalibrationError, match="found in 0 of 3 views"):
        calibrate_intrinsics([empty] * 3, BOARD)


def test_no_views_are_refused():
    with pytest.raises(CalibrationError, match="found in 0 of 0 views"):
        calibrate_intrinsics([], BOARD)


def test_views_of_different_sizes_are_refused():
    frames = [Frame("west", 0, 0, np.zeros(shape, np.uint8)) for shape in ((36, 64, 3), (40, 64, 3))]
    with pytest.raises(CalibrationError, match="view 1 is 64x40, but view 0 64x36: one camera has one size"):
        calibrate_intrinsics(frames, BOARD)
