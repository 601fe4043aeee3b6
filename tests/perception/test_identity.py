import numpy as np
import pytest

from contracts import Detections, Frame, Perceiver, Tracker
from perception.identity import ColourIdentity
from perception.perceiver import DetectThenTrack

FRAME = Frame("west", 0, 0, np.zeros((4, 4, 3), np.uint8))


def detections(*labels: str, scores: list[float] | None = None) -> Detections:
    n = len(labels)
    return Detections(
        "west",
        0,
        0,
        labels,
        np.array(scores) if scores else np.ones(n),
        np.tile([0.0, 0.0, 2.0, 2.0], (n, 1)),
        np.zeros((n, 4, 2)),
        np.zeros((n, 2)),
        np.full(n, 0.06),
        np.tile(np.eye(2), (n, 1, 1)),
    )


def test_a_colour_keeps_its_number_whatever_else_is_seen():
    tracker = ColourIdentity()
    assert isinstance(tracker, Tracker)
    assert tracker.update(FRAME, detections("blue", "red")).ids.tolist() == [0, 1]
    assert tracker.update(FRAME, detections("red")).ids.tolist() == [1]
    assert tracker.update(FRAME, detections("green", "red", "blue")).ids.tolist() == [2, 1, 0]


def test_reset_forgets_all_numbers():
    tracker = ColourIdentity()
    tracker.update(FRAME, detections("blue", "red"))
    tracker.reset()
    assert tracker.update(FRAME, detections("red")).ids.tolist() == [0]


def test_of_two_vehicles_of_one_colour_the_better_one_stays():
    tracks = ColourIdentity().update(FRAME, detections("red", "blue", "red", scores=[0.3, 0.5, 0.9]))
    assert tracks.objects.labels == ("blue", "red")
    assert tracks.objects.scores.tolist() == [0.5, 0.9]


@pytest.mark.parametrize("labels", [(), ("red",)])
def test_a_perceiver_chains_its_parts_and_resets_both(labels):
    calls = []

    class Scripted:
        def detect(self, frame: Frame) -> Detections:
            calls.append("detect")
            return detections(*labels)

        def reset(self) -> None:
            calls.append("reset")

    perceiver = DetectThenTrack(Scripted(), ColourIdentity())
    assert isinstance(perceiver, Perceiver)
    assert perceiver.perceive(FRAME).objects.labels == labels
    perceiver.reset()
    assert calls == ["detect", "reset"]
