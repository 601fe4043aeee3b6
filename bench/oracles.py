"""Stages that are given the truth, by name and on request, to see which honest stage owns the error.

``detect``: perception is replaced by the exact image of every roof's centre. ``calibrate``: the true cameras are used.
``locate``: the ground positions themselves; no frame is needed, so nothing is filmed.
"""

import numpy as np

from contracts import Camera, Detections, GroundTracks, InputError, IntArray, Tracks
from contracts.truth import CameraTruth, Step, Truth
from georef.calibrated import PARAMETERS, CalibratedCamera

ORACLES = ("detect", "calibrate", "locate")
SEEN_FRACTION = 0.5  # an oracle reports what a good detector could: objects of which at least half is visible


class TrueDetection:
    """Exact tracks of every camera, straight from the truth. Objects may come and go: each keeps its number."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def perceive(self, step: Step) -> tuple[Tracks, ...]:
        """What every camera sees well enough."""
        truth = _truth_of(step)
        numbers = np.array([self._numbers.setdefault(name, len(self._numbers)) for name in truth.ids], np.int64)
        return tuple(_tracks(truth, view, numbers) for view in truth.cameras)


def true_camera(camera: Camera) -> CalibratedCamera:
    """The true camera as if calibration had been perfect."""
    return CalibratedCamera(camera, np.zeros((len(PARAMETERS), len(PARAMETERS))))


class TrueLocation:
    """The true positions as one view of the ground. Objects may come and go: each keeps its number."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def locate(self, step: Step, _: tuple[Tracks, ...]) -> tuple[GroundTracks, ...]:
        """All objects of the truth."""
        truth = _truth_of(step)
        ids = [self._numbers.setdefault(name, len(self._numbers)) for name in truth.ids]
        return (_true_view(truth, ids),)


def _true_view(truth: Truth, ids: list[int]) -> GroundTracks:
    n = len(ids)
    return GroundTracks(
        source="truth",
        time_ns=truth.time_ns,
        ids=np.array(ids, dtype=np.int64),
        labels=truth.labels,
        positions_m=truth.positions_m[:, :2],
        covs_m2=np.zeros((n, 2, 2)),
        valid=np.ones(n, dtype=bool),
    )


def _truth_of(step: Step) -> Truth:
    if step.truth is None:
        raise InputError("real footage has no truth: run it without --oracle")
    return step.truth


def _tracks(truth: Truth, view: CameraTruth, numbers: IntArray) -> Tracks:
    seen = np.flatnonzero(view.visible_fractions >= SEEN_FRACTION)
    boxes_px = view.full_boxes_px[seen]
    x1, y1, x2, y2 = boxes_px.T
    objects = Detections(
        camera=view.camera,
        index=view.index,
        time_ns=view.time_ns,
        labels=tuple(truth.labels[k] for k in seen),
        scores=np.ones(len(seen)),
        boxes_px=boxes_px,
        quads_px=np.stack([x1, y1, x2, y1, x2, y2, x1, y2], axis=1).reshape(-1, 4, 2),
        anchors_px=view.roofs_px[seen],
        anchor_heights_m=truth.sizes_m[seen, 2],
        anchor_covs_px2=np.zeros((len(seen), 2, 2)),
    )
    return Tracks(ids=numbers[seen], objects=objects)
