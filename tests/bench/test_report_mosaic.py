"""The mosaic of the report: dots lie where the positions say, directions and switches as paper R tells them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from bench.report.material import read_run
from bench.report.mosaic import grid_of, mosaics_html, placed_vehicles, switch_side
from bench.report.page import page
from contracts import Compass, SwitchState
from georef.calibrated import CalibratedCamera
from scenarios.plant_file import load_plant
from tests.bench.filmless import filmless_run, overhead_camera, record

CAMERAS = (overhead_camera(), overhead_camera("east", 0.4))
COMPASS = [Compass.NORTH, Compass.SOUTH, Compass.WEST, Compass.EAST]
SQUARE = np.zeros((15, 15))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    recording, frames = filmless_run(steps=12)
    calibrated = tuple(CalibratedCamera(camera, SQUARE) for camera in CAMERAS)
    recording = replace(recording, manifest=replace(recording.manifest, calibrated_cameras=calibrated))
    return read_run(record(tmp_path_factory.mktemp("mosaic"), (recording, frames)))


def test_every_dot_lies_at_its_fused_position(run):
    grid = grid_of(CAMERAS)
    html = mosaics_html(run)
    dots = re.findall(r'<circle class="vehicle" cx="([-\d.]+)" cy="([-\d.]+)"', html)
    chosen = [run.recording.steps[k].fused.positions_m for k in (0, 11)]
    expected = grid.pixels(np.concatenate(chosen))
    assert np.abs(np.array(dots, float) - expected).max() < 0.051


def test_the_page_shows_the_mosaic(run):
    assert "The mosaic" in page([run])


def test_without_calibrated_cameras_there_is_no_mosaic(run):
    manifest = replace(run.recording.manifest, calibrated_cameras=())
    assert mosaics_html(replace(run, recording=replace(run.recording, manifest=manifest))) == ""
    assert grid_of(()) is None


def test_a_direction_is_what_the_analyst_said(run):
    steps = run.recording.steps
    assert [vehicle.direction for vehicle in placed_vehicles(steps[11])] == [Compass.EAST, Compass.EAST]
    assert [(vehicle.direction, vehicle.state) for vehicle in placed_vehicles(steps[0])] == [(None, "unknown")] * 2


def test_what_has_no_place_is_not_drawn(run):
    step = run.recording.steps[3]
    lost = replace(step, fused=replace(step.fused, valid=[True, False]))
    assert [vehicle.label for vehicle in placed_vehicles(lost)] == ["red"]


def test_switches_are_told_as_in_table_2():
    for switch in load_plant("oval").switches.values():
        other = {SwitchState.STRAIGHT: SwitchState.DIVERGING, SwitchState.DIVERGING: SwitchState.STRAIGHT}
        shown, hidden = switch.spot_state, other[switch.spot_state]
        assert [switch_side(switch, hidden, Compass(name)) for name in ("north", "south", "west", "east")] == list(
            "RLRL"
        )
        assert [switch_side(switch, shown, Compass(name)) for name in ("north", "south", "west", "east")] == list(
            "LRLR"
        )
        assert switch_side(switch, SwitchState.UNKNOWN, Compass.NORTH) == "—"
        assert switch_side(switch, shown, None) == "—"
