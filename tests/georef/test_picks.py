import numpy as np
import pytest

from contracts import InputError
from georef.camera_models import Beliefs
from georef.geo_reference import GeoReference
from georef.ground_homography import GroundHomography
from georef.homography_file import read_found, write_homography
from georef.locate import locate_pixels
from georef.picks import LinePicks, PointPicks

TWO = np.zeros((2, 2))
COURSE = np.array([[0.0, 0, 0], [1, 0, 0]])
TURNED = GroundHomography("west", 640, 480, np.array([[0.0, -1, 320], [-1, 0, 240], [0, 0, 1.0]]), np.eye(9) * 1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PointPicks(("a",), TWO, np.zeros((2, 3)), np.zeros(2)), r"pixels has shape \(2, 2\), expected 1 x 2"),
        (lambda: PointPicks.exact(TWO * np.nan, np.zeros((2, 3))), "holds NaN"),
        (lambda: PointPicks(("a", "b"), TWO, np.zeros((2, 3)), np.array([0, -1.0])), "negative standard deviation"),
        (lambda: LinePicks(("a", "b"), TWO, (COURSE,), np.zeros(2)), "1 lines for 2 pixels"),
        (lambda: LinePicks(("a",), TWO[:1], (COURSE[:1],), np.zeros(1)), '"a" needs at least two different points'),
        (lambda: LinePicks(("a",), TWO[:1], (COURSE[[0, 0]],), np.zeros(1)), "each unlike the one before"),
        (lambda: LinePicks(("a",), TWO[:1], (COURSE,), np.array([-1.0])), "negative standard deviation"),
        (lambda: Beliefs(k1=0.0), "must be positive"),
        (lambda: GroundHomography("west", 6, 4, np.zeros((3, 3)), np.eye(9)), "singular"),
        (lambda: locate_pixels(TURNED, np.zeros(3)), "pixels has shape"),
        (lambda: locate_pixels(TURNED, TWO, heights_m=1.0), "knows the ground, z = 0, and no height above"),
    ],
)
def test_what_cannot_be_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_a_homography_is_read_back_to_the_bit(tmp_path):
    write_homography(tmp_path / "west.yaml", TURNED, GeoReference(37.398, 127.112))
    found, geo = read_found(tmp_path / "west.yaml")
    assert isinstance(found, GroundHomography)
    assert found.image_from_ground.tobytes() == TURNED.image_from_ground.tobytes()
    assert found.covariance.tobytes() == TURNED.covariance.tobytes()
    assert geo == GeoReference(37.398, 127.112)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("image_from_ground: 3\n", "missing required field|Expected"),
        ("name: a\nwidth_px: 6\nheight_px: 4\nimage_from_ground: [[1]]\ncovariance: [[1]]\n", "has shape"),
        ("name: a\nwidth_px: 6\nheight_px: 4\nimage_from_ground: [[1], [1, 2]]\ncovariance: [[1]]\n", "inhomogeneous"),
    ],
)
def test_a_wrong_homography_file_is_named(tmp_path, text, message):
    (tmp_path / "west.yaml").write_text(text)
    with pytest.raises(InputError, match=rf"west\.yaml: .*({message})"):
        read_found(tmp_path / "west.yaml")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.yaml: cannot be read"):
        read_found(tmp_path / "absent.yaml")
