"""Cameras found again from pictures in which OpenCV drew the map's paint, and from film."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, Frame, Intrinsics, Pose
from georef.hd_map import AreaKind
from perception.frame_calibration import calibrate_from_frames
from perception.lane_paths import lane_path
from perception.road_paint import brightness
from scenarios.network_file import load_network
from sim.projection import project
from sim.rig import look_down
from sim.road_map import map_of_network
from sim.road_surface import painted, road_area

CROSSROADS = map_of_network(load_network("crossroads"))
LENS = np.array([-0.1, 0.03, 0.0, 0.0, 0.0])


def nominal_camera(position_m=(-17.0, -17.0, 8.0)) -> Camera:
    plain = Intrinsics(1280, 720, 850.0, 850.0, 639.5, 359.5, np.zeros(5))
    return Camera("pole", plain, Pose(look_down(66.0, 45.0), np.array(position_m)))


def true_camera() -> Camera:
    nominal = nominal_camera()
    turn = Rotation.from_rotvec(np.radians([0.9, -1.4, 0.8])).as_matrix()
    pose = Pose(turn @ nominal.pose.world_from_camera, nominal.pose.position_m + np.array([0.04, -0.05, 0.03]))
    lens = Intrinsics(1280, 720, 852.5, 852.5, 643.0, 355.0, LENS)
    return replace(nominal, intrinsics=lens, pose=pose)


def picture(camera: Camera) -> np.ndarray:
    """The crossroads' paint, drawn by OpenCV four times as large and averaged; noise as of a sensor."""
    image = np.full((720 * 4, 1280 * 4), 78, np.uint8)
    ahead = shapely.Polygon([(-20, -17), (-17, -20), (100, -20), (100, 100), (-20, 100)])  # before this camera
    for colour in {line.colour for line in CROSSROADS.lane_markings}:
        for outline in painted(CROSSROADS, colour):
            for part in (part for part in shapely.get_parts(outline.intersection(ahead)) if part.area > 0):
                ring = np.array(part.segmentize(0.5).exterior.coords)
                pixels, valid = project(camera, np.column_stack([ring, np.zeros(len(ring))]))
                if valid.all():
                    fixed = np.rint((pixels + 0.5) * 4 * 16).astype(np.int32) - 8
                    cv2.fillPoly(image, [fixed], 225, cv2.LINE_8, 4)
    small = cv2.resize(image, (1280, 720), interpolation=cv2.INTER_AREA).astype(np.float64)
    small = cv2.GaussianBlur(small, (0, 0), 0.5)
    small += np.random.default_rng(2).normal(0.0, 1.5, small.shape)
    return np.repeat(np.clip(small, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def test_pose_and_lens_come_back_from_a_picture_of_the_paint():
    true = true_camera()
    frame = Frame("pole", 0, 0, picture(true))
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
    from sim.road_surface import crosswalk_bars

    for area in CROSSROADS.painted_areas:
        assert area.kind is AreaKind.CROSSWALK
        bars = list(crosswalk_bars(area))
        corners = np.array([bars[0].exterior.coords[0], bars[-1].exterior.coords[1]])
        half = len(area.ring_m) // 2
        assert np.allclose(corners, area.ring_m[[0, half - 1], :2], atol=1e-9, rtol=0)
