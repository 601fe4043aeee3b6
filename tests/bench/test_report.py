"""The report: one page, everything on it, nothing from outside."""

import re
from dataclasses import replace

import numpy as np
import pytest
import shapely

from bench.report import write_report
from bench.report.plan import outline_on_floor
from bench.scores import write_scores
from bench.scoring import score
from contracts import InputError, Pose
from tests.bench.filmless import filmless_run, overhead_camera, record
from tests.perception.drawn_road import nominal_camera


@pytest.fixture
def run_directory(tmp_path):
    return written(tmp_path / "run", filmless_run())


def written(directory, run):
    record(directory, run)
    write_scores(directory / "scores.json", score(run[0]))
    return directory


def page_of(*directories):
    path = directories[0] / "report.html"
    write_report(directories, path)
    return path.read_text(encoding="utf-8")


def test_every_score_is_on_the_page(run_directory):
    page = page_of(run_directory)
    assert not [name for name in (one.name for one in score(filmless_run()[0])) if name not in page]


def test_the_page_asks_nothing_of_the_network(run_directory):
    tags = re.findall(r"<(?:script|link|img|iframe|source|image)\b[^>]*>", page_of(run_directory))
    addresses = [address for tag in tags for address in re.findall(r"""(?:src|href)\s*=\s*["']([^"']*)""", tag)]
    assert addresses
    assert not [address for address in addresses if not address.startswith("data:")]


def test_oracles_are_named_loudly(tmp_path):
    recording, frames = filmless_run()
    cheated = replace(recording, manifest=replace(recording.manifest, oracles=("calibrate",)))
    assert "calibrate" in page_of(written(tmp_path / "run", (cheated, frames)))


@pytest.mark.parametrize(("scenario", "judged"), [("oval-two-vehicles", True), ("crossroads-day", False)])
def test_expectations_are_judged_only_where_the_scenario_has_any(tmp_path, scenario, judged):
    recording, frames = filmless_run()
    named = replace(recording, manifest=replace(recording.manifest, scenario=scenario))
    assert ('class="verdict' in page_of(written(tmp_path / "run", (named, frames)))) is judged


def test_views_are_drawn_as_they_are_but_not_to_the_horizon():
    above = outline_on_floor(overhead_camera(distortion=np.zeros(5)))
    assert abs(shapely.Polygon(above[:-1]).area - 320 * 180 * (2.8 / 500) ** 2) < 1e-3
    slanted = nominal_camera()
    height_m = slanted.pose.position_m[2]
    away_m = np.linalg.norm(outline_on_floor(slanted)[:-1] - slanted.pose.position_m[:2], axis=1)
    assert height_m < away_m.max() < 8.001 * height_m
    up = replace(slanted, pose=Pose(np.eye(3), np.array([0.0, 0.0, 8.0])))
    assert outline_on_floor(up).shape == (0, 2)


@pytest.mark.parametrize(
    ("off_m", "said"), [(0.001, "to the estimate, 10 times enlarged."), (0.02, "to the estimate.")]
)
def test_errors_are_said_to_be_enlarged_where_they_are(tmp_path, off_m, said):
    recording, frames = filmless_run(steps=12)
    moved = [
        replace(step.fused, positions_m=step.fused.positions_m + np.array([off_m, 0.0])) for step in recording.steps
    ]
    steps = tuple(replace(step, fused=fused) for step, fused in zip(recording.steps, moved, strict=True))
    assert said in page_of(written(tmp_path / "run", (replace(recording, steps=steps), frames)))


def test_a_title_cannot_smuggle_markup_into_the_page(tmp_path):
    recording, frames = filmless_run()
    sly = replace(recording, manifest=replace(recording.manifest, title="<script>alert(1)</script>"))
    assert "<script>alert(1)" not in page_of(written(tmp_path / "run", (sly, frames)))


def test_several_runs_are_compared_on_one_page(run_directory, tmp_path):
    recording, frames = filmless_run()
    other = replace(recording, manifest=replace(recording.manifest, title="A second run"))
    page = page_of(run_directory, written(tmp_path / "other", (other, frames)))
    assert "A second run" in page
    assert recording.manifest.title in page


def test_footage_without_truth_makes_a_page_that_says_so(tmp_path):
    recording, frames = filmless_run()
    blind = replace(recording, steps=tuple(replace(step, truth=None) for step in recording.steps))
    assert "no truth" in page_of(written(tmp_path / "run", (blind, frames)))


def test_a_broken_run_leaves_no_page(tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "run.mcap").write_bytes(b"not a recording")
    with pytest.raises(InputError, match=r"run\.mcap"):
        write_report([tmp_path / "run"], tmp_path / "report.html")
    assert not (tmp_path / "report.html").exists()


def test_no_run_at_all_is_refused(tmp_path):
    with pytest.raises(InputError, match="at least one"):
        write_report([], tmp_path / "report.html")
