import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from map_cases import SIZE, STRONG_LENS, ground_points, image, line_picks, picks, pole, poles

from contracts import CalibrationError, Camera, InputError, Pose
from georef.ground_homography import place_by_homography
from georef.homography import image_from_plane, transform
from georef.location import place
from georef.map_calibration import calibrate_camera, calibrate_homography, calibrate_pan_tilt
from georef.mixture import Noise
from georef.picks import PointPicks

WHOLE = pole(roll_deg=1.0, offset_px=(18.0, -12.0), distortion=STRONG_LENS)
PLAIN = pole()


def rng():
    return np.random.default_rng(0)


def road_error_m(camera, true, seed=0):
    """Largest error of places on the road that the found camera makes, within 60 m."""
    places = ground_points(true, 30, np.random.default_rng(seed))
    return np.abs(place(camera, image(true, places), 0.0).positions_m - places[:, :2]).max()


@settings(max_examples=6)
@given(poles(), st.integers(0, 1000))
def test_picks_without_noise_give_the_camera_back(true, seed):
    found = calibrate_camera("pole", SIZE, picks(true, seed, raised=0.3), rng=rng(), noise=Noise(1e-3))
    camera = found.calibrated.camera
    assert road_error_m(camera, true) < 0.005  # the beliefs' pull at a millipixel's noise
    assert found.picks.good.min() > 0.99


@settings(max_examples=6)
@given(poles(plain=True), st.integers(0, 1000))
def test_pan_and_tilt_come_back(true, seed):
    found = calibrate_pan_tilt("pole", SIZE, picks(true, seed), rng=rng(), noise=Noise(1e-3)).calibrated.camera
    assert np.abs(found.pose.position_m - true.pose.position_m).max() < 1e-5
    assert np.abs(found.pose.world_from_camera - true.pose.world_from_camera).max() < 1e-7
    assert abs(found.intrinsics.fx_px - true.intrinsics.fx_px) < 1e-3


@settings(max_examples=6)
@given(poles(plain=True), st.integers(0, 1000))
def test_a_homography_comes_back_and_is_opencv_s(true, seed):
    given_picks = picks(true, seed, raised=0.0)
    found = calibrate_homography("pole", SIZE, given_picks, rng=rng(), noise=Noise(1e-3)).homography
    exact = image_from_plane(true)
    exact = exact / np.linalg.norm(exact) * np.sign(exact[2] @ [*given_picks.points_m[0, :2], 1.0])
    assert np.abs(found.image_from_ground - exact).max() < 1e-8
    places = given_picks.points_m[:, :2]
    theirs = np.asarray(cv2.findHomography(places, given_picks.pixels)[0])
    assert np.abs(transform(theirs, places) - transform(found.image_from_ground, places)).max() < 1e-3  # px


def test_relabelling_the_picks_changes_nothing():
    given_picks = picks(WHOLE, 1, noise_px=1.0, wrong=2)
    order = np.random.default_rng(5).permutation(25)
    turned = PointPicks.exact(given_picks.pixels[order], given_picks.points_m[order])
    first = calibrate_camera("pole", SIZE, given_picks, rng=rng()).calibrated.camera
    second = calibrate_camera("pole", SIZE, turned, rng=np.random.default_rng(9)).calibrated.camera
    assert np.abs(first.pose.position_m - second.pose.position_m).max() < 1e-3
    assert road_error_m(second, first) < 1e-3


def test_moving_the_world_moves_the_camera():
    given_picks = picks(WHOLE, 2, noise_px=1.0)
    angle, shift = 0.7, np.array([300.0, -120.0, 5.0])
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    moved = PointPicks.exact(given_picks.pixels, given_picks.points_m @ turn.T + shift)
    first = calibrate_camera("pole", SIZE, given_picks, rng=rng()).calibrated.camera
    second = calibrate_camera("pole", SIZE, moved, rng=rng()).calibrated.camera
    carried = Camera(
        "pole", first.intrinsics, Pose(turn @ first.pose.world_from_camera, turn @ first.pose.position_m + shift)
    )
    assert np.abs(carried.pose.position_m - second.pose.position_m).max() < 1e-3
    assert np.abs(carried.pose.world_from_camera - second.pose.world_from_camera).max() < 1e-5


@pytest.mark.parametrize("calibrate", [calibrate_camera, calibrate_pan_tilt])
@pytest.mark.parametrize("seed", range(3))
def test_wrong_picks_move_the_image_of_the_road_by_less_than_a_pixel(calibrate, seed):
    true = WHOLE if calibrate is calibrate_camera else PLAIN
    spoiled = picks(true, seed, noise_px=1.0, wrong=3)
    right = np.arange(25) >= 3
    found = calibrate("pole", SIZE, spoiled, rng=rng())
    clean = calibrate("pole", SIZE, spoiled.chosen(right), rng=rng())
    places = ground_points(true, 30, np.random.default_rng(3))
    gap = image(found.calibrated.camera, places) - image(clean.calibrated.camera, places)
    assert np.abs(gap).max() < 0.5
    assert (found.picks.good[:3] < 0.5).all()


