"""MOTChallenge text files (Milan et al. 2016, arXiv 1603.00831): one sequence directory per camera.

``CAMERA/tracks.txt`` holds what perception said, ``CAMERA/gt/gt.txt`` the truth, ``CAMERA/seqinfo.ini`` the sequence,
``CAMERA/img1/`` the images if they were recorded. The format counts frames and pixels from 1, so that a box at the
image's left edge has left = 1.

Class 1 stands for any object here. One that is visible by less than ``LEAST_VISIBLE`` is a distractor (class 8, not
considered), which is how the format says "neither demanded nor held against the tracker".
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bench.export.images import write_images
from bench.recording import Recording
from bench.recording_file import load_recording
from contracts import FloatArray, InputError

LEAST_VISIBLE = 0.8
OBJECT, DISTRACTOR = 1, 8
_LEFT_OF_BOX = 1.5  # from the first pixel's centre at 0 and its edge at -0.5 to an edge at 1


def export_mot(directory: Path, out: Path) -> Path:
    """Write the run in ``directory`` as MOTChallenge sequences below ``out``, which is returned.

    Raises InputError if the run holds neither tracks nor views of the truth.
    """
    recording = load_recording(directory)
    cameras = recording.manifest.cameras
    if not cameras or not any(step.tracks for step in recording.steps):
        raise InputError(f"{directory} holds no tracks in images, so there is nothing to export to MOT")
    for name, camera in cameras.items():
        sequence = out / name
        (sequence / "gt").mkdir(parents=True, exist_ok=True)
        _write_lines(sequence / "tracks.txt", track_lines(recording, name))
        _write_lines(sequence / "gt" / "gt.txt", truth_lines(recording, name))
        _write_lines(sequence / "gt" / "identities.txt", (f"{n} {one}" for one, n in _numbers(recording).items()))
        size = camera.intrinsics.width_px, camera.intrinsics.height_px
        _write_lines(sequence / "seqinfo.ini", _sequence_lines(recording, name, size))
    write_images(directory, lambda frame: out / frame.camera / "img1" / f"{frame.index + 1:06d}.png")
    return out


def track_lines(recording: Recording, camera: str) -> Iterator[str]:
    """Lines ``frame, id, left, top, width, height, score, -1, -1, -1``; ids are shifted together to be positive."""
    all_tracks = [tracks for step in recording.steps for tracks in step.tracks if tracks.objects.camera == camera]
    shift = max([1 - int(tracks.ids.min()) for tracks in all_tracks if len(tracks)] + [0])
    for tracks in all_tracks:
        for number, box_px, score in zip(
            tracks.ids.tolist(), tracks.objects.boxes_px, tracks.objects.scores, strict=True
        ):
            yield f"{tracks.objects.index + 1},{number + shift},{_box(box_px)},{score:.6f},-1,-1,-1"


def truth_lines(recording: Recording, camera: str) -> Iterator[str]:
    """Lines ``frame, id, left, top, width, height, considered, class, visibility``; whole boxes, hidden parts too."""
    numbers = _numbers(recording)
    for step in recording.steps:
        for view in step.truth.cameras if step.truth else ():
            if step.truth is None or view.camera != camera:
                continue
            for one, box_px, visible in zip(step.truth.ids, view.full_boxes_px, view.visible_fractions, strict=True):
                if visible > 0 and np.isfinite(box_px).all():
                    considered = int(visible >= LEAST_VISIBLE)
                    kind = OBJECT if considered else DISTRACTOR
                    yield f"{view.index + 1},{numbers[one]},{_box(box_px)},{considered},{kind},{visible:.6f}"


def _numbers(recording: Recording) -> dict[str, int]:
    """True objects' ids to numbers from 1, in the order in which they appear."""
    ids = dict.fromkeys(one for step in recording.steps if step.truth for one in step.truth.ids)
    return {one: number for number, one in enumerate(ids, start=1)}


def _box(box_px: FloatArray) -> str:
    x1, y1, x2, y2 = box_px.tolist()
    return f"{x1 + _LEFT_OF_BOX:.4f},{y1 + _LEFT_OF_BOX:.4f},{x2 - x1:.4f},{y2 - y1:.4f}"


def _sequence_lines(recording: Recording, name: str, size_px: tuple[int, int]) -> Iterator[str]:
    yield "[Sequence]"
    yield f"name={name}"
    yield "imDir=img1"
    yield f"frameRate={recording.manifest.fps:g}"
    yield f"seqLength={len(recording.steps)}"
    yield f"imWidth={size_px[0]}"
    yield f"imHeight={size_px[1]}"
    yield "imExt=.png"


def _write_lines(path: Path, lines: Iterator[str]) -> None:
    path.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
