"""The command line: exit statuses, one clear sentence for wrong input, and nothing half-written."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench.cli import app
from bench.jobs import run_scenario
from bench.recording_file import load_recording
from bench.wiring import Stages
from contracts import InputError
from scenarios.loader import load_scenario

ROOT = Path(__file__).parents[2]


def gantry(*arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "bench", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


def assert_refused(done: subprocess.CompletedProcess[str], *named: str) -> None:
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    for name in named:
        assert name in done.stderr


@pytest.fixture(scope="module")
def truth_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    directory = tmp_path_factory.mktemp("runs") / "truth"
    run_scenario(load_scenario("oval-one-vehicle"), Stages(oracles=("locate",)), directory, quiet=True)
    return directory


def test_the_library_is_listed():
    done = gantry("list")
    assert done.returncode == 0
    assert "oval-two-vehicles" in done.stdout


def test_a_run_at_the_level_of_truth_prints_scores_as_json_and_nothing_else(tmp_path):
    done = gantry("run", "oval-one-vehicle", "--oracle", "locate", "--json", "--out", tmp_path / "run")
    assert done.returncode == 0
    scores = {score["name"]: score for score in json.loads(done.stdout)}
    unseen = {"name": "ground.rms_x_m", "value": None, "unit": "m", "n": 0, "valid": False}
    assert scores["ground.rms_x_m"] == unseen  # nothing was filmed, so nothing was measured
    assert scores["contact.pairs"]["valid"]


def test_the_oracle_is_named_in_the_manifest(truth_run):
    assert load_recording(truth_run).manifest.oracles == ("locate",)


def test_a_recorded_run_scores_again_as_it_did(truth_run):
    before = (truth_run / "scores.json").read_bytes()
    assert gantry("score", truth_run).returncode == 0
    assert (truth_run / "scores.json").read_bytes() == before


def test_the_same_seed_gives_an_equal_run_and_another_seed_is_found_different(truth_run, tmp_path):
    scenario = load_scenario("oval-one-vehicle")
    stages = Stages(oracles=("locate",))
    run_scenario(scenario, stages, tmp_path / "same", quiet=True)
    assert gantry("diff", truth_run, tmp_path / "same").stdout == "equal\n"


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["run", "no-such-scenario"], ["no-such-scenario"]),
        (["run"], ["--video"]),
        (["run", "oval-one-vehicle", "--oracle", "weather"], ["weather", "calibrate"]),
        (["run", "oval-one-vehicle", "--locator", "magic"], ["magic", "plane0"]),
        (["run", "oval-one-vehicle", "--model", "missing.json"], ["missing.json"]),
        (["run", "oval-one-vehicle", "--detector", "no_such_module:Mine"], ["no_such_module"]),
        (["run", "oval-one-vehicle", "--detector", "hbp", "--perceiver", "kcf"], ["--perceiver kcf", "--detector hbp"]),
        (["run", "oval-one-vehicle", "--tracker", "m:Mine", "--perceiver", "kcf"], ["--perceiver kcf", "m:Mine"]),
        (["run", "oval-one-vehicle", "--oracle", "detect", "--tracker", "m:Mine"], ["detect stands for --tracker"]),
        (["run", "oval-one-vehicle", "--fps", "25"], ["leave --fps 25.0 away"]),
        (["run", "--video", "film.mp4", "--camera", "cam.yaml", "--seed", "0"], ["leave --seed 0 away"]),
        (["run", "oval-one-vehicle", "--seed", "-1"], ["--seed -1"]),
        (["run", "oval-one-vehicle", "--noise-seed", "-5"], ["--noise-seed -5"]),
        (["run", "oval-one-vehicle", "--oracle", "locate", "--out", "pyproject.toml"], ["pyproject.toml is a file"]),
        (
            ["run", "oval-one-vehicle", "--oracle", "locate", "--out", "README.md/x"],
            ["README.md/x", "cannot be written"],
        ),
        (["run", "oval-one-vehicle", "--oracle", "locate", "--out", "."], [". is no name for a run"]),
        (["run", "crossroads-day", "--oracle", "locate", "--calibrator", "frmes"], ["frmes", "picks, frames"]),
        (
            ["run", "crossroads-day", "--oracle", "detect", "--oracle", "calibrate", "--calibrator", "frames"],
            ["--calibrator frames beside --oracle calibrate"],
        ),
        (["tables", "rail", "crossroads-day"], ["crossroads-day is no scenario of the rail"]),
        (["score", "no/such/run"], ["no/such/run"]),
        (["report", "no/such/run"], ["no/such/run"]),
        (["diff", "no/such/run", "no/such/run"], ["no/such/run"]),
        (["plant", "no-such-plant", "--out", "x.svg"], ["no-such-plant"]),
        (["learn", "no/such/run", "--out", "x.json"], ["no/such/run"]),
    ],
)
def test_wrong_input_is_refused_in_one_sentence(arguments, named):
    assert_refused(gantry(*arguments), *named)


def test_a_directory_that_is_no_run_is_never_overwritten(tmp_path):
    precious = tmp_path / "thesis.txt"
    precious.write_text("years of work")
    with pytest.raises(InputError, match="is no run"):
        run_scenario(load_scenario("oval-one-vehicle"), Stages(oracles=("locate",)), tmp_path, quiet=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]
    assert precious.read_text() == "years of work"


def test_a_run_that_breaks_leaves_the_earlier_one_and_nothing_else(truth_run, monkeypatch):
    before = sorted(path.name for path in truth_run.parent.iterdir()), (truth_run / "run.mcap").read_bytes()

    def broken(*_: object) -> None:
        raise RuntimeError("the power failed")

    monkeypatch.setattr("bench.jobs.run", broken)
    with pytest.raises(RuntimeError):
        run_scenario(load_scenario("oval-one-vehicle"), Stages(oracles=("locate",)), truth_run, quiet=True)
    assert (sorted(path.name for path in truth_run.parent.iterdir()), (truth_run / "run.mcap").read_bytes()) == before


@pytest.mark.parametrize("told", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_stopped_says_so_in_one_line_and_leaves_nothing(tmp_path, told):
    endless = (
        "import signal, time, bench.jobs, bench.cli; "
        "signal.signal(signal.SIGINT, signal.default_int_handler); "  # whoever started the tests may have it ignored
        "bench.jobs.run = lambda *_: time.sleep(60); bench.cli.main()"
    )
    command = [sys.executable, "-c", endless, "run", "oval-one-vehicle", "--oracle", "locate", "--json"]
    with subprocess.Popen(
        [*command, "--out", str(tmp_path / "run")], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT
    ) as running:
        while not list(tmp_path.glob(".run-*/run.mcap.part")) and running.poll() is None:
            time.sleep(0.05)
        running.send_signal(told)
        out, said = running.communicate(timeout=30)
    assert (running.returncode, out, said) == (128 + told, "", "gantry: stopped before the end\n")
    assert not list(tmp_path.iterdir())


def test_whoever_may_read_a_directory_made_here_may_read_a_run(truth_run, tmp_path):
    usual = tmp_path / "usual"
    usual.mkdir()
    assert truth_run.stat().st_mode == usual.stat().st_mode


def test_every_command_is_documented_in_the_readme():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert not {name for name in commands if f"gantry {name}" not in readme}


def test_tables_of_unknown_sequences_or_of_no_frame_are_refused(tmp_path):
    assert_refused(gantry("tables", "rail", "no-such-scenario", "--out", tmp_path / "a"), "no-such-scenario")
    assert_refused(
        gantry("tables", "rail", "oval-two-vehicles", "--frames", "0", "--out", tmp_path / "b"), "--frames 0"
    )
    assert_refused(gantry("tables", "rail", "oval-two-vehicles", "--split", "test"), "--split test")
    assert not list(tmp_path.iterdir())
