"""Expectations are held, and what is not kept is said in a sentence; the terminal shows both."""

import io
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from rich.console import Console
from scoring_cases import edit_ground, edit_truth, perfect_recording, shifted

from bench.expectations import check
from bench.recording import Recording
from bench.report.terminal import print_outcome
from bench.scores import Score
from bench.scoring import score
from contracts import Event, EventKind
from scenarios.schema import Bound, Expect


def touching(recording, *pairs, derailed=()):
    events = [Event(0, EventKind.CONTACT, pair) for pair in pairs]
    events += [Event(0, EventKind.DERAIL, (name,)) for name in derailed]
    return edit_truth(recording, lambda truth: replace(truth, events=tuple(events) if truth.index == 1 else ()))


def failures(expect, recording):
    return check(expect, score(recording), recording)


def test_a_run_that_keeps_everything_has_no_failures():
    recording = touching(perfect_recording(), ("blue", "red"), derailed=["red"])
    expect = Expect(
        contact=(("red", "blue"),),
        derail=("red",),
        scores={"detection.recall": Bound(min=1.0), "ground.max_m": Bound(min=0.0, max=0.001)},
    )
    assert failures(expect, recording) == []


@pytest.mark.parametrize(
    ("expect", "sentence"),
    [
        (Expect(contact=(("blue", "red"), ("blue", "green"))), "blue and green were expected to touch and did not"),
        (Expect(), "blue and red touched, which was not expected"),
        (Expect(contact=(("blue", "red"),), derail=("blue",)), "blue was expected to derail and did not"),
    ],
)
def test_contacts_and_derailments_must_be_exactly_those_expected(expect, sentence):
    assert failures(expect, touching(perfect_recording(), ("blue", "red"))) == [sentence]


def test_an_unexpected_derailment_is_said():
    assert failures(Expect(), touching(perfect_recording(), derailed=["red"])) == [
        "red derailed, which was not expected"
    ]


def test_a_broken_limit_names_score_value_and_limit():
    recording = edit_ground(perfect_recording(), lambda ground: shifted(ground, [0.005, 0.0]))
    (sentence,) = failures(Expect(scores={"ground.rms_x_m": Bound(max=0.003)}), recording)
    assert sentence == "ground.rms_x_m is 0.005 m, expected at most 0.003 (n = 15)"


def test_a_score_that_does_not_exist_or_has_no_value_fails():
    recording = edit_ground(perfect_recording(), lambda ground: shifted(ground, [1.0, 5.0]))
    expect = Expect(scores={"ground.rms_z_m": Bound(max=1.0), "ground.rms_x_m": Bound(max=1.0)})
    unknown, empty = failures(expect, recording)
    assert "there is no such score" in unknown
    assert "has no value" in empty


def test_limits_of_scores_are_not_held_where_nothing_was_filmed():
    blind = edit_truth(perfect_recording(), lambda truth: replace(truth, cameras=()))
    expect = Expect(contact=(("blue", "red"),), scores={"detection.recall": Bound(min=1.0)})
    assert failures(expect, blind) == ["blue and red were expected to touch and did not"]


@dataclass(frozen=True)
class Finished:
    directory: Path
    recording: Recording
    scores: tuple[Score, ...]
    failures: tuple[str, ...]


def test_the_terminal_shows_figures_oracles_and_what_was_not_met():
    recording = edit_ground(perfect_recording(), lambda ground: shifted(ground, [0.005, 0.0]))
    recording = Recording(replace(recording.manifest, oracles=("detect",)), recording.steps)
    console = Console(file=io.StringIO(), width=120, record=True)
    print_outcome(Finished(Path("runs/x"), recording, score(recording), ("ground [x] is bad",)), console)
    text = console.export_text()
    for part in ("The truth itself", "'detect' was given the truth", "5.00 mm, 0.00 mm", "ground [x] is bad", "runs/x"):
        assert part in text


def test_the_terminal_shows_a_dash_for_what_is_not_known():
    recording = perfect_recording()
    footage = Recording(recording.manifest, tuple(replace(step, truth=None) for step in recording.steps))
    console = Console(file=io.StringIO(), width=120, record=True)
    print_outcome(Finished(Path("runs/x"), footage, score(footage), ()), console)
    assert "—" in console.export_text()
