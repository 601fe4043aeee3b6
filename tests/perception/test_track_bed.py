"""What may be a vehicle by the plan of the track: near the middle of a line, as far as the anchor knows where it is."""

import numpy as np
import pytest
from drawn_frames import COLOURS_BGR, FOCAL_PX, HEIGHT_M, Box, draw, floor, frame_of
from hypothesis import given
from hypothesis import strategies as st

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from georef.location import on_plane
from georef.projection import project
from perception.anchor import Anchor
from perception.colour_models import BOTH
from perception.hybrid import HybridTracker
from perception.track_bed import BESIDE_M, SIGMAS, TrackBed
from perception.view import straight_down

ROOF_M = 0.06
LENS = np.array([-0.045, 0.008, 0.0002, -0.0003, 0.0])
CAMERA = Camera(
    "west",
    Intrinsics(1280, 720, 900.0, 900.0, 640.0, 355.0, LENS),
    Pose(np.diag([1.0, -1.0, -1.0]), np.array([0, 0, 2])),
)
RADIUS_M = 0.4
ANGLES = np.linspace(0, 2 * np.pi, 252)
CIRCLE_M = RADIUS_M * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
WEST = straight_down(FOCAL_PX, HEIGHT_M, (640, 360), name="west")


def anchor_at(place_m: FloatArray, sigma_px: float = 0.1) -> Anchor:
    point_px, _ = project(CAMERA, np.append(place_m, ROOF_M))
    return Anchor(point_px, np.eye(2) * sigma_px**2, np.zeros((4, 2)), 1.0, np.eye(2), (BOTH, BOTH))


@given(st.floats(0, 2 * np.pi), st.floats(-0.15, 0.15), st.floats(0.1, 5.0))
def test_a_roof_is_borne_if_it_lies_over_the_track_as_far_as_its_place_is_known(angle_rad, off_m, sigma_px):
    place_m = (RADIUS_M + off_m) * np.array([np.cos(angle_rad), np.sin(angle_rad)])
    far = BESIDE_M + SIGMAS * sigma_px / 420.0  # the camera's scale is 464 px per metre in the middle, less aside
    borne = TrackBed(CAMERA, [CIRCLE_M], ROOF_M).bears(anchor_at(place_m, sigma_px))
    if abs(off_m) < BESIDE_M:
        assert borne
    if abs(off_m) > far:
        assert not borne


def test_nothing_stands_beyond_the_end_of_a_line_or_where_the_camera_sees_no_track():
    line_m = np.array([(0.0, 0.0), (0.3, 0.0)])
    ends = TrackBed(CAMERA, [np.linspace(*line_m, 31)], ROOF_M)
    assert ends.bears(anchor_at(np.array([0.31, 0.0])))
    assert not ends.bears(anchor_at(np.array([0.35, 0.0])))
    behind = Camera("up", CAMERA.intrinsics, Pose(np.eye(3), np.array([0.0, 0.0, 2.0])))
    assert not TrackBed(behind, [line_m], ROOF_M).bears(anchor_at(np.array([0.1, 0.0])))


@pytest.fixture
def straight_track_m() -> FloatArray:
    """The ground below the row of pixels v = 100."""
    columns_px = np.stack([np.linspace(-100, 740, 300), np.full(300, 100.0)], axis=1)
    return on_plane(WEST, columns_px, ROOF_M)[0][:, :2]


def test_what_looks_like_a_vehicle_beside_the_track_is_never_taken_for_it(models, straight_track_m):
    """A book, larger than the vehicle, lies there all the time; the vehicle comes, passes and goes."""
    book = Box("red", (420.0, 260.0), heading_rad=0.3, size_px=(76.0, 37.0), colour_bgr=COLOURS_BGR["red"])
    background = draw(floor(np.random.default_rng(3)), [book])
    tracker = HybridTracker(models, WEST, centrelines_m=[straight_track_m])
    for index in range(34):
        vehicle = Box("red", (25.0 * index - 90.0, 100.0))
        tracks = tracker.perceive(frame_of(draw(background, [vehicle]), index))
        assert (np.abs(tracks.objects.anchors_px[:, 1] - 100.0) < 1.0).all()
        if 36 < vehicle.centre_px[0] < 604:
            assert np.abs(tracks.objects.anchors_px[0] - vehicle.centre_px).max() < 0.2


def test_where_the_track_lies_is_of_no_use_without_the_camera(models, straight_track_m):
    with pytest.raises(InputError, match="camera"):
        HybridTracker(models, centrelines_m=[straight_track_m])
