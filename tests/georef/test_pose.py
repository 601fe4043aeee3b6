import numpy as np
import pytest
from georef_cases import cameras, departed, overhead, perturbed, seen_marks, tile_corners
from hypothesis import given

from contracts import CalibrationError, Camera, InputError
from georef.location import place
from georef.pose import calibrate_pose, fit_pose, pose_from_points
from georef.projection import project

POINTS = tile_corners()
INTRINSIC_SIGMAS = np.array([0.3, 0.3, 0.4, 0.3, 1e-3, 5e-3, 5e-5, 5e-5, 1e-2])
CHI2_90 = 4.605170186


def apart(one, other):
    turn = one.pose.world_from_camera @ other.pose.world_from_camera.T
    return np.abs(turn - np.eye(3)).max(), np.abs(one.pose.position_m - other.pose.position_m).max()


@given(cameras())
def test_exact_points_give_the_exact_pose_without_a_first_guess(camera):
    rng = np.random.default_rng(0)
    points = np.column_stack([camera.pose.position_m[:2] + rng.uniform(-3, 3, (60, 2)), rng.uniform(0, 0.3, 60)])
    image, valid = project(camera, points)
    valid &= (np.abs(image - [640, 360]) < [900, 600]).all(axis=1)
    if valid.sum() >= 6:
        pose = pose_from_points(camera.intrinsics, points[valid], image[valid])
        found, residuals = fit_pose(Camera("any", camera.intrinsics, pose), points[valid], image[valid])
        assert np.abs(residuals).max() < 1e-7
        assert max(apart(found, camera)) < 1e-6


def test_a_pose_is_found_from_the_nominal_one():
    true = departed(overhead(), np.random.default_rng(1))
    numbers, image = seen_marks(true, POINTS)
    found, _ = fit_pose(overhead(), POINTS[numbers], image)
    assert max(apart(found, true)) < 1e-9


def drawn_calibration(rng, noise_px=0.025, spoiled=0):
    true = departed(overhead(), rng)
    guess = perturbed(true, np.concatenate([INTRINSIC_SIGMAS * rng.standard_normal(9), np.zeros(6)]))
    numbers, image = seen_marks(true, POINTS)
    image = image + rng.normal(0, noise_px, image.shape)
    image[:spoiled] += [0.8, -0.6]
    return true, calibrate_pose(guess, np.diag(INTRINSIC_SIGMAS**2), POINTS[numbers], image)


@pytest.mark.parametrize("spoiled", [0, 2])
def test_places_lie_in_the_ellipse_that_the_calibration_states(spoiled):
    rng = np.random.default_rng(2)
    image = rng.uniform([20, 20], [1260, 700], (20, 2))
    inside = []
    for _ in range(50):
        true, found = drawn_calibration(rng, spoiled=spoiled)
        exact, placed = place(true, image, 0.06), place(found.camera, image, 0.06)
        error = placed.positions_m - exact.positions_m
        covs = placed.by_parameters @ found.covariance @ np.swapaxes(placed.by_parameters, 1, 2)
        inside.append(np.einsum("ni,nij,nj->n", error, np.linalg.inv(covs), error) < CHI2_90)
    assert abs(np.mean(inside) - 0.90) < 0.05


def test_marks_improve_what_the_board_left_of_the_intrinsics_and_never_worsen_it():
    _, found = drawn_calibration(np.random.default_rng(3))
    assert (np.sqrt(np.diag(found.covariance)[:9]) <= INTRINSIC_SIGMAS * (1 + 1e-9)).all()


def test_known_intrinsics_stay_as_they_are():
    true = departed(overhead(), np.random.default_rng(4))
    numbers, image = seen_marks(true, POINTS)
    found = calibrate_pose(overhead(), np.zeros((9, 9)), POINTS[numbers], image)
    assert not found.covariance[:9].any()
    assert np.array_equal(found.camera.intrinsics.matrix, overhead().intrinsics.matrix)
    assert max(apart(found.camera, true)) < 1e-9


def test_too_many_misfits_are_refused():
    numbers, image = seen_marks(overhead(), POINTS)
    image[::2] += np.random.default_rng(5).normal(0, 20.0, image[::2].shape)
    with pytest.raises(CalibrationError, match="control points do not fit one pose"):
        calibrate_pose(overhead(), np.diag(INTRINSIC_SIGMAS**2), POINTS[numbers], image)


def test_too_few_points_are_refused():
    with pytest.raises(CalibrationError, match="3 control points; a pose needs at least 4"):
        fit_pose(overhead(), POINTS[:3], np.zeros((3, 2)))


def test_unequal_numbers_of_points_are_refused():
    with pytest.raises(InputError, match="6 points in the world but 5 in the image"):
        calibrate_pose(overhead(), np.zeros((9, 9)), POINTS[:6], np.zeros((5, 2)))


def test_a_covariance_that_is_none_is_refused():
    numbers, image = seen_marks(overhead(), POINTS)
    wrong = np.diag([1.0] * 9)
    wrong[0, 1] = wrong[1, 0] = 2.0
    with pytest.raises(InputError, match="not positive semi-definite"):
        calibrate_pose(overhead(), wrong, POINTS[numbers], image)
