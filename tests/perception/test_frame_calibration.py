"""Cameras found again from pictures in which OpenCV drew the map's paint."""

import numpy as np
import pytest

from contracts import CalibrationError, Frame
from georef.hd_map import AreaKind
from georef.locate import locate_pixels
from perception.frame_calibration import calibrate_from_frames
from perception.lane_paths import lane_path
from perception.road_paint import brightness
from scenarios.network_file import load_network
from sim.projection import project
from sim.road_surface import crosswalk_bars, road_area
from tests.perception.drawn_road import CROSSROADS, LENS, ROUNDABOUT, nominal_camera, picture, true_camera


def test_pose_and_lens_come_back_from_a_picture_of_the_paint():
    true = true_camera(nominal_camera())
    frame = Frame("pole", 0, 0, picture(true, CROSSROADS))
    found = calibrate_from_frames([frame], nominal_camera(), CROSSROADS)
    camera = found.calibrated.camera
    road = road_area(load_network("crossroads"))
    low, high = np.array(road.bounds[:2]), np.array(road.bounds[2:])
    places = np.random.default_rng(0).uniform(low, high, (4000, 2))
    places = places[np.linalg.norm(places - true.pose.position_m[:2], axis=1) < 40.0]
    in_space = np.column_stack([places, np.zeros(len(places))])
    pixels, valid = project(true, in_space)
    inside = valid & (pixels > 0).all(axis=1) & (pixels < (1279, 719)).all(axis=1)
    apart = np.linalg.norm(project(camera, in_space[inside])[0] - pixels[inside], axis=1)
    assert apart.mean() < 0.5
    assert abs(camera.intrinsics.distortion[0] - LENS[0]) < 0.03
    assert np.linalg.norm(camera.pose.position_m - true.pose.position_m) < 0.1
    assert found.picks.noise_px < 0.35
    lane = next(lane for lane in CROSSROADS.centrelines if lane.id == "north_in_2")
    path = lane_path(brightness(frame.image), camera, lane)
    assert path is not None
    assert np.isfinite(path.pixels).all()


def test_four_short_strokes_on_either_side_of_a_roundabout_are_enough():
    nominal = nominal_camera((-24.0, -24.0, 9.0))
    true = true_camera(nominal)
    found = calibrate_from_frames([Frame("pole", 0, 0, picture(true, ROUNDABOUT))], nominal, ROUNDABOUT)
    places = np.array([[x, y, 0.0] for x in (-15.0, -5.0, 5.0) for y in (-15.0, -5.0, 5.0)])
    pixels, valid = project(true, places)
    located = locate_pixels(found.calibrated, pixels[valid], covs_px2=np.zeros((int(valid.sum()), 2, 2)))
    assert np.linalg.norm(located.positions_m - places[valid, :2], axis=1).mean() < 0.15


def test_without_paint_it_is_refused():
    grey = Frame("pole", 0, 0, np.full((720, 1280, 3), 90, np.uint8))
    with pytest.raises(CalibrationError, match="points and pixels on lines"):
        calibrate_from_frames([grey], nominal_camera(), CROSSROADS)


def test_far_from_the_map_it_is_refused():
    away = nominal_camera(position_m=(900.0, 900.0, 8.0))
    grey = Frame("pole", 0, 0, np.full((720, 1280, 3), 90, np.uint8))
    with pytest.raises(CalibrationError, match="hardly any paint"):
        calibrate_from_frames([grey], away, CROSSROADS)


def test_crosswalks_begin_and_end_with_a_bar():
    for area in CROSSROADS.painted_areas:
        assert area.kind is AreaKind.CROSSWALK
        bars = list(crosswalk_bars(area))
        corners = np.array([bars[0].exterior.coords[0], bars[-1].exterior.coords[1]])
        half = len(area.ring_m) // 2
        assert np.allclose(corners, area.ring_m[[0, half - 1], :2], atol=1e-9, rtol=0)
