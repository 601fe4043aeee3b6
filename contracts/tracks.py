"""What perception says about one frame: detections, and tracks, which are detections with an identity."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contracts.arrays import FloatArray, IntArray, freeze
from contracts.errors import InputError


@dataclass(frozen=True, eq=False)
class Detections:
    """Objects found in one frame; N rows, all in pixels of that frame.

    camera, index, time_ns: of the frame.
    labels: N colour or class names.
    scores: (N,) in [0, 1].
    boxes_px: (N, 4) upright boxes x1, y1, x2, y2.
    quads_px: (N, 4, 2) corners of the rotated box in order round it; those of the upright box where no more is known.
    anchors_px: (N, 2) the image point that stands for the object.
    anchor_heights_m: (N,) height above ground of the plane on which that point lies.
    anchor_covs_px2: (N, 2, 2) the detector's own statement of the anchor's error: second moment, bias included.
    """

    camera: str
    index: int
    time_ns: int
    labels: tuple[str, ...]
    scores: FloatArray
    boxes_px: FloatArray
    quads_px: FloatArray
    anchors_px: FloatArray
    anchor_heights_m: FloatArray
    anchor_covs_px2: FloatArray

    def __post_init__(self) -> None:
        n = len(self.labels)
        object.__setattr__(self, "labels", tuple(self.labels))
        freeze(self, "scores", shape=(n,))
        freeze(self, "boxes_px", shape=(n, 4))
        freeze(self, "quads_px", shape=(n, 4, 2))
        freeze(self, "anchors_px", shape=(n, 2))
        freeze(self, "anchor_heights_m", shape=(n,))
        freeze(self, "anchor_covs_px2", shape=(n, 2, 2))
        if n and (self.scores.min() < 0 or self.scores.max() > 1):
            raise InputError(f"{type(self).__name__}.scores must lie in [0, 1]")
        if (self.boxes_px[:, 2:] < self.boxes_px[:, :2]).any():
            raise InputError(f"{type(self).__name__}.boxes_px must be x1, y1, x2, y2 with x1 <= x2 and y1 <= y2")

    def __len__(self) -> int:
        return len(self.labels)

    @classmethod
    def empty(cls, camera: str, index: int, time_ns: int) -> "Detections":
        """No objects in this frame."""
        none = np.empty(0)
        return Detections(camera, index, time_ns, (), none, none, none, none, none, none)

    def take(self, rows: Sequence[int]) -> "Detections":
        """The objects of ``rows``, in that order."""
        if list(rows) == list(range(len(self))):
            return self
        columns = (column[list(rows)] for column in self._columns())
        return Detections(self.camera, self.index, self.time_ns, tuple(self.labels[row] for row in rows), *columns)

    def joined(self, other: "Detections") -> "Detections":
        """These objects, then those of ``other``, found in the same frame."""
        both = zip(self._columns(), other._columns(), strict=True)
        columns = (np.concatenate(pair) for pair in both)
        return Detections(self.camera, self.index, self.time_ns, (*self.labels, *other.labels), *columns)

    def _columns(self) -> tuple[FloatArray, ...]:
        return (
            self.scores,
            self.boxes_px,
            self.quads_px,
            self.anchors_px,
            self.anchor_heights_m,
            self.anchor_covs_px2,
        )


@dataclass(frozen=True, eq=False)
class Tracks:
    """Detections with an identity that lasts from frame to frame of one camera.

    ids: (N,) identity numbers, unique within the frame.
    objects: the N objects themselves.
    """

    ids: IntArray
    objects: Detections

    def __post_init__(self) -> None:
        freeze(self, "ids", shape=(len(self.objects),), dtype=np.int64)
        if len(set(self.ids.tolist())) != len(self.ids):
            raise InputError(f"Tracks.ids must be unique within a frame, got {self.ids.tolist()}")

    def __len__(self) -> int:
        return len(self.ids)
