"""Lights and weathers of the road: laws of air, lamps, mirrors and rain, by numbers alone."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from road_film_cases import pole_camera, users

from contracts import InputError
from scenarios.check import faults
from scenarios.loader import load_scenario
from sim.air import VISIBILITY_M, Air, Weather, diffused, rays_of
from sim.body_shapes import Wardrobe
from sim.contact import contact_shade, shade_corners
from sim.headlamps import Lamps, beams_of
from sim.lamplight import irradiance, near
from sim.lights import RAIL_LIGHTS, ROAD_LIGHTS, LightPreset, light_at
from sim.mirror import reflected, schlick
from sim.projection import project
from sim.rain import Rain, RainSpec
from sim.roadside import LAMP_HEIGHT_M
from sim.sight import surfaces_at

WARDROBE = Wardrobe(1)
UP = np.array([0.0, 0.0, 1.0], np.float32)
weathers = st.sampled_from(Weather)
lights = st.sampled_from(ROAD_LIGHTS).map(lambda light: light_at(light, 0))
ranges_m = st.floats(0.0, 500.0)


def single(*values: float) -> np.ndarray:
    return np.array(values, np.float32)


@given(weathers, lights, ranges_m, ranges_m)
def test_air_lets_through_what_its_two_halves_let_through(weather, light, a_m, b_m):
    air = Air.of(weather, light)
    both, first, second = air.transmission(single(a_m + b_m, a_m, b_m)).tolist()
    assert abs(both - first * second) < 1e-6


@given(weathers, lights)
def test_at_the_visibility_two_percent_of_a_contrast_are_left(weather, light):
    black_and_white = np.array([[[0.0] * 3, [255.0] * 3]], np.float32)
    seen = Air.of(weather, light).seen_through(black_and_white, np.full((1, 2), VISIBILITY_M[weather], np.float32))
    assert np.abs((seen[0, 1] - seen[0, 0]) / 255.0 - 0.02).max() < 1e-4


@given(st.floats(0.3, 1.5), st.floats(-3.1, 3.1), st.floats(4.0, 20.0), st.floats(1.0, 3.0))
def test_lamplight_obeys_the_inverse_square(below_rad, azimuth_rad, range_m, times):
    lamp = np.array([[3.0, -2.0, 8.0]])
    level = np.cos(below_rad)
    away = np.array([level * np.cos(azimuth_rad), level * np.sin(azimuth_rad), -np.sin(below_rad)])
    places = np.array([lamp[0] + range_m * away, lamp[0] + times * range_m * away], np.float32)
    close, far = irradiance(places, np.broadcast_to(-away.astype(np.float32), (2, 3)), lamp).tolist()
    assert far * times**2 == pytest.approx(close, rel=1e-4)


@given(st.lists(st.tuples(st.floats(-40, 40), st.floats(-40, 40)), min_size=2, max_size=6), st.integers(0, 2**16))
def test_lamplight_adds_up(places, seed):
    lamps = np.array([(x, y, LAMP_HEIGHT_M) for x, y in places])
    rng = np.random.default_rng(seed)
    points, normals = rng.uniform(-20, 20, (50, 3)).astype(np.float32), rng.normal(size=(50, 3)).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    alone = sum(irradiance(points, normals, lamp[None]) for lamp in lamps)
    assert np.abs(irradiance(points, normals, lamps) - alone).max() < 1e-4
    left_out = irradiance(points, normals, lamps) - irradiance(points, normals, near(lamps, points))
    assert np.abs(left_out).max() < 0.03


def test_a_lamp_lights_the_ground_below_it_with_one_and_nothing_above():
    lamp = np.array([[0.0, 0.0, LAMP_HEIGHT_M]])
    below, above = irradiance(np.array([(0, 0, 0), (0, 0, 12)], np.float32), np.stack([UP, -UP]), lamp).tolist()
    assert (below, above) == (pytest.approx(1.0, abs=1e-5), 0.0)


@given(st.floats(-0.8, 0.8), st.floats(-0.8, 0.8))
def test_normals_are_those_of_the_plane_that_is_seen(slope_x, slope_y):
    camera = pole_camera(40, 24)
    normal = np.array([-slope_x, -slope_y, 1.0]) / np.sqrt(1 + slope_x**2 + slope_y**2)
    rays = rays_of(camera).astype(np.float64)
    depth = -(camera.pose.position_m @ normal) / (rays @ normal)  # the plane goes through the world's origin
    seen = (depth > 1.0) & (depth < 200.0)
    where = cv2.erode(seen.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    points, found = surfaces_at(camera, np.where(seen, depth, 1e4).astype(np.float32), where)
    towards = normal * np.sign(camera.pose.position_m @ normal)
    assert np.abs(found - towards).max(initial=0.0) < 0.02  # of depths of single precision
    assert np.abs(points @ normal).max(initial=0.0) < 1e-3


slopes = st.floats(-0.05, 0.05)


@given(slopes, slopes, st.floats(-2, 2), st.tuples(st.floats(-15, 15), st.floats(-15, 15), st.floats(0.0, 6.0)))
def test_a_mirror_image_is_where_the_mirrored_point_would_be_seen(slope_x, slope_y, offset_m, point_m):
    camera = pole_camera()
    normal = np.array([-slope_x, -slope_y, 1.0])
    normal /= np.linalg.norm(normal)
    point = np.array(point_m)
    mirrored = point + 2.0 * (offset_m - normal @ point) * normal
    pixel, valid = project(reflected(camera, normal, offset_m), point)
    straight, expected_valid = project(camera, mirrored)
    if valid and expected_valid:
        flipped = np.array([camera.intrinsics.width_px - 1 - pixel[0], pixel[1]])
        assert np.abs(flipped - straight).max() < 1e-6
    turn = reflected(camera, normal, offset_m).pose.world_from_camera
    assert np.linalg.det(turn) == pytest.approx(1.0, abs=1e-12)


def test_water_mirrors_everything_at_grazing_light_and_next_to_nothing_from_above():
    shares = schlick(np.linspace(0.0, 1.0, 11, dtype=np.float32))
    assert (np.diff(shares) <= 0).all()
    assert shares[[0, -1]].tolist() == pytest.approx([1.0, 0.02], abs=1e-6)


def test_rain_is_the_same_again_in_its_frame_and_another_in_the_next():
    grey = np.full((180, 320, 3), 90, np.uint8)
    spec = RainSpec(110.0, 0.004)
    one, same = (Rain(spec, "west", (320, 180), 210.0, seed=5) for _ in range(2))
    other = Rain(spec, "east", (320, 180), 210.0, seed=5)
    assert (one.before(grey, 7) == same.before(grey, 7)).all()
    assert (one.before(grey, 7) != one.before(grey, 8)).any()
    assert (one.before(grey, 7) != other.before(grey, 7)).any()
    assert (grey == 90).all()


@given(st.floats(0.0, 255.0), st.floats(0.0, 0.03), st.integers(0, 100))
def test_rain_changes_the_mean_of_a_picture_by_little_and_darkens_nothing(level, exposure_s, index):
    grey = np.full((180, 320, 3), 90, np.uint8)
    wet = Rain(RainSpec(level, exposure_s), "west", (320, 180), 210.0, seed=index).before(grey, index)
    assert (wet >= grey).all()
    assert wet.mean() - 90.0 < 0.02 * level + 0.1


def test_only_rain_falls():
    assert RainSpec.of(Weather.WET, light_at(LightPreset.CLOUDY, 0), 0.002) is None
    day, night = (RainSpec.of(Weather.RAIN, light_at(light, 0), 0.002) for light in ("cloudy", "night"))
    assert day.level > night.level > 0
    with pytest.raises(InputError, match="level"):
        RainSpec(300.0, 0.0)


def test_headlamps_light_what_is_ahead_and_not_what_another_hides():
    alone, queue = users(("saloon", 0, 0, 0)), users(("saloon", 0, 0, 0), ("lorry", 16, 0, 0))
    places = np.array([(8, 0, 0), (24, 0, 0), (-8, 0, 0), (8, 8, 0)], np.float32)
    free, hidden = (next(beams_of(state, Lamps.of(state, WARDROBE))).on_ground(places) for state in (alone, queue))
    assert free[0] > 0.2
    assert free[1] > 0.02
    assert free[2] == 0.0
    assert free[3] < 0.1 * free[0]
    assert hidden[0] == free[0]
    assert hidden[1] == 0.0
    assert [beam.row for beam in beams_of(queue, Lamps.of(queue, WARDROBE))] == [0, 1]


def test_clouds_and_fog_take_the_beam_and_give_part_of_it_back():
    sun = light_at(LightPreset.SUNNY, 0)
    assert diffused(sun, Weather.WET) is sun
    for weather in (Weather.RAIN, Weather.FOG):
        dull = diffused(sun, weather)
        assert not dull.beams
        level, bright = np.array(dull.sky) + dull.ambient, np.array(sun.sky) + sun.ambient
        assert (bright < level).all()
        assert (level < bright + sun.beams[0].rgb).all()


@pytest.mark.parametrize(("kind", "white", "red"), [("saloon", 2, 2), ("city_bus", 2, 2), ("motorcycle", 1, 1)])
def test_lamps_are_within_the_box_and_as_many_as_there_should_be(kind, white, red):
    state = users((kind, 5.0, -3.0, 70.0))
    lamps = Lamps.of(state, WARDROBE)
    assert (int((lamps.red == 0).sum()), int(lamps.red.sum())) == (white, red)
    turn = np.array(
        [(np.cos(np.radians(70)), -np.sin(np.radians(70))), (np.sin(np.radians(70)), np.cos(np.radians(70)))]
    )
    local = (lamps.positions_m[:, :2] - (5.0, -3.0)) @ turn
    assert (np.abs(local) <= state.sizes_m[0, :2] / 2 + 1e-9).all()
    assert ((local[:, 0] > 0) == (lamps.red == 0)).all()


def test_people_have_no_lamps():
    assert not len(Lamps.of(users(("adult", 0, 0, 0)), WARDROBE).rows)


@given(st.floats(-180, 180), st.sampled_from(["saloon", "adult", "city_bus", "bicycle"]))
def test_the_shade_at_the_foot_ends_where_it_says(heading_deg, kind):
    state = users((kind, 3.0, -2.0, heading_deg))
    corners = shade_corners(state, 0)
    assert contact_shade(corners, state).max() < 0.02
    middle = float(contact_shade(state.positions_m, state)[0])
    assert 0.1 < middle < 0.8
    twice = users((kind, 3.0, -2.0, heading_deg), (kind, 3.0, -2.0, heading_deg))
    twice = replace(twice, sizes_m=np.repeat(state.sizes_m, 2, axis=0))
    assert contact_shade(state.positions_m, twice)[0] == pytest.approx(1 - (1 - middle) ** 2, abs=1e-6)


def told(name, light):
    from dataclasses import replace

    return [(key, what) for key, what in faults(replace(load_scenario(name), light=light)) if key[0] == "light"]


@pytest.mark.parametrize("light", LightPreset)
def test_a_road_and_a_room_have_each_their_lights(light):
    assert bool(told("oval-one-vehicle", light)) == (light not in RAIL_LIGHTS)
    assert bool(told("crossroads-day", light)) == (light not in ROAD_LIGHTS)


def test_a_wrong_light_is_refused_with_those_that_there_are():
    ((_, what),) = told("crossroads-day", LightPreset.FLICKER)
    assert what == "'flicker' is no light of a road; choose from sunny, cloudy, dusk, night"
