import cv2
import numpy as np
import pytest
from georef_cases import cameras, overhead
from hypothesis import given
from hypothesis import strategies as st

from contracts import CalibrationError, Camera, Intrinsics
from georef.homography import fit_homography, image_from_plane, plane_from_image, transform
from georef.location import on_plane
from georef.projection import project


def without_lens(camera):
    k = camera.intrinsics
    plain = Intrinsics(k.width_px, k.height_px, k.fx_px, k.fy_px, k.cx_px, k.cy_px, np.zeros(5))
    return Camera(camera.name, plain, camera.pose)


@given(cameras(), st.floats(0.0, 0.3))
def test_plane_homography_is_the_projection_of_that_plane(camera, height_m):
    camera = without_lens(camera)
    centre = camera.pose.position_m[:2]
    places = centre + np.random.default_rng(0).uniform(-1.0, 1.0, (6, 2))
    expected, valid = project(camera, np.column_stack([places, np.full(6, height_m)]))
    ours = transform(image_from_plane(camera, height_m), places)
    error = np.abs(ours - expected)[valid] / (1.0 + np.abs(expected)[valid])
    assert error.max(initial=0.0) < 1e-9


def test_homography_of_the_rail_paper_is_ray_and_plane_without_lens():
    camera = without_lens(overhead(tilt_rad=(0.05, 0.02, 0.4)))
    image = np.array([[10.0, 20.0], [640.0, 300.0], [1270.0, 710.0]])
    by_ray, _ = on_plane(camera, image, 0.0)
    assert np.abs(transform(plane_from_image(camera), image) - by_ray[:, :2]).max() < 1e-12


def test_a_camera_in_the_plane_has_no_homography():
    with pytest.raises(CalibrationError, match='"west" lies in the plane'):
        plane_from_image(overhead(), 2.8)


@given(st.integers(0, 10_000), st.integers(4, 12))
def test_fit_recovers_an_exact_homography_and_agrees_with_opencv(seed, count):
    rng = np.random.default_rng(seed)
    truth = np.eye(3) + rng.uniform(-0.2, 0.2, (3, 3))
    truth[2, :2] *= 0.1
    source = rng.uniform(-1.0, 1.0, (count, 2))
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    source[:4] = corners + rng.uniform(-0.2, 0.2, (4, 2))  # never on a line
    target = transform(truth, source)
    ours = transform(fit_homography(source, target), source)
    theirs = transform(np.asarray(cv2.findHomography(source, target)[0]), source)
    assert np.abs(ours - target).max() < 1e-9
    assert np.abs(ours - theirs).max() < 1e-6


def test_scaling_and_shifting_the_points_changes_nothing():
    rng = np.random.default_rng(2)
    source, target = rng.uniform(0, 1, (9, 2)), rng.uniform(0, 1, (9, 2))
    plain = transform(fit_homography(source, target), source)
    moved = transform(fit_homography(1000 * source + 500, 10 * target - 3), 1000 * source + 500)
    assert np.abs(10 * plain - 3 - moved).max() < 1e-8


@pytest.mark.parametrize(
    ("points", "reason"),
    [
        (np.zeros((3, 2)), "at least 4"),
        (np.column_stack([np.arange(6.0), 2 * np.arange(6.0)]), "on a line"),
        (np.ones((5, 2)), "coincide"),
    ],
)
def test_points_that_determine_no_homography_are_refused(points, reason):
    with pytest.raises(CalibrationError, match=reason):
        fit_homography(points, points)


def test_the_vanishing_line_maps_to_nan():
    homography = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 0]])
    assert np.isnan(transform(homography, np.array([[0.0, 1.0]]))).all()
