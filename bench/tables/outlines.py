"""The masks that detectors work with, beside the exact masks of the vehicles."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from bench.matching import TARGET_FRACTION
from bench.tables.films import Film, one_thread
from contracts import BoolArray, FloatArray, Frame, ImageArray
from contracts.truth import CameraTruth, Truth
from perception.silhouette import Silhouette


class OutlineDetector(Protocol):
    """A detector that shows the masks behind its detections."""

    def silhouettes(self, image: ImageArray) -> dict[str, Silhouette]:
        """The outline of each vehicle that is found in an image (H, W, 3), by its label."""
        ...


@dataclass(frozen=True, eq=False)
class Outlines:
    """The N outlines that a detector accepted in a film.

    rectangularity: (N,) raw mask pixels over the smallest rotated rectangle, nothing filled.
    overlaps: (N,) raw mask and exact mask, pixels of both over pixels of either; 0 where no vehicle of that label is
        visible, NaN where too little of it is visible to be demanded.
    """

    rectangularity: FloatArray
    overlaps: FloatArray


def outlines(shown: Film, detectors: Mapping[str, OutlineDetector]) -> Outlines:
    """What ``detectors``, by their camera's name, accept in a film."""
    with one_thread():
        rows = [
            row
            for step in shown.steps
            if step.truth is not None
            for row in _of_step(step.frames, step.truth, detectors)
        ]
    table = np.array(rows).reshape(-1, 2)
    return Outlines(table[:, 0], table[:, 1])


def _of_step(
    frames: tuple[Frame, ...], truth: Truth, detectors: Mapping[str, OutlineDetector]
) -> Iterator[tuple[float, float]]:
    for frame, view in zip(frames, truth.cameras, strict=True):
        for label, outline in detectors[frame.camera].silhouettes(frame.image).items():
            yield outline.rectangularity, overlap(outline, label, truth, view)


def overlap(outline: Silhouette, label: str, truth: Truth, view: CameraTruth) -> float:
    """Intersection over union of the raw mask and the visible pixels of the vehicle called ``label``; see ``Outlines``.

    Where several vehicles bear the label, the one it overlaps most counts.
    """
    if view.instances is None:
        return float("nan")
    rows = [row for row, name in enumerate(truth.labels) if name == label and view.visible_fractions[row] > 0]
    if not rows:
        return 0.0
    if all(view.visible_fractions[row] < TARGET_FRACTION for row in rows):
        return float("nan")
    (left, top), (height, width) = outline.origin_px, outline.raw.shape
    found = np.zeros(view.instances.shape, np.bool_)
    found[top : top + height, left : left + width] = outline.raw > 0
    return max(intersection_over_union(found, view.instances == row + 1) for row in rows)


def intersection_over_union(a: BoolArray, b: BoolArray) -> float:
    """Pixels of both masks over pixels of either; 0 of nothing."""
    either = int(np.count_nonzero(a | b))
    return np.count_nonzero(a & b) / either if either else 0.0
