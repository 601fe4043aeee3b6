"""``gantry calibrate about``: what an owner knows of a camera, as a file to set out from."""

import numpy as np
import pytest
from typer.testing import CliRunner

from bench.cli import app
from contracts import InputError
from georef.camera_file import read_stored, write_stored
from georef.camera_forms import StoredCamera
from georef.hd_map_file import write_map
from georef.projection import project
from tests.perception.drawn_road import CROSSROADS, nominal_camera

USUAL = {"at_m": "-17,-17", "height_m": 8, "heading_deg": 45, "down_deg": 24, "size": "1280x720", "focal_px": 850}


@pytest.fixture
def files(tmp_path):
    write_map(tmp_path / "map.geojson", CROSSROADS)
    return tmp_path


def about(files, **options):
    told = {"map": files / "map.geojson", "out": files / "about.yaml", **options}
    parts = [part for name, value in told.items() for part in (f"--{name.replace('_', '-')}", str(value))]
    return CliRunner().invoke(app, ["calibrate", "about", *parts])


def test_it_stands_and_looks_as_said(files):
    assert about(files, **USUAL, name="southwest").exception is None
    stored = read_stored(files / "about.yaml")
    assert (stored.name, stored.geo) == ("southwest", CROSSROADS.geo)
    away_m = 8.0 / np.tan(np.radians(24.0))
    ahead = [-17.0 + away_m * np.sqrt(0.5), -17.0 + away_m * np.sqrt(0.5), 0.0]
    pixels, valid = project(stored.calibrated.camera, np.array([ahead, [*ahead[:2], 1.0], [ahead[0] + 1, *ahead[1:]]]))
    assert valid.all()
    assert np.abs(pixels[0] - [639.5, 359.5]).max() < 1e-9
    assert pixels[1, 1] < 359.5  # what stands higher is higher in the image
    assert pixels[2, 0] > 639.5  # and what lies farther east is on the right of who looks north-east
    assert (np.diag(stored.covariance)[[0, 2, 4, 9, 12]] > 0).all()


def test_a_place_on_the_earth_and_the_lens_of_a_board_serve_as_well(files):
    lens = nominal_camera().intrinsics
    write_stored(files / "lens.yaml", StoredCamera("pole", lens, None, np.diag(np.arange(15.0))))
    latitude, longitude = CROSSROADS.geo.to_wgs84([-17.0, -17.0]).tolist()
    place = {"at_deg": f"{latitude!r},{longitude!r}", "height_m": 8, "heading_deg": 45, "down_deg": 24}
    assert about(files, **place, lens=files / "lens.yaml").exception is None
    stored = read_stored(files / "about.yaml")
    assert stored.name == "about"
    assert np.abs(stored.calibrated.camera.pose.position_m - [-17.0, -17.0, 8.0]).max() < 1e-6
    assert np.diag(stored.covariance)[:9].tolist() == list(range(9))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"at_m": "here"}, '--at-m "here" is not two numbers'),
        ({"at_deg": "37.4,127.1"}, "either as --at-m or as --at-deg"),
        ({"height_m": 0}, "--height-m 0 must be positive"),
        ({"heading_deg": "nan"}, "--heading-deg nan must be finite"),
        ({"down_deg": 100}, "--down-deg 100 must lie within"),
        ({"lens": "lens.yaml"}, "give either --lens, or --focal-px together with --size"),
        ({"focal_px": -1}, "must be finite with positive focal lengths"),
        ({"map": "absent.geojson"}, "absent.geojson"),
        ({"out": "/absent/about.yaml"}, "/absent/about.yaml: cannot be written"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(files, changed, message):
    error = about(files, **{**USUAL, **changed}).exception
    assert isinstance(error, InputError)
    assert message in str(error)
    assert not (files / "about.yaml").exists()