def test_the_covariance_grows_with_the_square_of_the_noise():
    small, large = (
        calibrate_pan_tilt("pole", SIZE, picks(PLAIN, 4, noise_px=noise), rng=rng(), noise=Noise(noise)).calibrated
        for noise in (0.01, 0.02)
    )
    free = np.diag(small.covariance) > 0
    ratio = np.diag(large.covariance)[free] / np.diag(small.covariance)[free]
    assert np.abs(ratio - 4.0).max() < 0.05


def test_lines_alone_can_tell_the_lens():
    """With points enough for the pose, lines add what bends: the covariance of k1 falls."""
    points = picks(WHOLE, 6, count=9, noise_px=1.0)
    bare = calibrate_camera("pole", SIZE, points, rng=rng(), noise=Noise(1.0, 1e6)).calibrated
    lines = line_picks(WHOLE, 7, noise_px=1.0)
    found = calibrate_camera("pole", SIZE, points, lines, rng=rng(), noise=Noise(1.0, 1e6))
    assert found.calibrated.covariance[4, 4] < 0.8 * bare.covariance[4, 4]
    assert np.abs(found.picks.line_residuals_px).max() < 5.0
    assert found.picks.line_good.min() > 0.5


def test_a_wrong_pixel_on_a_line_is_told():
    lines = line_picks(WHOLE, 8, noise_px=1.0)
    pixels = lines.pixels.copy()
    pixels[2] += [60.0, 0.0]
    found = calibrate_camera(
        "pole",
        SIZE,
        picks(WHOLE, 8, noise_px=1.0),
        type(lines)(lines.names, pixels, lines.lines_m, lines.sigmas_m),
        rng=rng(),
    )
    assert np.flatnonzero(found.picks.line_good < 0.5).tolist() == [2]


def test_locating_by_homography_is_locating_by_its_camera():
    found = calibrate_homography("pole", SIZE, picks(PLAIN, 3, raised=0.0), rng=rng(), noise=Noise(1e-3)).homography
    places = ground_points(PLAIN, 20, np.random.default_rng(1))
    placed = place_by_homography(found, image(PLAIN, places))
    assert placed.valid.all()
    assert np.abs(placed.positions_m - places[:, :2]).max() < 1e-5
    assert np.abs(placed.by_pixel - place(PLAIN, image(PLAIN, places), 0.0).by_pixel).max() < 1e-5
    assert not place_by_homography(found, np.array([[960.0, -5000.0]])).valid.any()


def along_a_line(camera):
    ahead = camera.pose.world_from_camera[:2, 2]
    places = np.column_stack([camera.pose.position_m[:2] + np.linspace(20, 50, 25)[:, None] * ahead, np.zeros(25)])
    return PointPicks.exact(image(camera, places) + np.random.default_rng(0).normal(0, 1, (25, 2)), places)


def within(camera, low, high):
    everywhere = picks(camera, 0, count=400)
    chosen = ((everywhere.pixels > low) & (everywhere.pixels < high)).all(axis=1)
    return everywhere.chosen(chosen & (np.cumsum(chosen) <= 25))


def behind(camera):
    ahead = picks(camera, 0, noise_px=1.0)
    return PointPicks.exact(ahead.pixels[::-1], ahead.points_m * [1, 1, 1] + np.array([0, 0, 500.0]))


@pytest.mark.parametrize(
    ("given_picks", "reason"),
    [
        (picks(WHOLE, 0, count=5), "5 points.*at least"),
        (along_a_line(WHOLE), "lie on a line on the map"),
        (within(WHOLE, [0, 0], [600, 1080]), "left third of the image, all on one side"),
        (within(WHOLE, [0, 750], [1920, 1080]), "lower third of the image"),
        (within(WHOLE, [850, 300], [1000, 700]), "cover .* of the image; spread them out"),
        (PointPicks.exact(np.random.default_rng(1).uniform(0, 1000, (25, 2)), picks(WHOLE, 0).points_m), "do not fit"),
        (behind(WHOLE), "do not fit|before it|below the ground"),
    ],
)
def test_picks_that_determine_no_camera_are_refused_with_the_reason(given_picks, reason):
    for calibrate in (calibrate_camera, calibrate_pan_tilt):
        with pytest.raises(CalibrationError, match=reason):
            calibrate("pole", SIZE, given_picks, rng=rng())


def test_a_homography_needs_points_on_the_ground():
    high = picks(PLAIN, 0, raised=1.0)
    with pytest.raises(CalibrationError, match="0 points on the ground"):
        calibrate_homography("pole", SIZE, high, rng=rng())


def test_an_empty_image_is_refused():
    with pytest.raises(InputError, match="0 x 5 px is not positive"):
        calibrate_camera("pole", (0, 5), picks(PLAIN, 0), rng=rng())
