"""The checkerboard's corners lie where the board was held."""

import cv2
import numpy as np
from film_cases import camera

from sim.board import BOARD, VIEWS, board_poses, board_views, draw_board
from sim.lens import Lens
from sim.sensor import SensorSpec
from sim.streams import stream

LENS = (-0.12, 0.05, 0.001, -0.0008, 0.0)
PATTERN = (BOARD.columns, BOARD.rows)


def found_corners(image, expected):
    refined = cv2.cornerSubPix(
        image,
        expected.astype(np.float32).reshape(-1, 1, 2),
        (5, 5),
        (-1, -1),
        (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 60, 1e-4),
    )
    return refined.reshape(-1, 2)


def test_drawn_corners_lie_where_opencv_projects_them_through_the_lens():
    view = camera(width_px=960, height_px=600, focal_px=1000.0, principal_px=(455.2, 310.9), distortion=LENS)
    lens = Lens.of(view.intrinsics)
    errors = []
    for pose in board_poses(view.intrinsics, BOARD, stream(3, "board"))[::4]:
        image = cv2.GaussianBlur(lens.bend(draw_board(lens.pinhole, BOARD, pose)), (0, 0), 1.0)  # the finder likes it
        points = pose.corners_in_camera(BOARD)
        expected = cv2.projectPoints(
            points, np.zeros(3), np.zeros(3), view.intrinsics.matrix, view.intrinsics.distortion
        )[0].reshape(-1, 2)
        errors.append(found_corners(image, expected) - expected)
    error = np.concatenate(errors)
    assert np.abs(error.mean(axis=0)).max() < 0.005
    assert np.sqrt((error**2).mean(axis=0)).max() < 0.04


def test_the_poses_fill_the_image_and_show_every_corner():
    view = camera(width_px=1280, height_px=720, focal_px=1600.0)
    poses = board_poses(view.intrinsics, BOARD, stream(3, "board"))
    seen = np.concatenate(
        [
            cv2.projectPoints(
                pose.corners_in_camera(BOARD), np.zeros(3), np.zeros(3), view.intrinsics.matrix, np.zeros(5)
            )[0].reshape(-1, 2)
            for pose in poses
        ]
    )
    assert len(poses) == VIEWS
    assert (seen.min(axis=0) < [60, 60]).all()
    assert (seen.max(axis=0) > [1220, 660]).all()
    tilts = [np.degrees(np.arccos(pose.camera_from_board[2, 2])) for pose in poses]
    assert max(tilts) > 25.0


def test_opencv_finds_the_board_and_the_views_are_reproducible():
    view = camera(distortion=LENS)
    lens = Lens.of(view.intrinsics)
    frames = list(board_views(view, lens, SensorSpec(), BOARD, seed=1, noise_seed=1))
    again = list(board_views(view, lens, SensorSpec(), BOARD, seed=1, noise_seed=1))
    found = [cv2.findChessboardCorners(frame.image, PATTERN)[0] for frame in frames[:6]]
    assert all(found)
    assert all((a.image == b.image).all() for a, b in zip(frames, again, strict=True))
