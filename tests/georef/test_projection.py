import cv2
import numpy as np
import pytest
from georef_cases import cameras, lenses, overhead, perturbed, pixels
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from contracts import Camera, FloatArray, Intrinsics
from georef import lens
from georef.location import on_plane
from georef.projection import project, project_with_derivatives, rays, undistort


def projected_by_opencv(camera: Camera, points: FloatArray) -> FloatArray:
    camera_from_world = camera.pose.world_from_camera.T
    rvec = Rotation.from_matrix(camera_from_world).as_rotvec()  # cv2.Rodrigues loses 1e-7 rad near half a turn
    tvec = -camera_from_world @ camera.pose.position_m
    image, _ = cv2.projectPoints(points, rvec, tvec, camera.intrinsics.matrix, camera.intrinsics.distortion)
    return image.reshape(-1, 2)


@given(cameras(), pixels())
def test_projection_agrees_with_opencv(camera, image):
    points, valid = on_plane(camera, image, 0.1)
    ours, _ = project(camera, points[valid])
    if valid.any():
        assert np.abs(ours - projected_by_opencv(camera, points[valid])).max() < 1e-7


@given(cameras(), pixels())
def test_undistortion_agrees_with_opencv_where_that_converges(camera, image):
    ours, valid = undistort(camera.intrinsics, image)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 500, 1e-14)
    k = camera.intrinsics
    theirs = cv2.undistortPoints(image[:, None], k.matrix, k.distortion, criteria=criteria)[:, 0]
    back = lens.distort(k.distortion, theirs) * [k.fx_px, k.fy_px] + [k.cx_px, k.cy_px]
    converged = valid & (np.abs(back - image).max(axis=1) < 1e-9)
    assert np.abs(ours - theirs)[converged].max(initial=0.0) * k.fx_px < 1e-6


@given(cameras(), pixels(), st.floats(0.0, 0.5))
def test_pixel_to_plane_and_back_is_the_same_pixel(camera, image, height_m):
    points, valid = on_plane(camera, image, height_m)
    assert np.abs(points[valid][:, 2] - height_m).max(initial=0.0) < 1e-10
    back, _ = project(camera, points[valid])
    assert np.abs(back - image[valid]).max(initial=0.0) < 1e-7


@given(cameras(), pixels())
def test_rays_are_unit_vectors_whose_points_project_to_the_pixel(camera, image):
    directions, valid = rays(camera, image)
    assert np.abs(np.linalg.norm(directions[valid], axis=-1) - 1).max(initial=0.0) < 1e-12
    back, _ = project(camera, camera.pose.position_m + 3.0 * directions[valid])
    assert np.abs(back - image[valid]).max(initial=0.0) < 1e-7


@given(lenses(), st.floats(0.0, 0.6), st.floats(-np.pi, np.pi))
def test_undistort_inverts_distort_before_the_fold(distortion, radius, angle):
    point = radius * np.array([[np.cos(angle), np.sin(angle)]])
    if lens.before_fold(distortion, point)[0] and radius < 0.95 * lens.fold_radius(distortion):
        back, valid = lens.undistort(distortion, lens.distort(distortion, point))
        assert valid[0]
        assert np.abs(back - point).max() < 1e-10


STEPS = np.array([1e-3] * 4 + [1e-6] * 5 + [1e-6] * 6)


@given(cameras(), pixels(count=3))
def test_derivatives_by_the_parameters_agree_with_finite_differences(camera, image):
    points, valid = on_plane(camera, image, 0.0)
    projection = project_with_derivatives(camera, points[valid])
    for index, step in enumerate(np.diag(STEPS)):
        ahead, ok_ahead = project(perturbed(camera, step), points[valid])
        behind, ok_behind = project(perturbed(camera, -step), points[valid])
        ok = ok_ahead & ok_behind
        difference = (ahead - behind) / (2 * STEPS[index])
        error = np.abs(difference - projection.by_parameters[..., index])[ok]
        scale = 1.0 + np.abs(projection.by_parameters[..., index])[ok]
        assert (error / scale).max(initial=0.0) < 1e-5


@given(cameras(), pixels(count=3))
def test_derivatives_by_the_point_agree_with_finite_differences(camera, image):
    points, valid = on_plane(camera, image, 0.2)
    projection = project_with_derivatives(camera, points[valid])
    for axis, step in enumerate(1e-6 * np.eye(3)):
        ahead, ok_ahead = project(camera, points[valid] + step)
        behind, ok_behind = project(camera, points[valid] - step)
        ok = ok_ahead & ok_behind
        error = np.abs((ahead - behind) / 2e-6 - projection.by_point[..., axis])[ok]
        assert (error / (1.0 + np.abs(projection.by_point[..., axis])[ok])).max(initial=0.0) < 1e-5


def test_points_behind_the_camera_are_invalid_and_not_mirrored():
    pixel, valid = project(overhead(), np.array([[0.1, 0.1, 0.0], [0.1, 0.1, 2.8], [0.1, 0.1, 5.0]]))
    assert valid.tolist() == [True, False, False]
    assert np.isnan(pixel[1:]).all()


def test_a_folded_lens_is_refused_on_both_ways():
    folding = overhead(distortion=(-0.3, 0.0, 0.0, 0.0, 0.0))
    fold = lens.fold_radius(folding.intrinsics.distortion)
    assert fold == pytest.approx(1 / np.sqrt(0.9), abs=1e-12)
    _, valid = project(folding, np.array([[2.8 * 0.99 * fold, 0.0, 0.0], [2.8 * 1.2 * fold, 0.0, 0.0]]))
    assert valid.tolist() == [True, False]
    beyond_px = folding.intrinsics.cx_px + folding.intrinsics.fx_px * fold * (1 - 0.3 * fold**2) + 5.0
    straight, valid = undistort(folding.intrinsics, np.array([[700.0, 400.0], [beyond_px, folding.intrinsics.cy_px]]))
    assert valid.tolist() == [True, False]
    assert np.isnan(straight[1]).all()


def test_the_principal_point_looks_along_the_optical_axis():
    camera = overhead()
    direction, _ = rays(camera, np.array([642.3, 355.8]))
    assert np.abs(direction - [0.0, 0.0, -1.0]).max() < 1e-12


def test_any_leading_shape_is_kept():
    camera = overhead()
    pixel, valid = project(camera, np.zeros((2, 3, 4, 3)))
    assert pixel.shape == (2, 3, 4, 2)
    assert valid.shape == (2, 3, 4)
    straight, valid = undistort(Intrinsics(10, 10, 5.0, 5.0, 4.5, 4.5, np.zeros(5)), np.zeros((2, 0, 2)))
    assert straight.shape == (2, 0, 2)
    assert valid.shape == (2, 0)
