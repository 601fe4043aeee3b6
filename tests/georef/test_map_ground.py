"""Places on a road that climbs: a plane's closed form, round trips over a bumpy map, derivatives by differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts import Camera, InputError, Intrinsics, Pose
from georef.calibrated import CalibratedCamera
from georef.geo_reference import GeoReference
from georef.ground_homography import GroundHomography
from georef.hd_map import HdMap, LaneCentreline, RoadClass
from georef.locate import locate_pixels
from georef.map_ground import MapGround, place_on_ground
from georef.projection import project
from scenarios.network_file import load_network
from sim.rig import look_down
from sim.road_map import map_of_network

GRADE = map_of_network(load_network("avenue_grade"))
CAMERA = Camera(
    "pole",
    Intrinsics(1280, 720, 850.0, 850.0, 640.0, 360.0, np.array([-0.1, 0.02, 0.0, 0.0, 0.0])),
    Pose(look_down(66.0, 45.0), np.array([-18.0, -18.0, 9.0])),
)


def lanes(height_of):
    """A grid of lanes whose heights are a function of east and north."""
    along = np.arange(-60.0, 61.0, 4.0)
    lines = []
    for north in along[::2].tolist():
        places = np.column_stack([along, np.full(len(along), north)])
        points = np.column_stack([places, height_of(places)])
        lines.append(LaneCentreline(f"lane {north:g}", points, road_class=RoadClass.CITY, width_m=3.0))
    return HdMap(GeoReference(37.398, 127.112), centrelines=tuple(lines))


def tilted(places):
    return 0.5 + places @ [0.03, -0.02]


@given(st.floats(-20.0, 30.0), st.floats(-20.0, 30.0), st.floats(0.0, 2.0))
def test_what_is_imaged_on_a_tilted_plane_is_found_there(east, north, above):
    ground = MapGround.of(lanes(tilted))
    place = np.array([[east, north, float(tilted(np.array([east, north]))) + above]])
    pixels, valid = project(CAMERA, place)
    if valid[0]:
        found = place_on_ground(CAMERA, pixels, np.array([above]), ground)
        assert found.valid[0]
        assert np.allclose(found.positions_m, place[:, :2], rtol=0, atol=1e-5)


@pytest.mark.parametrize("share", [0.5, 0.9, 0.98])
def test_a_ray_meets_ground_that_climbs_almost_as_fast_as_it_falls(share):
    """Heights taken by turns from the ground and the ray would swing for ever; the place is seen all the same."""
    eye = CAMERA.pose.position_m
    place = np.array([30.0, 30.0])
    reach = float(np.linalg.norm(place - eye[:2]))
    slope = share * float(eye[2]) / (reach * (1.0 + share))  # the ray falls by eye[2] / (reach * (1 + share)) a metre
    towards = (place - eye[:2]) / reach

    def climbing(places):
        return slope * ((places - eye[:2]) @ towards)

    ground = MapGround.of(lanes(climbing))
    seen = np.array([[*place, float(climbing(place))]])
    pixels, valid = project(replace(CAMERA, pose=Pose(look_down(80.0, 45.0), eye)), seen)
    assert valid[0]
    found = place_on_ground(replace(CAMERA, pose=Pose(look_down(80.0, 45.0), eye)), pixels, np.zeros(1), ground)
    assert np.allclose(found.positions_m, seen[:, :2], rtol=0, atol=1e-5)


def test_straight_down_is_below_the_camera():
    camera = replace(CAMERA, pose=Pose(np.diag([1.0, -1.0, -1.0]), CAMERA.pose.position_m))
    found = place_on_ground(camera, np.array([[640.0, 360.0]]), np.zeros(1), MapGround.of(lanes(tilted)))
    assert np.allclose(found.positions_m, camera.pose.position_m[None, :2], rtol=0, atol=1e-9)


def test_on_the_network_s_grade_every_lane_is_found_where_it_is():
    ground = MapGround.of(GRADE)
    assert not ground.is_level
    places = np.concatenate([lane.places_m(np.arange(0.0, lane.length_m, 5.0)) for lane in GRADE.centrelines])
    assert np.allclose(ground.heights_m(places[:, :2]), places[:, 2], rtol=0, atol=0.02)
    eye = np.append(places[0, :2], places[0, 2] + 9.0)
    ahead = places[len(places) // 2, :2] - places[0, :2]
    camera = replace(CAMERA, pose=Pose(look_down(80.0, np.degrees(np.arctan2(ahead[1], ahead[0]))), eye))
    near = places[(np.linalg.norm(places[:, :2] - eye[:2], axis=1) < 60.0)]
    pixels, valid = project(camera, near)
    inside = valid & (pixels > 0).all(axis=1) & (pixels < (1279, 719)).all(axis=1)
    assert inside.sum() > 5
    found = place_on_ground(camera, pixels[inside], np.zeros(int(inside.sum())), ground)
    assert np.allclose(found.positions_m, near[inside, :2], rtol=0, atol=0.2)  # 2 cm of height, seen at 9 m from 60 m


def test_derivatives_are_those_of_small_differences():
    ground = MapGround.of(lanes(tilted))
    pixels, above = np.array([[500.0, 420.0], [800.0, 600.0]]), np.zeros(2)
    placed = place_on_ground(CAMERA, pixels, above, ground)
    for axis in range(2):
        step = 0.01 * np.eye(2)[axis]
        ahead = place_on_ground(CAMERA, pixels + step, above, ground).positions_m
        behind = place_on_ground(CAMERA, pixels - step, above, ground).positions_m
        assert np.allclose(placed.by_pixel[:, :, axis], (ahead - behind) / 0.02, rtol=0, atol=1e-4)
    moved = replace(
        CAMERA, pose=Pose(CAMERA.pose.world_from_camera, CAMERA.pose.position_m + np.array([0.0, 0.0, 0.001]))
    )
    ahead = place_on_ground(moved, pixels, above, ground).positions_m
    by_height = (ahead - placed.positions_m) / 0.001
    assert np.allclose(placed.by_parameters[:, :, 14], by_height, rtol=0, atol=1e-2)


def test_level_ground_is_the_plane_and_a_ray_to_the_sky_meets_nothing():
    level = MapGround.of(lanes(lambda places: np.zeros(len(places))))
    assert level.is_level
    pixels = np.array([[640.0, 600.0], [640.0, -400.0]])
    calibrated = CalibratedCamera(CAMERA, np.zeros((15, 15)))
    flat, found = locate_pixels(calibrated, pixels), locate_pixels(calibrated, pixels, ground=level)
    assert flat.valid.tolist() == found.valid.tolist() == [True, False]
    assert np.allclose(flat.positions_m[0], found.positions_m[0], rtol=0, atol=1e-9)


def test_without_lines_there_is_no_ground_and_a_homography_cannot_climb():
    with pytest.raises(InputError, match="no line"):
        MapGround([])
    homography = GroundHomography("h", 1280, 720, np.diag([1.0, 1.0, 1.0]), np.zeros((9, 9)))
    with pytest.raises(InputError, match="no height above it"):
        locate_pixels(homography, np.array([[1.0, 2.0]]), ground=MapGround.of(lanes(tilted)))
