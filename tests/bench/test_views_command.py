"""``gantry views`` and ``gantry map``: layers for any map viewer."""

import json
from dataclasses import replace

import numpy as np
import pytest
import shapely
from typer.testing import CliRunner

from bench.cli import app
from contracts import InputError
from georef.camera_file import write_stored
from georef.camera_forms import StoredCamera
from georef.geo_reference import GeoReference
from georef.hd_map_file import read_map, write_map
from tests.perception.drawn_road import CROSSROADS, nominal_camera


def gantry(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def camera_file(path, geo, **changed):
    camera = replace(nominal_camera(), **changed)
    write_stored(path, StoredCamera(camera.name, camera.intrinsics, camera.pose, np.zeros((15, 15)), geo))
    return path


def test_views_and_blind_spots_are_a_layer_on_the_earth(tmp_path):
    write_map(tmp_path / "map.geojson", CROSSROADS)
    west = camera_file(tmp_path / "west.yaml", CROSSROADS.geo, name="west")
    out = tmp_path / "views.geojson"
    done = gantry("views", west, "--map", tmp_path / "map.geojson", "--farthest-m", 40, "--out", out)
    assert done.exception is None
    parts = {feature["id"]: feature for feature in json.loads(out.read_text())["features"]}
    assert set(parts) == {"west", "blind spots"}
    seen, unseen = (shapely.geometry.shape(parts[name]["geometry"]) for name in ("west", "blind spots"))
    assert seen.intersection(unseen).area < 1e-9 * seen.area
    before = CROSSROADS.geo.to_wgs84(np.array([[0.0, 0.0]]))[0, ::-1]  # 24 m before the camera
    assert seen.contains(shapely.Point(before))


def test_cameras_without_a_place_on_the_earth_or_with_two_are_refused(tmp_path):
    here = camera_file(tmp_path / "here.yaml", CROSSROADS.geo, name="here")
    nowhere = camera_file(tmp_path / "nowhere.yaml", None, name="nowhere")
    there = camera_file(tmp_path / "there.yaml", GeoReference(37.5, 127.0), name="there")
    out = tmp_path / "views.geojson"
    for files, message in (
        ((here, nowhere), "nowhere.yaml tells no geo_reference"),
        ((here, there), "there.yaml: its metres begin elsewhere"),
        ((here, here), "different names"),
        ((tmp_path / "absent.yaml",), "absent.yaml"),
    ):
        error = gantry("views", *files, "--out", out).exception
        assert isinstance(error, InputError)
        assert message in str(error)
        assert not out.exists()


def test_a_scenario_s_map_is_what_the_owners_have(tmp_path):
    out = tmp_path / "map.geojson"
    assert gantry("map", "avenue-day", "--out", out).exception is None
    assert len(read_map(out).centrelines) > 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("sequence-01", "--out", "map.geojson"), "sequence-01 is no scenario of the road"),
        (("avenue-day", "--out", "/absent/map.geojson"), "/absent/map.geojson: cannot be written"),
    ],
)
def test_what_has_no_map_and_where_none_can_be_written_is_said(arguments, message):
    error = gantry("map", *arguments).exception
    assert isinstance(error, InputError)
    assert message in str(error)
