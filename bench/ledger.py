"""Hashes of what each stage made of each frame, so that two runs can be compared to the bit."""

import hashlib
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bench.codec import encode
from bench.recording import LedgerEntry
from contracts import Frame, GroundTracks, Tracks
from contracts.truth import Step, Truth

HEX_DIGITS = 32  # 128 bits are enough to tell runs apart


def ledger_of(step: Step, tracks: Sequence[Tracks], views: Sequence[GroundTracks]) -> tuple[LedgerEntry, ...]:
    """One entry per frame of ``step``; ``tracks`` and ``views`` may lack a camera."""
    state = state_hash(step.truth) if step.truth else ""
    tracks_by_camera = {one.objects.camera: one for one in tracks}
    views_by_camera = {one.source: one for one in views}
    return tuple(
        LedgerEntry(
            index=frame.index,
            camera=frame.camera,
            state=state,
            image=image_hash(frame),
            tracks=_value_hash(tracks_by_camera.get(frame.camera)),
            ground=_value_hash(views_by_camera.get(frame.camera)),
        )
        for frame in step.frames
    )


def state_hash(truth: Truth) -> str:
    """Hash of the world's state alone: what the cameras see of it is a later stage."""
    return value_hash(replace(truth, cameras=()))


def image_hash(frame: Frame) -> str:
    """Hash of the image: its size and every pixel."""
    size = np.array(frame.image.shape, dtype="<i8").tobytes()
    return _digest(size, frame.image.data)


def value_hash(value: object) -> str:
    """Hash of anything that can be recorded."""
    return _digest(encode(value))


def _value_hash(value: object | None) -> str:
    return "" if value is None else value_hash(value)


def _digest(*parts: bytes | memoryview) -> str:
    digest = hashlib.sha256()  # processors have instructions for it: less than half the time of BLAKE2
    for part in parts:
        digest.update(part)
    return digest.hexdigest()[:HEX_DIGITS]
