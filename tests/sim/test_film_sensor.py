"""Lens, sensor, lights and rigs as numbers, without graphics."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from film_cases import camera
from hypothesis import given
from hypothesis import strategies as st

import scenarios
from contracts import InputError, Intrinsics
from scenarios.toml_file import read_toml
from sim.lens import Lens
from sim.lights import LightPreset, ShadowBand, light_at
from sim.rig import CameraSpec, Departure, RigSpec, look_down, nominal_cameras, true_cameras
from sim.sensor import Sensor, SensorSpec

RIGS = Path(scenarios.__file__).parent / "rigs"
GREY = np.full((60, 80, 3), 120, np.uint8)


def rig(*cameras: CameraSpec) -> RigSpec:
    return RigSpec(cameras or (CameraSpec("west", (640, 480), 600.0, (0.0, 0.0, 2.8)),))


def test_a_lens_without_distortion_changes_nothing():
    lens = Lens.of(camera().intrinsics)
    assert np.shares_memory(lens.bend(GREY), GREY)
    assert (lens.bend_mask(GREY[..., 0]) == 120).all()


@given(st.floats(-0.2, 0.05), st.floats(-0.03, 0.03), st.floats(-0.002, 0.002))
def test_the_oversized_pinhole_shows_every_bent_pixel_where_opencv_undistorts_it(k1, k2, p1):
    bent = Intrinsics(160, 120, 150.0, 150.0, 77.3, 62.1, np.array([k1, k2, p1, -p1, 0.0]))
    lens = Lens.of(bent)
    ramp_u, ramp_v = np.meshgrid(np.arange(lens.pinhole.width_px), np.arange(lens.pinhole.height_px))
    ramp = np.stack([ramp_u % 256, ramp_v % 256, np.zeros_like(ramp_u)], axis=-1).astype(np.uint8)
    seen = lens.bend(ramp)[::7, ::7, :2].reshape(-1, 2).astype(float)
    u, v = np.meshgrid(np.arange(0, 160, 7), np.arange(0, 120, 7))
    pixels = np.stack([u, v], axis=-1).reshape(-1, 1, 2).astype(float)
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-12)
    expected = cv2.undistortPoints(
        pixels, bent.matrix, bent.distortion, None, np.eye(3), lens.pinhole.matrix, criteria
    ).reshape(-1, 2)
    assert np.abs(seen - expected).max() <= 0.5 + 1 / 32  # levels are whole numbers, maps 1/32 px


def test_noise_has_the_stated_strength_and_no_bias():
    sensor = Sensor(SensorSpec(noise=2.0, defocus_px=0.0), "west", 80, 60, noise_seed=4)
    noise = np.stack([sensor.expose(GREY, index) for index in range(20)]).astype(float) - 120
    assert abs(noise.mean()) < 0.05
    assert abs(noise.std() - math.sqrt(4.0 + 1 / 12)) < 0.05  # rounding adds a twelfth


def test_noise_depends_on_seed_camera_and_index_alone():
    def exposed(index: int, *, name: str = "west", seed: int = 4, before: int = 0) -> bytes:
        sensor = Sensor(SensorSpec(), name, 80, 60, noise_seed=seed)
        for k in range(before):
            sensor.expose(GREY, k)
        return sensor.expose(GREY, index).tobytes()

    assert exposed(3) == exposed(3, before=2)
    assert len({exposed(3), exposed(4), exposed(3, name="east"), exposed(3, seed=5)}) == 4


def test_the_sensor_leaves_its_input_alone_and_scales_by_the_gain():
    before = GREY.copy()
    image = Sensor(SensorSpec(noise=0.0, defocus_px=1.0, gain=1.5), "west", 80, 60, noise_seed=0).expose(GREY, 0)
    assert (before == GREY).all()
    assert (image == 180).all()


@given(st.floats(0.0, 89.0), st.floats(-360.0, 360.0))
def test_a_camera_that_looks_down_has_a_rotation_with_its_axis_down_and_its_top_ahead(tilt_deg, azimuth_deg):
    turn = look_down(tilt_deg, azimuth_deg)
    assert np.abs(turn @ turn.T - np.eye(3)).max() < 1e-12
    assert abs(np.linalg.det(turn) - 1.0) < 1e-12
    assert abs(-turn[2, 2] - math.cos(math.radians(tilt_deg))) < 1e-12
    ahead = np.array([math.cos(math.radians(azimuth_deg)), math.sin(math.radians(azimuth_deg)), 0.0])
    assert -turn[:, 1] @ ahead >= math.cos(math.radians(tilt_deg)) - 1e-12  # image up points ahead


def test_north_is_up_and_east_is_right_in_a_nominal_camera():
    turn = nominal_cameras(rig())[0].pose.world_from_camera
    assert np.abs(turn - np.diag([1.0, -1.0, -1.0])).max() < 1e-12


@given(st.integers(0, 10_000))
def test_true_cameras_depart_no_farther_than_the_rig_allows(seed):
    spec = rig()
    nominal, true = nominal_cameras(spec)[0], true_cameras(spec, seed)[0]
    angle = cv2.Rodrigues(true.pose.world_from_camera @ nominal.pose.world_from_camera.T)[0]
    assert np.linalg.norm(angle) <= math.radians(3.0) + 1e-9
    assert np.linalg.norm(true.pose.position_m - nominal.pose.position_m) <= 0.10 + 1e-12
    assert abs(true.intrinsics.fx_px / nominal.intrinsics.fx_px - 1.0) <= 0.005


def test_one_cameras_departure_does_not_depend_on_the_others():
    west = CameraSpec("west", (640, 480), 600.0, (0.0, 0.0, 2.8))
    east = CameraSpec("east", (640, 480), 600.0, (2.0, 0.0, 2.8))
    alone, together = true_cameras(rig(east), 7)[0], true_cameras(rig(west, east), 7)[1]
    assert (alone.pose.position_m == together.pose.position_m).all()


@pytest.mark.parametrize("name", ["two_overhead", "six_overhead", "atlas_two"])
def test_every_rig_file_reads(name):
    spec = read_toml(RIGS / f"{name}.toml", RigSpec)
    assert len(spec.cameras) == (6 if name == "six_overhead" else 2)


@pytest.mark.parametrize(
    "make",
    [
        lambda: CameraSpec("west", (640, 480), 600.0, (0.0, 0.0, -1.0)),
        lambda: CameraSpec("west", (640, 480), -600.0, (0.0, 0.0, 2.8)),
        lambda: CameraSpec("west", (640, 480), 600.0, (0.0, math.nan, 2.8)),
        lambda: CameraSpec("west", (640, 480), 600.0, (0.0, 0.0, 2.8), tilt_deg=120.0),
        lambda: RigSpec(()),
        lambda: rig(*[CameraSpec("west", (640, 480), 600.0, (0.0, 0.0, 2.8))] * 2),
        lambda: SensorSpec(noise=-1.0),
        lambda: Departure(position_m=math.nan),
    ],
)
def test_impossible_rigs_are_refused(make):
    with pytest.raises(InputError):
        make()


@given(st.sampled_from(list(LightPreset)), st.integers(0, 10**11))
def test_no_light_overexposes_a_white_surface_that_lies_flat(preset, time_ns):
    light = light_at(preset, time_ns)
    total = np.array(light.sky) + light.ambient
    for beam in light.beams:
        total += np.array(beam.rgb) * math.sin(beam.elevation_rad)
    assert (total < 1.05).all()
    assert light == light_at(preset, time_ns)


def test_a_shadow_band_is_dark_inside_and_soft_at_its_edge():
    band = ShadowBand(0.0, 1.0, 0.5, 0.2, 0.8)
    shade = band.shade(np.array([[1.0, 9.0], [1.5, 0.0], [1.65, 0.0], [0.5, 3.0]]))
    assert np.abs(shade - [0.8, 0.4, 0.0, 0.4]).max() < 1e-12
