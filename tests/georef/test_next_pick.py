import numpy as np
from map_cases import PLAIN_PICKS_SEED, SIZE, ground_points, image, picks, pole

from georef.map_calibration import calibrate_homography, calibrate_pan_tilt
from georef.mixture import Noise
from georef.next_pick import choose, gains
from georef.picks import PointPicks

TRUE = pole()
KNOWN = Noise(1.0, 1e9)  # the noise is believed firmly, so that covariances depend on geometry alone


def rng():
    return np.random.default_rng(0)


def test_the_drop_that_is_promised_is_the_drop_that_comes():
    start = picks(TRUE, PLAIN_PICKS_SEED, count=10, raised=0.0)
    candidates = ground_points(TRUE, 12, np.random.default_rng(4))
    road = ground_points(TRUE, 40, np.random.default_rng(5))[:, :2]
    for calibrate, part in ((calibrate_pan_tilt, "calibrated"), (calibrate_homography, "homography")):
        found = getattr(calibrate("pole", SIZE, start, rng=rng(), noise=KNOWN), part)
        promised = gains(found, candidates, road)
        best = promised.best
        more = PointPicks.exact(
            np.vstack([start.pixels, image(TRUE, candidates[best])]), np.vstack([start.points_m, candidates[best]])
        )
        again = getattr(calibrate("pole", SIZE, more, rng=rng(), noise=KNOWN), part)
        came = promised.now_m2 - gains(again, candidates, road).now_m2
        assert came > 0
        assert abs(came - promised.drops_m2[best]) < 0.02 * came
        assert choose(found, candidates, road, 1) == [best]


def test_what_the_camera_does_not_see_brings_nothing():
    found = calibrate_pan_tilt("pole", SIZE, picks(TRUE, 1), rng=rng()).calibrated
    behind = np.array([[-30.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    gain = gains(found, behind, np.array([[30.0, 8.0]]))
    assert np.isnan(gain.drops_m2).all()
    assert gain.best is None
    assert choose(found, behind, np.array([[30.0, 8.0]]), 3) == []


def test_each_choice_is_another_one():
    found = calibrate_pan_tilt("pole", SIZE, picks(TRUE, 1), rng=rng()).calibrated
    candidates = ground_points(TRUE, 9, np.random.default_rng(4))
    assert sorted(choose(found, candidates, candidates[:, :2], 20)) == list(range(9))
