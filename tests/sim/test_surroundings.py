"""What an author puts round the track, as numbers: shapes, shadows, lights that change, highlights, white balance."""

import math
from itertools import pairwise

import cv2
import numpy as np
import pytest
from film_cases import camera
from hypothesis import given
from hypothesis import strategies as st

from contracts import InputError
from scenarios.plant_file import load_plant
from sim.floor import FloorSpec, floor_texture
from sim.highlights import HighlightSpec, glare
from sim.light_program import LightChange, LightProgram, lights_at
from sim.lights import Beam, LightPreset, light_at
from sim.plant_scene import scene_of_plant
from sim.projection import project
from sim.rig import CameraSpec, RigSpec, true_cameras
from sim.sensor import Sensor, SensorSpec
from sim.surroundings import BridgeSpec, ObjectSpec, Surroundings, blocks_track

GREY = np.full((60, 80, 3), 120, np.uint8)
PLANT = load_plant("oval")
SHAPES = st.sampled_from(["box", "cylinder"])


def thing(**keys):
    return ObjectSpec(**{"at_m": (0.1, 0.2), "size_m": (0.2, 0.1, 0.08), "srgb": (20, 40, 160), **keys})


@given(SHAPES, st.floats(-180, 180), st.floats(0.02, 0.4), st.floats(0.02, 0.4))
def test_an_object_has_its_stated_size_place_and_heading(shape, heading_deg, length, width):
    solid = thing(shape=shape, heading_deg=heading_deg, size_m=(length, width, 0.05), bottom_m=0.1).solid
    turn = np.array([math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))])
    along, across = (solid.outline_m - (0.1, 0.2)) @ turn, (solid.outline_m - (0.1, 0.2)) @ (-turn[1], turn[0])
    assert np.abs([np.ptp(along) - length, np.ptp(across) - width]).max() < 1e-9
    assert np.abs(solid.centre_m - (0.1, 0.2)).max() < 1e-12
    assert (solid.bottom_m, round(solid.top_m, 12)) == (0.1, 0.15)
    assert cv2.contourArea(solid.outline_m.astype(np.float32), oriented=True) > 0  # counter-clockwise
    assert np.abs(solid.gap_m(solid.outline_m)).max() < 1e-9


@given(SHAPES, st.floats(0.4, 1.5), st.floats(-3.2, 3.2), st.floats(0.0, 0.2))
def test_the_shadow_of_a_solid_on_the_ground_is_its_hull_thrown_along_the_beam(shape, elevation, azimuth, bottom):
    solid = thing(shape=shape, at_m=(0.0, 0.0), bottom_m=bottom).solid
    beam = Beam(azimuth, elevation, (1.0, 1.0, 1.0))
    x, y = np.meshgrid(np.linspace(-0.8, 0.8, 60), np.linspace(-0.8, 0.8, 60))
    ground = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    dark = solid.shades(ground, beam)
    travel = -np.array([math.cos(azimuth), math.sin(azimuth)]) / math.tan(elevation)
    ends = [solid.outline_m + height * travel for height in (solid.bottom_m, solid.top_m)]
    hull = cv2.convexHull(np.concatenate(ends).astype(np.float32))
    gaps = np.array([cv2.pointPolygonTest(hull, point, True) for point in ground[:, :2].tolist()])
    clear = np.abs(gaps) > 2.5e-3  # a millimetre of the solid lets light through
    assert (dark[clear] == (gaps[clear] > 0)).all()
    above = np.column_stack([ground[:, :2], np.full(len(ground), solid.top_m)])
    assert not solid.shades(above, beam).any()


def test_a_bridge_leaves_its_stated_passage_free_and_its_walls_block_more():
    bridge = BridgeSpec((0.0, 0.0), 90.0, span_m=0.16, clear_m=0.10)
    track = np.column_stack([np.linspace(-0.3, 0.3, 61), np.zeros(61)])

    def blocked(half_width_m: float, height_m: float) -> bool:
        return any(blocks_track(p, track, half_width_m=half_width_m, height_m=height_m) for p in bridge.parts)

    assert not blocked(0.079, 0.099)
    assert blocked(0.081, 0.099)
    assert blocked(0.079, 0.101)
    sheet = thing(at_m=(0.0, 0.0), size_m=(0.3, 0.2, 0.001))
    assert not blocks_track(sheet, track, half_width_m=0.04, height_m=0.065)


def test_marks_and_clutter_keep_away_from_objects_and_nothing_else_changes():
    cameras = true_cameras(RigSpec((CameraSpec("eye", (640, 400), 500.0, (-1.0, 0.0, 2.8)),)), 4)
    mark = scene_of_plant(PLANT, cameras, 4).control_points_m[0]
    box = thing(at_m=tuple(mark[:2].tolist()))
    bare, full = (scene_of_plant(PLANT, cameras, 4, Surroundings(objects=things)) for things in ((), (box,)))
    assert mark.tolist() not in full.control_points_m.tolist()
    assert all(point in bare.control_points_m.tolist() for point in full.control_points_m.tolist())
    assert (box.solid.gap_m(full.clutter_m[:, :2]) > 0).all()
    assert all((a == b).all() for a, b in zip(bare.centrelines_m, full.centrelines_m, strict=True))


