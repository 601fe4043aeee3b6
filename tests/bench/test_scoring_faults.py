"""Known injuries, known scores: a bench that cannot read back a planted fault is not a bench."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scoring_cases import (
    edit_ground,
    edit_tracks,
    edit_truth,
    perfect_recording,
    perfect_recordings,
    shifted,
    take,
    with_ghost,
)

from bench.recording import Recording
from bench.scores import by_name
from bench.scoring import score
from contracts import InputError


def values(recording: Recording, **options: float) -> dict[str, float | None]:
    return {name: score.value for name, score in by_name(score(recording, **options)).items()}


@given(perfect_recordings())
def test_the_truth_itself_scores_perfectly(recording):
    read = values(recording)
    assert read["detection.recall"] == read["detection.precision"] == read["detection.f1"] == 1.0
    assert read["fused.misses"] == read["fused.false_alarms"] == read["label.wrong"] == 0
    assert read["ground.max_m"] == read["ground.rms_x_m"] == read["ground.nees"] == 0.0
    assert read["ground.coverage_90"] == 1.0


@given(perfect_recordings(), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_a_shift_is_read_exactly(recording, east_m, north_m):
    read = values(edit_ground(recording, lambda ground: shifted(ground, [east_m, north_m])), gate_m=0.15)
    distance_m = np.hypot(east_m, north_m)
    for name in ("mean_m", "median_m", "p95_m", "max_m"):
        assert abs(read[f"ground.{name}"] - distance_m) < 1e-9
    assert abs(read["ground.mean_x_m"] - east_m) < 1e-9
    assert abs(read["ground.mean_y_m"] - north_m) < 1e-9
    assert abs(read["ground.rms_x_m"] - abs(east_m)) < 1e-9
    assert abs(read["ground.west.rms_y_m"] - abs(north_m)) < 1e-9
    assert abs(read["ground.mse_x_m2"] - east_m**2) < 1e-9


@given(perfect_recordings(min_vehicles=2, min_steps=4), st.data())
def test_seven_dropped_boxes_are_seven_misses(recording, data):
    vehicles = len(recording.steps[0].fused)
    cells = [(step, row) for step in range(len(recording.steps)) for row in range(vehicles)]
    dropped = set(data.draw(st.permutations(cells))[:7])
    steps = []
    for k, step in enumerate(recording.steps):
        kept = [row for row in range(vehicles) if (k, row) not in dropped]
        steps.append(replace(step, views=(take(step.views[0], kept), *step.views[1:])))
    read = values(Recording(recording.manifest, tuple(steps)))
    assert read["detection.misses"] == 7
    assert read["detection.false_alarms"] == 0
    assert read["detection.recall"] == (read["detection.targets"] - 7) / read["detection.targets"]
    assert read["detection.precision"] == 1


@given(perfect_recordings(), st.floats(0.061, 5.0))
def test_every_ghost_is_a_false_alarm(recording, north_m):
    haunted = edit_ground(recording, lambda ground: with_ghost(ground, (0.0, 2.0 + north_m)))
    read = values(haunted)
    frames = len(recording.steps)
    assert read["fused.false_alarms"] == frames
    assert read["detection.false_alarms"] == frames * len(recording.manifest.true_cameras)
    assert read["detection.recall"] == 1
    assert read["ground.max_m"] == 0


@given(perfect_recordings())
def test_estimates_beyond_the_gate_are_misses_and_false_alarms(recording):
    read = values(edit_ground(recording, lambda ground: shifted(ground, [0.0, 0.0601])))
    assert read["fused.misses"] == read["fused.false_alarms"] == read["fused.targets"]
    assert read["ground.mean_m"] is None


@given(perfect_recordings(), st.floats(0.01, 100.0))
def test_a_covariance_k_times_as_large_divides_nees_by_k(recording, k):
    moved = edit_ground(recording, lambda ground: shifted(ground, [0.001, 0.002]))
    scaled = edit_ground(moved, lambda ground: replace(ground, covs_m2=ground.covs_m2 * k))
    assert abs(values(moved)["ground.nees"] - 5) < 1e-6
    assert abs(values(scaled)["ground.nees"] - 5 / k) < 1e-6 / k
    assert values(scaled)["ground.coverage_90"] == (1.0 if 5 / k <= 4.605170185988091 else 0.0)


@given(perfect_recordings(), st.data())
def test_row_order_and_track_numbers_do_not_matter(recording, data):
    vehicles = len(recording.steps[0].fused)
    order = data.draw(st.permutations(range(vehicles)))
    moved = edit_ground(recording, lambda ground: shifted(ground, [0.003, -0.002]))
    renamed = edit_ground(moved, lambda ground: replace(ground, ids=ground.ids * 17 + 5))
    renamed = edit_tracks(renamed, lambda tracks: replace(tracks, ids=tracks.ids * 17 + 5))
    shuffled = edit_ground(renamed, lambda ground: take(ground, order))
    expected = values(moved)
    valueless = {name for name, value in expected.items() if value is None}
    assert {name for name in valueless if not name.startswith(("direction.", "speed."))} == {"track.refound_frames_max"}
    for name, value in values(shuffled).items():
        assert value is None or value == pytest.approx(expected[name], rel=0, abs=1e-12), name


def test_a_wrong_name_is_a_hit_with_a_wrong_label():
    recording = perfect_recording(steps=4, vehicles=2, cameras=1)
    renamed = edit_ground(recording, lambda ground: replace(ground, labels=("blue", "blue")))
    read = values(renamed)
    assert read["detection.recall"] == 1
    assert read["label.wrong"] == 4
    assert read["label.accuracy"] == 0.5


def test_half_hidden_objects_are_neither_asked_for_nor_held_against_the_detector():
    recording = perfect_recording(steps=4, vehicles=2, cameras=1)
    half = edit_truth(
        recording,
        lambda truth: replace(
            truth, cameras=tuple(replace(view, visible_fractions=[1.0, 0.5]) for view in truth.cameras)
        ),
    )
    blind = edit_ground(half, lambda ground: take(ground, [0]))
    for case in (half, blind):
        read = values(case)
        assert read["detection.targets"] == 4
        assert read["detection.misses"] == read["detection.false_alarms"] == 0


def test_an_estimate_of_a_wholly_hidden_object_is_a_false_alarm():
    recording = perfect_recording(steps=4, vehicles=2, cameras=1)
    hidden = edit_truth(
        recording,
        lambda truth: replace(
            truth, cameras=tuple(replace(view, visible_fractions=[1.0, 0.0]) for view in truth.cameras)
        ),
    )
    assert values(hidden)["detection.false_alarms"] == 4


def test_an_estimate_that_has_no_place_is_a_false_alarm():
    recording = perfect_recording(steps=4, vehicles=2, cameras=1)
    lost = edit_ground(
        recording,
        lambda ground: replace(
            ground, valid=[True, False], positions_m=np.vstack([ground.positions_m[:1], [[np.nan, np.nan]]])
        ),
    )
    read = values(lost)
    assert read["detection.misses"] == read["detection.false_alarms"] == 4


def test_real_footage_has_every_score_and_none_is_valid():
    recording = perfect_recording()
    footage = Recording(
        replace(recording.manifest, true_cameras=()),
        tuple(replace(step, truth=None) for step in recording.steps),
    )
    scores = score(footage)
    assert {s.name for s in scores} == {s.name for s in score(recording)}
    assert not any(s.valid for s in scores)
    assert all(s.value is None for s in scores)


def test_a_gate_that_is_not_positive_is_refused():
    with pytest.raises(InputError, match="gate"):
        score(perfect_recording(), gate_m=0.0)


def visible(recording: Recording, fractions_by_frame: list[float]) -> Recording:
    """The first camera sees so much of every object."""
    shares = iter(fractions_by_frame)

    def edit(truth):
        share = next(shares)
        views = (replace(truth.cameras[0], visible_fractions=np.full(len(truth.ids), share)), *truth.cameras[1:])
        return replace(truth, cameras=views)

    return edit_truth(recording, edit)


@pytest.mark.parametrize(("late", "entry", "refound"), [(0, 0, 0), (2, 0, 2), (3, 0, 3)])
def test_a_vehicle_found_late_after_an_occlusion_is_read_exactly(late, entry, refound):
    hidden = visible(perfect_recording(steps=10, vehicles=2, cameras=1), [1, 1, 1, 0.5, 0, 0.7, 1, 1, 1, 1])
    steps = [
        replace(step, views=(take(step.views[0], [0] if 6 <= k < 6 + late else [0, 1]),))
        for k, step in enumerate(hidden.steps)
    ]
    read = values(Recording(hidden.manifest, tuple(steps)))
    assert (read["track.entry_frames_max"], read["track.refound_frames_max"]) == (entry, refound)


def test_a_vehicle_that_is_never_found_waits_for_its_whole_stay():
    recording = visible(perfect_recording(steps=6, vehicles=1, cameras=1), [0, 1, 1, 1, 1, 0])
    outside = edit_truth(
        recording,
        lambda truth: replace(
            truth, cameras=tuple(replace(view, full_boxes_px=[[-9.0, 10, 40, 50]]) for view in truth.cameras)
        ),
    )
    blind = edit_ground(outside, lambda ground: take(ground, []))
    assert values(blind)["track.entry_frames_max"] == 4
    assert values(blind)["track.refound_frames_max"] is None
