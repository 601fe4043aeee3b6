"""The hybrid tracker over drawn films: exact where it follows, quick to find, never wrong about who is who."""

import numpy as np
import pytest
from drawn_frames import Box, draw, floor, frame_of, training_frames
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.check import check_perceiver
from contracts import ImageArray, InputError
from perception.colour_models import ColourModels
from perception.hybrid import HybridSettings, HybridTracker
from perception.learning import learn

BACKGROUND = floor(np.random.default_rng(9))
LABELS = ("blue", "red", "green")
BRIDGE = np.s_[:, 300:420]


@pytest.fixture(scope="module")
def models() -> ColourModels:
    return learn(training_frames(2, LABELS, 8))


def box_at(label: str, index: int, *, start_px: float, v_px: float, speed_px: float, turn_rad: float = 0.0) -> Box:
    """A vehicle that drives east, or on a circle, as it is in frame ``index``."""
    if not turn_rad:
        return Box(label, (start_px + speed_px * index, v_px))
    radius, angle = speed_px / turn_rad, turn_rad * index
    centre = start_px + radius * np.sin(angle), v_px + radius * (1 - np.cos(angle))
    return Box(label, centre, heading_rad=angle)


def film(frames: int, *drivers: dict, bridge: bool = False) -> list[tuple[ImageArray, list[Box]]]:
    shots = []
    for index in range(frames):
        boxes = [box_at(index=index, **driver) for driver in drivers]
        image = draw(BACKGROUND, boxes)
        if bridge:
            image[BRIDGE] = BACKGROUND[BRIDGE]
        shots.append((image, boxes))
    return shots


def watch(tracker: HybridTracker, shots):
    return [tracker.perceive(frame_of(image, index)) for index, (image, _) in enumerate(shots)]


@given(st.floats(2.0, 11.0), st.floats(-0.05, 0.05), st.sampled_from(LABELS))
@settings(max_examples=6, deadline=None)
def test_a_vehicle_is_followed_exactly_from_its_first_frame(models, speed_px, turn_rad, label):
    turn_rad = 0.0 if abs(turn_rad) < 0.005 else turn_rad
    shots = film(20, {"label": label, "start_px": 200.0, "v_px": 180.0, "speed_px": speed_px, "turn_rad": turn_rad})
    for (_, [box]), tracks in zip(shots, watch(HybridTracker(models), shots), strict=True):
        assert tracks.objects.labels == (label,)
        assert np.abs(tracks.objects.anchors_px[0] - box.centre_px).max() < 0.2


def test_identities_last_through_an_occlusion_and_every_vehicle_keeps_its_own(models):
    red = {"label": "red", "start_px": 120.0, "v_px": 120.0, "speed_px": 9.0}
    blue = {"label": "blue", "start_px": 560.0, "v_px": 230.0, "speed_px": -6.0}
    shots = film(45, red, blue, bridge=True)
    numbers: dict[str, set[int]] = {}
    for index, ((_, boxes), tracks) in enumerate(zip(shots, watch(HybridTracker(models), shots), strict=True)):
        for number, label in zip(tracks.ids.tolist(), tracks.objects.labels, strict=True):
            numbers.setdefault(label, set()).add(number)
        anchors = dict(zip(tracks.objects.labels, tracks.objects.anchors_px, strict=True))
        for box in boxes:
            u = box.centre_px[0]
            hidden_px = max(0.0, min(u + 35, 420) - max(u - 35, 300))
            if hidden_px < 0.2 * 70 and 35 <= u < 605 and box.label in anchors:
                assert np.abs(anchors[box.label] - box.centre_px).max() < 0.6, (index, box)
            clear = u < 300 - 40 or u > 420 + 40 + 3 * 9  # re-found within three frames
            if clear:
                assert box.label in tracks.objects.labels, (index, box)
            elif 300 + 40 < u < 420 - 40:
                assert box.label not in tracks.objects.labels, (index, box)
    assert numbers in ({"red": {0}, "blue": {1}}, {"red": {1}, "blue": {0}})


@pytest.mark.parametrize("speed_px", [4.0, 12.0])
def test_a_vehicle_that_enters_is_tracked_within_three_frames_and_one_that_left_is_gone(models, speed_px):
    shots = film(75, {"label": "green", "start_px": -60.0, "v_px": 180.0, "speed_px": speed_px})
    waited = 0
    for (_, [box]), tracks in zip(shots, watch(HybridTracker(models), shots), strict=True):
        inside = 0.8 * 35 < box.centre_px[0] < 640 - 0.8 * 35
        waited = waited + 1 if inside and not len(tracks) else 0
        assert waited <= 3
        if box.centre_px[0] < -36 or box.centre_px[0] > 676:
            assert not len(tracks)


def test_what_the_border_cuts_is_believed_in_its_second_frame_and_a_wall_that_shows_once_is_not(models):
    """A strip of a vehicle's colour and size leans into the image once; then the vehicle itself stands there, cut."""
    tracker = HybridTracker(models)
    wall, cut = Box("red", (10.0, 180.0), np.pi / 2), Box("red", (28.0, 180.0))
    seen = [
        tracker.perceive(frame_of(draw(BACKGROUND, boxes), index))
        for index, boxes in enumerate([[], [wall], [], [], [], [cut], [cut], [cut]])
    ]
    assert [len(tracks) for tracks in seen[:5]] == [0] * 5
    waited = [len(tracks) for tracks in seen[5:]]
    assert waited[-1] == 1
    assert np.abs(seen[-1].objects.anchors_px - cut.centre_px).max() < 0.3


def test_a_vehicle_that_vanishes_is_given_up_at_once(models):
    shots = film(10, {"label": "red", "start_px": 200.0, "v_px": 180.0, "speed_px": 5.0})
    tracker = HybridTracker(models)
    watch(tracker, shots)
    assert not len(tracker.perceive(frame_of(BACKGROUND, 10)))


def test_a_sudden_stop_and_a_reversal_do_not_lose_a_vehicle(models):
    places = [200 + 8 * k for k in range(10)] + [272] * 5 + [272 - 8 * k for k in range(1, 10)]
    tracker = HybridTracker(models)
    for index, u in enumerate(places):
        box = Box("blue", (float(u), 180.0))
        tracks = tracker.perceive(frame_of(draw(BACKGROUND, [box]), index))
        assert np.abs(tracks.objects.anchors_px - box.centre_px).max(initial=9.0 * (len(tracks) == 0)) < 0.2


def test_the_perceivers_contract_holds(models):
    assert check_perceiver(lambda: HybridTracker(models)) == []


@pytest.mark.parametrize("name", ["search_every", "watch_every", "doubts"])
def test_settings_that_would_never_act_are_refused(name):
    with pytest.raises(InputError, match=name):
        HybridSettings(**{name: 0})
