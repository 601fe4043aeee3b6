from dataclasses import replace

import pytest
from hypothesis import assume, given, settings

from bench.diff import STAGES, Difference, first_difference
from bench.ledger import image_hash, ledger_of, state_hash
from contracts import Frame
from contracts.truth import Step
from tests.bench import strategies


def with_step(recording, place, step):
    return replace(recording, steps=(*recording.steps[:place], step, *recording.steps[place + 1 :]))


def injured(step, stage):
    """``step`` with ``stage`` changed, and all later ones, as it would be in life."""
    later = STAGES[STAGES.index(stage) :]
    ledger = step.ledger
    if "state" in later and step.truth:
        step = replace(step, truth=replace(step.truth, time_ns=-1))
    if "image" in later:
        ledger = (replace(ledger[0], image="0" * 32), *ledger[1:])
    if "tracks" in later:
        objects = replace(step.tracks[0].objects, time_ns=-1)
        step = replace(step, tracks=(replace(step.tracks[0], objects=objects), *step.tracks[1:]))
    views = (replace(step.views[0], time_ns=-1), *step.views[1:])
    return replace(step, ledger=ledger, views=views)


@settings(max_examples=10, deadline=None)
@given(strategies.recordings())
def test_equal_runs_have_no_difference(recording):
    assert first_difference(recording, recording) is None


@pytest.mark.parametrize("stage", ["state", "image", "tracks", "ground"])
@settings(max_examples=5, deadline=None)
@given(strategies.recordings(min_steps=2, min_cameras=1))
def test_the_first_frame_and_its_earliest_stage_are_named(stage, recording):
    assume(stage != "state" or recording.steps[1].truth)
    changed = recording
    for place in range(1, len(recording.steps)):
        changed = with_step(changed, place, injured(recording.steps[place], stage))
    camera = "" if stage == "state" else recording.steps[1].tracks[0].objects.camera
    assert first_difference(recording, changed) == Difference(1, stage, camera, ())


@settings(max_examples=5, deadline=None)
@given(strategies.recordings(min_steps=1))
def test_a_shorter_run_differs_where_it_ends(recording):
    shorter = replace(recording, steps=recording.steps[:-1])
    last = recording.steps[-1].index
    assert first_difference(recording, shorter) == Difference(last, "length", "", ())
    assert first_difference(shorter, recording) == Difference(last, "length", "", ())


@settings(max_examples=10, deadline=None)
@given(strategies.recordings())
def test_manifests_are_compared_too(recording):
    other = replace(recording, manifest=replace(recording.manifest, seed=recording.manifest.seed + 1, title="?" * 9))
    found = first_difference(recording, other)
    assert found == Difference(None, "manifest", "", ("title", "seed"))
    assert str(found) == "All frames are equal; their manifests differ in title, seed."


@pytest.mark.parametrize(
    ("difference", "sentence"),
    [
        (
            Difference(12, "image", "west", ("seed",)),
            "The runs first differ in frame 12, stage image of camera west; their manifests differ in seed.",
        ),
        (Difference(0, "state", "", ()), "The runs first differ in frame 0, stage state."),
        (Difference(9, "length", "", ()), "The runs are equal until one of them ends at frame 9."),
    ],
)
def test_a_difference_is_told_in_a_sentence(difference, sentence):
    assert str(difference) == sentence


@settings(max_examples=20)
@given(strategies.truths(("west", "east")))
def test_the_state_does_not_depend_on_who_looks(truth):
    assert state_hash(truth) == state_hash(replace(truth, cameras=()))
    assert state_hash(truth) != state_hash(replace(truth, time_ns=truth.time_ns + 1))


@given(strategies.frames())
def test_an_image_of_the_same_bytes_but_another_size_is_another_image(frame):
    height, width = frame.image.shape[:2]
    assume(height != width)
    turned = Frame(frame.camera, frame.index, frame.time_ns, frame.image.reshape(width, height, 3))
    assert image_hash(frame) != image_hash(turned)


@settings(max_examples=10)
@given(strategies.truths(("west",)), strategies.frames())
def test_a_stage_that_left_nothing_has_no_hash(truth, frame):
    (entry,) = ledger_of(Step((frame,), truth), [], [])
    assert (entry.tracks, entry.ground) == ("", "")
    assert ledger_of(Step((frame,), None), [], [])[0].state == ""
