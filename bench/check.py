"""The contract kit: every law that a detector, tracker or perceiver must obey, tried out on small made-up frames.

A finding is a broken law, in a sentence for the author. No finding does not mean that the thing sees well: that is what
runs and scores are for.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.check_frames import Scene, given_scenes, strange_scenes, street
from bench.ledger import value_hash
from bench.plugins import load_factory, require_methods
from contracts import Detections, Detector, Frame, InputError, Perceiver, Tracker, Tracks

Act = Callable[[Any, Scene], object]
Answer = Detections | Tracks
AnswerOf = Callable[[object, Scene], Answer]


@dataclass(frozen=True)
class Finding:
    """A law that is broken: its short name, and what happened."""

    law: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.law}: {self.sentence}"


def check_detector(factory: Callable[[], Detector], frames: Sequence[Frame] = ()) -> list[Finding]:
    """Broken laws of the detector that ``factory`` makes; empty if all hold.

    frames: more images of one camera, in order, such as those that it is made for.
    """
    return _check(factory, Detector, lambda detector, scene: detector.detect(scene.frame), frames)


def check_tracker(factory: Callable[[], Tracker], frames: Sequence[Frame] = ()) -> list[Finding]:
    """Broken laws of the tracker that ``factory`` makes, given faultless detections; empty if all hold.

    frames: more images of one camera, in order, which come without detections.
    """
    return _check(factory, Tracker, lambda tracker, scene: tracker.update(scene.frame, scene.detections), frames)


def check_perceiver(factory: Callable[[], Perceiver], frames: Sequence[Frame] = ()) -> list[Finding]:
    """Broken laws of the perceiver that ``factory`` makes; empty if all hold.

    frames: more images of one camera, in order, such as those that it is made for.
    """
    return _check(factory, Perceiver, lambda perceiver, scene: perceiver.perceive(scene.frame), frames)


def check_plugin(stage: str, path: str, frames: Sequence[Frame] = ()) -> list[Finding]:
    """Broken laws of the plug-in at ``path`` as a ``"detector"``, ``"tracker"`` or ``"perceiver"``.

    frames: more images to try it on, of one camera and in order.
    Raises InputError if there is no such stage or plug-in.
    """
    if stage not in KITS:
        raise InputError(f"there is no contract for {stage!r}, only for {', '.join(KITS)}")
    protocol, check = KITS[stage]
    return check(load_factory(path, protocol), frames)


KITS: dict[str, tuple[type, Callable[[Callable[[], Any], Sequence[Frame]], list[Finding]]]] = {
    "detector": (Detector, check_detector),
    "tracker": (Tracker, check_tracker),
    "perceiver": (Perceiver, check_perceiver),
}
"""By the stage's name: its protocol and its check."""


class _BrokenLawError(Exception):
    """A law is broken so badly that the following ones cannot be tried."""

    def __init__(self, law: str, sentence: str) -> None:
        super().__init__(sentence)
        self.finding = Finding(law, sentence)


def _check(factory: Callable[[], object], protocol: type, act: Act, frames: Sequence[Frame]) -> list[Finding]:
    kind = Detections if protocol is Detector else Tracks

    def answer(subject: object, scene: Scene) -> Answer:
        return _answer(subject, scene, act, kind)

    made = _findings(_made(factory, protocol))
    if made:
        return made
    findings: list[Finding] = []
    for scenes in filter(None, (street(), given_scenes(frames))):
        broken = _findings(_laws(factory, scenes, answer))
        findings += broken or _findings(_repeats(factory, scenes, answer))
    for scenes in strange_scenes():
        findings += _findings(_laws(factory, scenes, answer))
    return list(dict.fromkeys(findings))


def _findings(found: Iterator[Finding]) -> list[Finding]:
    """All that ``found`` yields, and the broken law that ended it."""
    findings = []
    try:
        for finding in found:
            findings.append(finding)
    except _BrokenLawError as broken:
        findings.append(broken.finding)
    return findings


