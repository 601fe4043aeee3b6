import cv2
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from bench.roofs import roof_corners_m, roof_quads_px
from tests.bench.filmless import overhead_camera, truth_at


def test_roofs_lie_where_opencv_projects_them():
    camera = overhead_camera()
    truth = truth_at(2, [camera])
    rotation = camera.pose.world_from_camera.T
    expected, _ = cv2.projectPoints(
        roof_corners_m(truth).reshape(-1, 3),
        cv2.Rodrigues(rotation)[0],
        -rotation @ camera.pose.position_m,
        camera.intrinsics.matrix,
        camera.intrinsics.distortion,
    )
    assert np.abs(roof_quads_px(truth, camera).reshape(-1, 2) - expected[:, 0]).max() < 1e-9


def test_the_front_left_corner_comes_first_and_the_others_counter_clockwise():
    corners = roof_corners_m(truth_at(0, []))[0]
    expected = [[-0.24, 0.13], [-0.36, 0.13], [-0.36, 0.07], [-0.24, 0.07]]
    assert np.abs(corners[:, :2] - expected).max() < 1e-12
    assert np.abs(corners[:, 2] - 0.06).max() < 1e-12


@given(st.integers(0, 20))
def test_a_roof_has_the_size_of_its_object(index):
    corners = roof_corners_m(truth_at(index, []))
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)  # (N, 4)
    assert np.abs(sides - [0.12, 0.06, 0.12, 0.06]).max() < 1e-12
