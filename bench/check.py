"""The contract kit: every law that a stage must obey, tried out on small made-up frames or tracks.

A finding is a broken law, in a sentence for the author. No finding does not mean that the thing sees well: that is what
runs and scores are for.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from bench.check_analyst import check_analyst
from bench.check_frames import Scene, given_scenes, strange_scenes, street
from bench.check_laws import Finding, answer_of, findings_of, made, repeats
from bench.plugins import load_factory
from contracts import Analyst, Detections, Detector, Frame, InputError, Perceiver, Tracker, Tracks

Act = Callable[[Any, Scene], object]
Answer = Detections | Tracks
AnswerOf = Callable[[object, Scene], Answer]


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
    """Broken laws of the plug-in at ``path`` as one of ``KITS``.

    frames: more images to try it on, of one camera and in order; an analyst looks at none.
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
    "analyst": (Analyst, lambda factory, _: check_analyst(factory)),
}
"""By the stage's name: its protocol and its check."""


def _check(factory: Callable[[], object], protocol: type, act: Act, frames: Sequence[Frame]) -> list[Finding]:
    kind: type[Answer] = Detections if protocol is Detector else Tracks

    def answer(subject: object, scene: Scene) -> Answer:
        return answer_of(subject, scene, act, kind)

    unmade = findings_of(made(factory, protocol))
    if unmade:
        return unmade
    findings: list[Finding] = []
    for scenes in filter(None, (street(), given_scenes(frames))):
        broken = findings_of(_laws(factory, scenes, answer))
        findings += broken or findings_of(repeats(factory, scenes, answer))
    for scenes in strange_scenes():
        findings += findings_of(_laws(factory, scenes, answer))
    return list(dict.fromkeys(findings))


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
