import dataclasses
import itertools
import re

import cv2
import numpy as np
import pytest

from bench.check import KITS, check_detector, check_perceiver, check_plugin, check_tracker
from bench.check_frames import COLOURS_BGR
from contracts import Detections, Frame, InputError, Tracks


class Blocks:
    """Finds the kit's coloured blocks; obeys every law."""

    def __init__(self):
        self.reset()

    def reset(self):
        self.seen = 0

    def detect(self, frame):
        self.seen += 1
        found = []
        for label, colour in COLOURS_BGR.items():
            mask = (frame.image == colour).all(axis=2).astype(np.uint8)
            if mask.sum() > 20:
                left, top, width, height = cv2.boundingRect(mask)
                found.append((label, [left, top, left + width - 1, top + height - 1]))
        n = len(found)
        boxes = np.array([box for _, box in found], float).reshape(n, 4)
        return Detections(
            frame.camera,
            frame.index,
            frame.time_ns,
            labels=tuple(label for label, _ in found),
            scores=np.ones(n),
            boxes_px=boxes,
            quads_px=boxes[:, [0, 1, 2, 1, 2, 3, 0, 3]].reshape(n, 4, 2),
            anchors_px=(boxes[:, :2] + boxes[:, 2:]) / 2,
            anchor_heights_m=np.zeros(n),
            anchor_covs_px2=np.tile(np.eye(2), (n, 1, 1)),
        )


class ByLabel:
    """A tracker that numbers labels in the order in which they appear; obeys every law."""

    def __init__(self):
        self.reset()

    def reset(self):
        self.ids = {}

    def update(self, frame, detections):
        return Tracks([self.ids.setdefault(label, len(self.ids)) for label in detections.labels], detections)


class Both:
    """A perceiver of the two."""

    def __init__(self):
        self.detector, self.tracker = Blocks(), ByLabel()

    def reset(self):
        self.tracker.reset()

    def perceive(self, frame):
        return self.tracker.update(frame, self.detector.detect(frame))


def laws(findings):
    return {finding.law for finding in findings}


def test_whoever_obeys_has_no_findings():
    assert check_detector(Blocks) == []
    assert check_tracker(ByLabel) == []
    assert check_perceiver(Both) == []


def test_each_kit_goes_by_the_name_of_its_stage():
    assert {name: protocol.__name__.lower() for name, (protocol, _) in KITS.items()} == {name: name for name in KITS}


def changed(**fields):
    """A detector class whose answers have other fields; each value is a function of the answer."""

    class Changed(Blocks):
        def detect(self, frame):
            answer = super().detect(frame)
            return dataclasses.replace(answer, **{name: make(answer) for name, make in fields.items()})

    return Changed


@pytest.mark.parametrize(
    ("fields", "law"),
    [
        ({"camera": lambda _: "other"}, "copied"),
        ({"index": lambda _: 0}, "copied"),
        ({"time_ns": lambda answer: answer.time_ns + 1}, "copied"),
        ({"labels": lambda answer: ("",) * len(answer)}, "well formed"),
        ({"labels": lambda answer: tuple(range(len(answer)))}, "well formed"),
        ({"boxes_px": lambda answer: answer.boxes_px + 1000}, "well formed"),
        ({"boxes_px": lambda answer: answer.boxes_px - 1000}, "well formed"),
        ({"boxes_px": lambda answer: answer.boxes_px * np.nan}, "runs"),
        ({"boxes_px": lambda answer: answer.boxes_px[:, ::-1]}, "runs"),
        ({"anchor_covs_px2": lambda answer: -answer.anchor_covs_px2}, "well formed"),
        ({"scores": lambda answer: answer.scores * 2}, "runs"),
        ({"scores": lambda answer: answer.scores * np.random.default_rng().random()}, "same again"),
    ],
)
def test_a_broken_answer_is_found(fields, law):
    assert law in laws(check_detector(changed(**fields)))


def test_who_writes_into_the_frame_is_found():
    class Painter(Blocks):
        def detect(self, frame):
            cv2.rectangle(frame.image, (0, 0), (5, 5), (0, 0, 0))
            return super().detect(frame)

    class Sneak(Blocks):
        def detect(self, frame):
            frame.image.base[0, 0] += 1  # the view is read-only, the array below it is not
            return super().detect(frame)

    assert laws(check_detector(Painter)) & {"frame untouched", "runs"}
    assert "frame untouched" in laws(check_detector(Sneak))


def test_who_remembers_beyond_reset_is_found():
    class Tired(Blocks):
        def reset(self):
            self.seen = getattr(self, "seen", 0)

        def detect(self, frame):
            answer = super().detect(frame)
            return dataclasses.replace(answer, scores=answer.scores / self.seen)

    assert laws(check_detector(Tired)) == {"reset"}


def test_identities_from_a_counter_that_all_instances_share_are_found():
    counter = itertools.count()

    class Global(ByLabel):
        def update(self, frame, detections):
            ids = [self.ids.setdefault(label, next(counter)) for label in detections.labels]
            return Tracks(ids, detections)

    assert laws(check_tracker(Global)) == {"reset", "same again"}


def test_instances_that_share_a_state_are_found():
    latest = []

    class Shared(ByLabel):
        def reset(self):
            latest.clear()

        def update(self, frame, detections):
            latest.append(frame.index)
            return Tracks(np.arange(len(detections)) + len(latest), detections)

    assert laws(check_tracker(Shared)) == {"alone"}


def test_who_cannot_bear_an_empty_frame_is_found():
    class Divider(Blocks):
        def detect(self, frame):
            return super().detect(frame) if frame.image.std() else 1 // 0

    findings = check_detector(Divider)
    assert laws(findings) == {"runs"}
    assert "It fails on a black image: ZeroDivisionError" in findings[0].sentence


@pytest.mark.parametrize(
    ("factory", "law", "words"),
    [
        (lambda: 1 // 0, "made", "ZeroDivisionError"),
        (ByLabel, "methods", r"ByLabel is no Detector: it lacks detect\(\)"),
        (object, "methods", r"it lacks detect\(\) and reset\(\)"),
    ],
)
def test_what_is_no_detector_is_found(factory, law, words):
    (finding,) = check_detector(factory)
    assert finding.law == law
    assert re.search(words, finding.sentence)


def test_an_answer_of_the_wrong_kind_is_found():
    class Silent(Blocks):
        def detect(self, frame):
            return None

    assert "It answered NoneType" in check_detector(Silent)[0].sentence


def test_a_plug_in_is_checked_by_its_path():
    (finding,) = check_plugin("detector", "builtins:print")
    assert str(finding) == "methods: NoneType is no Detector: it lacks detect() and reset()."


def test_a_stage_without_a_contract_is_refused():
    with pytest.raises(InputError, match="no contract for 'renderer', only for detector, tracker, perceiver"):
        check_plugin("renderer", "builtins:print")


def test_given_frames_are_tried_too():
    class Picky(Blocks):
        def detect(self, frame):
            return super().detect(frame) if frame.camera == "kit" else None

    frames = [Frame("west", k, k, np.zeros((40, 60, 3), np.uint8)) for k in range(3)]
    assert check_detector(Blocks, frames) == check_tracker(ByLabel, frames) == check_perceiver(Both, frames) == []
    assert [str(finding) for finding in check_detector(Picky, frames)] == [
        "answer: It answered NoneType to frame 0, not Detections."
    ]