@given(st.integers(0, 20_000_000_000))
def test_lights_mix_with_weights_that_sum_to_one_and_come_up_evenly(time_ns):
    changes = (LightChange(3.0, LightPreset.CLOUDY, 2.0), LightChange(8.0, LightPreset.LAMPS))
    lights = LightProgram(LightPreset.SUNNY, changes).at(time_ns)
    assert abs(sum(weight for weight, _ in lights) - 1.0) < 1e-12
    time_s = time_ns * 1e-9
    clouds = min(1.0, max(0.0, (time_s - 3.0) / 2.0)) if time_s < 8.0 else 0.0
    found = sum(weight for weight, light in lights if light == light_at(LightPreset.CLOUDY, time_ns))
    assert abs(found - clouds) < 1e-12
    alone = lights_at(LightPreset.FLICKER, time_ns)
    assert alone == ((1.0, light_at(LightPreset.FLICKER, time_ns)),)


@given(st.floats(-180, 180), st.floats(84, 90), st.floats(0.8, 2.0))
def test_a_highlight_is_brightest_where_opencv_projects_the_mirrored_lamp(azimuth_deg, elevation_deg, width_deg):
    view = camera(width_px=320, height_px=240, focal_px=320.0)
    highlight = HighlightSpec(azimuth_deg, elevation_deg, width_deg, 0.8)
    reach = view.pose.position_m[2] / math.tan(math.radians(elevation_deg))
    ground = view.pose.position_m[:2] + reach * np.array(
        [math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg))]
    )
    (u, v), _ = project(view, np.array([*ground, 0.0]))
    shine = glare(view, [highlight])
    assert shine is not None
    rows, columns = np.nonzero(shine[..., 0] == shine.max())
    assert max(abs(columns.mean() - u), abs(rows.mean() - v)) < 1.0
    assert abs(int(shine.max()) - 0.8 * 255) < 0.5 + 0.8 * 255 * 0.02  # the middle may lie between pixels
    assert glare(view, []) is None


@given(st.floats(0.01, 0.3), st.floats(2.0, 30.0), st.integers(0, 1000))
def test_the_white_balance_drifts_smoothly_as_far_as_stated(drift, period_s, seed):
    spec = SensorSpec(noise=0.0, defocus_px=0.0, white_balance_drift=drift, white_balance_period_s=period_s)
    sensor = Sensor(spec, "west", 80, 60, noise_seed=seed)
    times_ns = np.linspace(0, 1.2 * period_s * 1e9, 400).astype(int)
    gains = np.array([sensor.channel_gains(int(t)) for t in times_ns]) - 1.0
    assert np.abs(gains).max() <= drift + 1e-12
    assert (np.abs(gains).max(axis=0) > 0.99 * drift).all()
    assert max(np.abs(b - a).max() for a, b in pairwise(gains)) < drift * 0.03
    image = sensor.balance(GREY, int(times_ns[7]))
    assert np.abs(image[0, 0] - 120.0 * (1.0 + gains[7])).max() <= 0.5 + 1e-4
    assert (GREY == 120).all()
    assert sensor.balance(GREY, int(times_ns[7])).tobytes() == image.tobytes()


def test_no_contrast_makes_a_plain_floor_and_contrast_scales_what_differs():
    plain, once, twice = (floor_texture(3, FloorSpec((150, 140, 130), contrast)) for contrast in (0.0, 1.0, 2.0))
    assert (plain == (150, 140, 130)).all()
    far = [floor.astype(float).reshape(-1, 3).std(axis=0) for floor in (once, twice)]
    assert np.abs(far[1] / far[0] - 2.0).max() < 0.02


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: thing(size_m=(0.1, 0.0, 0.1)), "size_m"),
        (lambda: thing(srgb=(0, 0, 256)), "srgb"),
        (lambda: thing(at_m=(math.nan, 0.0)), "at_m"),
        (lambda: thing(bottom_m=-0.1), "bottom_m"),
        (lambda: thing(heading_deg=math.inf), "heading_deg"),
        (lambda: BridgeSpec((0.0, 0.0), 0.0, span_m=0.0), "span_m"),
        (lambda: BridgeSpec((0.0, 0.0), math.nan), "heading_deg"),
        (lambda: BridgeSpec((0.0, math.inf), 0.0), "at_m"),
        (lambda: FloorSpec(contrast=-1.0), "contrast"),
        (lambda: FloorSpec(srgb=(300, 0, 0)), "srgb"),
        (lambda: HighlightSpec(0.0, 0.0), "elevation_deg"),
        (lambda: HighlightSpec(math.nan, 80.0), "azimuth_deg"),
        (lambda: HighlightSpec(0.0, 80.0, width_deg=0.0), "width_deg"),
        (lambda: HighlightSpec(0.0, 80.0, strength=1.5), "strength"),
        (lambda: SensorSpec(white_balance_drift=1.0), "white_balance_drift"),
        (lambda: SensorSpec(white_balance_period_s=0.0), "white_balance_period_s"),
        (lambda: LightChange(-1.0, LightPreset.DUSK), "at_s"),
        (lambda: LightChange(1.0, LightPreset.DUSK, math.inf), "over_s"),
        (
            lambda: LightProgram(
                LightPreset.SUNNY, (LightChange(3.0, LightPreset.DUSK, 2.0), LightChange(4.0, LightPreset.LAMPS))
            ),
            "4.0 s",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_name(make, words):
    with pytest.raises(InputError, match=words):
        make()
