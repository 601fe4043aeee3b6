"""``gantry calibrate frames``: an owner's pictures of a road, its map and about where the camera hangs."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli import app
from contracts import CalibrationError, Camera, InputError
from georef.camera_file import read_stored, write_stored
from georef.camera_forms import CameraForm, StoredCamera
from georef.hd_map_file import write_map
from tests.perception.drawn_road import CROSSROADS, nominal_camera, picture, true_camera


def write_nominal(path, camera: Camera):
    write_stored(path, StoredCamera(camera.name, camera.intrinsics, camera.pose, np.zeros((15, 15))), CameraForm.GANTRY)
    return path


@pytest.fixture
def files(tmp_path):
    """A grey picture, the map and the file of the nominal camera."""
    write_map(tmp_path / "map.geojson", CROSSROADS)
    cv2.imwrite(str(tmp_path / "grey.png"), np.full((720, 1280, 3), 90, np.uint8))
    write_nominal(tmp_path / "near.yaml", nominal_camera())
    return tmp_path


def gantry(files, *images, **changed):
    options = {"map": files / "map.geojson", "near": files / "near.yaml", "out": files / "cam.yaml", **changed}
    told = [part for name, value in options.items() for part in (f"--{name.replace('_', '-')}", str(value))]
    return CliRunner().invoke(app, ["calibrate", "frames", *(str(files / name) for name in images), *told, "--json"])


def test_a_camera_is_found_from_its_picture_and_the_map(files):
    true = true_camera(nominal_camera())
    cv2.imwrite(str(files / "day.png"), picture(true, CROSSROADS))
    done = gantry(files, "day.png", map_sigma_m=0.01)
    assert done.exception is None
    found = json.loads(done.stdout)["parameters"]
    for name, value in (("f_px", 852.5), ("x_m", true.pose.position_m[0]), ("z_m", true.pose.position_m[2])):
        assert abs(found[name]["value"] - value) < 5 * found[name]["sigma"]
    stored = read_stored(files / "cam.yaml")
    assert (stored.name, stored.geo) == ("cam", CROSSROADS.geo)
    assert np.trace(stored.covariance) > 0


@pytest.mark.parametrize(
    ("images", "changed", "message"),
    [
        (("absent.png",), {}, "absent.png is no image that can be read"),
        (("grey.png",), {"map": "absent.geojson"}, "cannot read the map absent.geojson"),
        (("grey.png",), {"near": "absent.yaml"}, "absent.yaml"),
        (("grey.png",), {"map_sigma_m": -1}, "--map-sigma-m -1.0 must not be negative"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_written(files, images, changed, message):
    done = gantry(files, *images, **changed)
    assert isinstance(done.exception, InputError)
    assert message in str(done.exception)
    assert not (files / "cam.yaml").exists()


def test_images_of_another_size_are_refused(files):
    other = replace(nominal_camera().intrinsics, width_px=640, height_px=360)
    write_nominal(files / "near.yaml", replace(nominal_camera(), intrinsics=other))
    done = gantry(files, "grey.png")
    assert isinstance(done.exception, InputError)
    assert "grey.png is 1280x720, but the camera in" in str(done.exception)


def test_a_picture_without_paint_is_refused(files):
    done = gantry(files, "grey.png")
    assert isinstance(done.exception, CalibrationError)
    assert not (files / "cam.yaml").exists()
