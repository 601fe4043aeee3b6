"""CLEAR, IDF1 and HOTA against TrackEval's raw output, and the laws that they obey."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scoring_cases import edit_ground, perfect_recording, perfect_recordings, take

from bench.recording import Recording
from bench.scores import by_name
from bench.scoring import score
from bench.scoring.tracking import TrackFrame, clear, hota, identity

AUTHORITY = Path(__file__).parents[1] / "authorities" / "trackeval"
SEQUENCES = json.loads((AUTHORITY / "sequences.json").read_text())
TRACKEVAL = json.loads((AUTHORITY / "trackeval.json").read_text())


def frames_of(rows):
    return [
        TrackFrame(
            np.array(row["objects"], dtype=np.int64),
            np.array(row["tracks"], dtype=np.int64),
            np.array(row["similarity"]).reshape(len(row["objects"]), len(row["tracks"])),
        )
        for row in rows
    ]


@pytest.mark.parametrize("case", SEQUENCES)
def test_clear_counts_are_those_of_trackeval(case):
    ours, theirs = clear(frames_of(SEQUENCES[case])), TRACKEVAL[case]["CLEAR"]
    assert ours.pairs == theirs["CLR_TP"]
    assert ours.misses == theirs["CLR_FN"]
    assert ours.false_alarms == theirs["CLR_FP"]
    assert ours.id_switches == theirs["IDSW"]
    assert abs(ours.similarity - theirs["MOTP_sum"]) < 1e-9
    assert case == "no objects" or abs(ours.mota - theirs["MOTA"]) < 1e-12


@pytest.mark.parametrize("case", SEQUENCES)
def test_identity_counts_are_those_of_trackeval(case):
    ours, theirs = identity(frames_of(SEQUENCES[case])), TRACKEVAL[case]["Identity"]
    assert (ours.pairs, ours.misses, ours.false_alarms) == (theirs["IDTP"], theirs["IDFN"], theirs["IDFP"])
    assert abs(ours.idf1 - theirs["IDF1"]) < 1e-12


@pytest.mark.parametrize("case", SEQUENCES)
def test_hota_and_its_parts_are_those_of_trackeval(case):
    ours, theirs = hota(frames_of(SEQUENCES[case])), TRACKEVAL[case]["HOTA"]
    assert np.abs(ours.detection - theirs["DetA"]).max() < 1e-12
    assert np.abs(ours.association - theirs["AssA"]).max() < 1e-12
    assert np.abs(ours.localisation - theirs["LocA"]).max() < 1e-9
    assert abs(ours.hota - np.mean(theirs["HOTA"])) < 1e-12


def values(recording):
    return {name: score.value for name, score in by_name(score(recording)).items()}


def with_ids(recording, ids_by_step):
    """The fused tracks of step k get the ids ``ids_by_step[k]``."""
    steps = (
        replace(step, fused=replace(step.fused, ids=ids))
        for step, ids in zip(recording.steps, ids_by_step, strict=True)
    )
    return Recording(recording.manifest, tuple(steps))


@given(perfect_recordings())
def test_the_truth_itself_is_tracked_perfectly(recording):
    read = values(recording)
    assert read["track.mota"] == read["track.idf1"] == read["track.hota"] == 1.0
    assert read["track.id_switches"] == read["track.west.id_switches"] == 0


@given(perfect_recordings(min_vehicles=2, min_steps=2), st.data())
def test_two_ids_that_change_places_are_two_switches_each_time(recording, data):
    count = len(recording.steps)
    swaps = data.draw(st.sets(st.integers(1, count - 1)))
    ids, by_step = recording.steps[0].fused.ids.copy(), []
    for k in range(count):
        if k in swaps:
            ids[[0, 1]] = ids[[1, 0]]
        by_step.append(ids.copy())
    read = values(with_ids(recording, by_step))
    assert read["track.id_switches"] == 2 * len(swaps)
    assert read["fused.misses"] == read["ground.max_m"] == 0


def test_a_swap_half_way_halves_idf1_of_the_two():
    recording = perfect_recording(steps=6, vehicles=2)
    read = values(with_ids(recording, [[1, 2]] * 3 + [[2, 1]] * 3))
    assert read["track.idf1"] == 0.5
    assert read["track.mota"] == 1 - 2 / 12


def test_an_id_that_returns_after_a_gap_is_no_switch():
    recording = perfect_recording(steps=6, vehicles=2)
    steps = [replace(s, fused=take(s.fused, [1])) if s.index in (2, 3) else s for s in recording.steps]
    read = values(Recording(recording.manifest, tuple(steps)))
    assert read["track.id_switches"] == 0
    assert read["track.mota"] == 1 - 2 / 12


@given(perfect_recordings(min_vehicles=2), st.data())
def test_numbers_and_order_of_tracks_do_not_matter(recording, data):
    vehicles = len(recording.steps[0].fused)
    order = data.draw(st.permutations(range(vehicles)))
    renamed = edit_ground(recording, lambda ground: take(replace(ground, ids=ground.ids * -31), order))
    before, after = values(recording), values(renamed)
    assert {k: v for k, v in after.items() if k.startswith("track.")} == {
        k: v for k, v in before.items() if k.startswith("track.")
    }
