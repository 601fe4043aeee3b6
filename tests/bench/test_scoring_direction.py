"""Known injuries to what is said of motion, known scores."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scoring_cases import edit_truth, motions_of_truth, perfect_recording

from bench.recording import Recording
from bench.scores import by_name
from bench.scoring import score
from bench.scoring.direction import SETTLE_S, direction_scores
from contracts import Compass, Motions, MotionState

STEPS, VEHICLES = 30, 2
LATE = [k for k in range(STEPS) if k * 0.04 >= SETTLE_S]  # frames in which an answer is asked for
POPULATION = VEHICLES * len(LATE)
RECORDING = perfect_recording(steps=STEPS, vehicles=VEHICLES, cameras=1)


def edit_motions(recording, edit):
    return Recording(recording.manifest, tuple(replace(one, motions=edit(one.motions)) for one in recording.steps))


def values(recording):
    return {one.name: one.value for one in direction_scores(recording, 0.06)}


def with_truth(change):
    """The recording with other true velocities, and motions that say so."""
    edited = edit_truth(RECORDING, change)
    return Recording(edited.manifest, tuple(replace(s, motions=motions_of_truth(s.truth)) for s in edited.steps))


def test_the_truth_itself_scores_perfectly():
    read = by_name(score(RECORDING))
    assert read["direction.correct"].value == 1.0
    assert read["direction.correct"].n == read["direction.heading_rms_rad"].n == read["speed.rms_mps"].n == POPULATION
    assert read["direction.flips"].value == read["direction.heading_rms_rad"].value == 0.0
    assert read["direction.heading_coverage_90"].value == read["speed.coverage_90"].value == 1.0
    assert not read["direction.standing_correct"].valid


@given(st.floats(-0.7, 0.7), st.floats(-0.2, 0.2))
@settings(max_examples=20, deadline=None)
def test_a_turn_and_a_wrong_speed_are_read_exactly(turn_rad, faster_mps):
    c, s = np.cos(turn_rad), np.sin(turn_rad)

    def edit(motions):
        factor = 1 + faster_mps / motions.speeds_mps[:, None]
        return replace(motions, velocities_mps=factor * motions.velocities_mps @ np.array([[c, s], [-s, c]]))

    read = values(edit_motions(RECORDING, edit))
    assert abs(read["direction.heading_rms_rad"] - abs(turn_rad)) < 1e-9
    assert abs(read["direction.heading_p95_rad"] - abs(turn_rad)) < 1e-9
    assert abs(read["speed.rms_mps"] - abs(faster_mps)) < 1e-9
    assert read["direction.correct"] == 1.0


@given(st.sets(st.tuples(st.sampled_from(LATE[1:-1:2]), st.integers(0, VEHICLES - 1)), min_size=1))
@settings(max_examples=20, deadline=None)
def test_k_wrong_directions_are_k_wrong_frames_and_twice_as_many_flips(cells):
    def edited(k, motions):
        directions = [Compass.WEST if (k, row) in cells else one for row, one in enumerate(motions.directions)]
        return replace(motions, directions=tuple(directions))

    steps = tuple(replace(step, motions=edited(k, step.motions)) for k, step in enumerate(RECORDING.steps))
    read = values(Recording(RECORDING.manifest, steps))
    assert read["direction.correct"] == (POPULATION - len(cells)) / POPULATION
    assert read["direction.flips"] == 2 * len(cells)


def test_unknown_is_not_right_and_has_neither_heading_nor_speed():
    read = values(
        Recording(RECORDING.manifest, tuple(replace(s, motions=Motions.unknown(s.fused)) for s in RECORDING.steps))
    )
    assert read["direction.correct"] == read["direction.flips"] == 0
    assert read["direction.heading_rms_rad"] is read["speed.rms_mps"] is None


def test_a_new_identity_that_the_analyst_does_not_know_is_wrong():
    renamed = edit_motions(RECORDING, lambda motions: replace(motions, ids=motions.ids + 100))
    assert values(renamed)["direction.correct"] == 0.0


@pytest.mark.parametrize(("off_deg", "right"), [(39.0, 0.0), (41.0, 1.0), (45.0, 1.0), (49.0, 1.0), (51.0, 1.0)])
def test_near_the_diagonal_either_side_is_right(off_deg, right):
    heading = np.radians(off_deg)
    velocity = 0.25 * np.array([np.cos(heading), np.sin(heading)])
    recording = with_truth(lambda truth: replace(truth, velocities_mps=np.tile(velocity, (len(truth.ids), 1))))
    north = edit_motions(recording, lambda motions: replace(motions, directions=(Compass.NORTH,) * VEHICLES))
    assert values(north)["direction.correct"] == right


def test_standing_is_asked_for_and_a_direction_while_standing_is_wrong_and_flips():
    standing = with_truth(lambda truth: replace(truth, velocities_mps=np.zeros((len(truth.ids), 2))))
    still = edit_motions(
        standing, lambda m: replace(m, states=(MotionState.STANDING,) * VEHICLES, directions=(None,) * VEHICLES)
    )
    read = values(still)
    assert read["direction.standing_correct"] == 1.0
    assert read["direction.correct"] is None
    assert read["direction.flips"] == 0
    turns = [Compass.EAST, Compass.WEST]
    steps = tuple(
        replace(
            step,
            motions=replace(
                step.motions, states=(MotionState.MOVING,) * VEHICLES, directions=(turns[k % 2], Compass.EAST)
            ),
        )
        for k, step in enumerate(still.steps)
    )
    read = values(Recording(still.manifest, steps))
    assert read["direction.standing_correct"] == 0.0
    assert read["direction.flips"] == STEPS - 1


def test_nothing_is_asked_for_just_after_turning_round_or_while_crawling():
    turn = 10

    def back(truth):
        sign = 1 if truth.index < turn else -1
        return replace(truth, velocities_mps=sign * truth.velocities_mps)

    asked = sum(k * 0.04 >= turn * 0.04 + SETTLE_S - 1e-9 for k in range(STEPS))
    scores = {one.name: one for one in direction_scores(with_truth(back), 0.06)}
    assert scores["direction.correct"].n == VEHICLES * asked
    crawling = with_truth(lambda truth: replace(truth, velocities_mps=0.04 * truth.velocities_mps))
    assert values(crawling)["direction.correct"] is values(crawling)["direction.standing_correct"] is None


def test_where_nothing_was_filmed_direction_is_scored_all_the_same():
    truth_only = edit_truth(RECORDING, lambda truth: replace(truth, cameras=()))
    assert values(truth_only)["direction.correct"] == 1.0
