"""The report: one page, everything on it, nothing from outside."""

import re
from dataclasses import replace

import pytest

from bench.report import write_report
from bench.scores import write_scores
from bench.scoring import score
from contracts import InputError
from tests.bench.filmless import filmless_run, record


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
