"""What docs/owners.md shows works as it stands there."""

import re
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from bench.cli import app
from georef.camera_file import read_camera, read_stored

PAGE = (Path(__file__).parents[2] / "docs" / "owners.md").read_text(encoding="utf-8")


def blocks(kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def gantry(*arguments):
    done = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert done.exception is None, done.exception


def test_its_picks_calibrate_its_camera(tmp_path):
    (tmp_path / "picks.csv").write_text(blocks("csv")[0])
    gantry("map", "crossroads-day", "--out", tmp_path / "map.geojson")
    options = ("--size", "1280x720", "--map", tmp_path / "map.geojson", "--out", tmp_path / "northeast.yaml")
    gantry("calibrate", "camera", tmp_path / "picks.csv", *options)
    stored = read_stored(tmp_path / "northeast.yaml")
    assert stored.name == "northeast"
    assert np.abs(stored.pose.position_m - [17.0, 17.0, 8.0]).max() < 0.3


def test_its_camera_file_is_read(tmp_path):
    (tmp_path / "southwest.yaml").write_text(blocks("yaml")[0])
    found = read_camera(tmp_path / "southwest.yaml")
    assert found.camera.pose.position_m.tolist() == [-17.0, -17.0, 8.0]


COMMANDS = re.findall(r"gantry ([a-z].*)", "\n".join(blocks("sh")).replace("\\\n", " "))


@pytest.mark.parametrize("line", COMMANDS)
def test_its_commands_have_the_options_it_names(line):
    words = line.split("#")[0].split()
    command = typer.main.get_command(app)
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known