def _made(factory: Callable[[], object], protocol: type) -> Iterator[Finding]:
    try:
        subject = factory()
    except Exception as error:
        raise _BrokenLawError("made", f"It cannot be made without arguments: {_told(error)}.") from error
    try:
        require_methods(subject, protocol, name=type(subject).__name__)
    except InputError as error:
        yield Finding("methods", f"{error}.")


def _laws(factory: Callable[[], Any], scenes: Sequence[Scene], answer: AnswerOf) -> Iterator[Finding]:
    """What must hold of every single answer."""
    subject = factory()
    for scene in scenes:
        before = scene.frame.image.copy()
        given = answer(subject, scene)
        if not np.array_equal(before, scene.frame.image):
            yield Finding("frame untouched", f"It changed the image of {scene.title}.")
        objects = given.objects if isinstance(given, Tracks) else given
        yield from _copied(objects, scene)
        yield from _well_formed(objects, scene)


def _copied(objects: Detections, scene: Scene) -> Iterator[Finding]:
    for name in ("camera", "index", "time_ns"):
        got, wanted = getattr(objects, name), getattr(scene.frame, name)
        if got != wanted:
            yield Finding("copied", f"It answered {name} {got!r} to a frame whose {name} is {wanted!r}.")


def _well_formed(objects: Detections, scene: Scene) -> Iterator[Finding]:
    """What the types themselves do not enforce."""
    for label in objects.labels:
        if not isinstance(label, str) or not label:
            yield Finding("well formed", f"It gave the label {label!r} in {scene.title}; a label is a word.")
    height, width = scene.frame.image.shape[:2]
    outside = (objects.boxes_px[:, 2:] < -0.5) | (objects.boxes_px[:, :2] > [width - 0.5, height - 0.5])  # (N, 2)
    if outside.any():
        box = objects.boxes_px[outside.any(axis=1)][0].tolist()
        yield Finding("well formed", f"It gave the box {box} in {scene.title}, which is {width} x {height} pixels.")
    covs = objects.anchor_covs_px2
    if len(covs) and (not np.allclose(covs, np.swapaxes(covs, 1, 2)) or np.linalg.eigvalsh(covs).min() < -1e-9):
        yield Finding("well formed", f"It gave an anchor_covs_px2 in {scene.title} that is no covariance.")


def _repeats(factory: Callable[[], Any], scenes: Sequence[Scene], answer: AnswerOf) -> Iterator[Finding]:
    """What must hold of the same frames seen again."""

    def answer_hash(subject: object, scene: Scene) -> str:
        return value_hash(answer(subject, scene))

    subject = factory()
    first = [answer_hash(subject, scene) for scene in scenes]
    subject.reset()
    if [answer_hash(subject, scene) for scene in scenes] != first:
        yield Finding("reset", "After reset() it gives other answers to the same frames than at first.")
    second = factory()
    if [answer_hash(second, scene) for scene in scenes] != first:
        yield Finding("same again", "A second instance gives other answers to the same frames.")
        return
    pair = factory(), factory()
    if any({answer_hash(one, scene) for one in pair} != {alone} for scene, alone in zip(scenes, first, strict=True)):
        yield Finding("alone", "Two instances that take turns give other answers than each alone: they share a state.")


def _answer(subject: object, scene: Scene, act: Act, kind: type[Answer]) -> Answer:
    try:
        given = act(subject, scene)
    except Exception as error:
        if "read-only" in str(error):
            raise _BrokenLawError("frame untouched", f"It tries to write into {scene.title}: {error}.") from error
        raise _BrokenLawError("runs", f"It fails on {scene.title}: {_told(error)}.") from error
    if not isinstance(given, kind):
        told = f"It answered {type(given).__name__} to {scene.title}, not {kind.__name__}."
        raise _BrokenLawError("answer", told)
    return given


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".rstrip(".")
