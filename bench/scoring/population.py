"""The population of every score: what one source saw, matched to the truth, over a whole recording."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bench.matching import Matching, match
from bench.recording import RecordedStep, Recording
from contracts import FloatArray, GroundTracks, IntArray
from contracts.truth import CameraTruth, Truth

FUSED = "fused"


@dataclass(frozen=True, eq=False)
class MatchedFrame:
    """One frame of one source with its truth and the matching between them.

    fractions: (N,) how much of each object the source can see.
    """

    truth: Truth
    fractions: FloatArray
    ground: GroundTracks
    matching: Matching


@dataclass(frozen=True, eq=False)
class Hits:
    """The K hits of one source over all frames, column by column.

    index, time_ns: (K,) of the frame.
    objects, object_labels: K ids and labels of the true objects.
    track_ids, labels: (K,) and K, of the estimates.
    truths_m, estimates_m: (K, 2) positions on the ground.
    covs_m2: (K, 2, 2) covariance that the estimates state.
    """

    index: IntArray
    time_ns: IntArray
    objects: tuple[str, ...]
    object_labels: tuple[str, ...]
    track_ids: IntArray
    labels: tuple[str, ...]
    truths_m: FloatArray
    estimates_m: FloatArray
    covs_m2: FloatArray

    def __len__(self) -> int:
        return len(self.objects)

    @property
    def errors_m(self) -> FloatArray:
        """Estimate minus truth, (K, 2)."""
        return self.estimates_m - self.truths_m


@dataclass(frozen=True, eq=False)
class Population:
    """All that one source saw and missed.

    source: a camera's name or ``"fused"``.
    frames: every frame that has a truth, in order.
    """

    source: str
    frames: tuple[MatchedFrame, ...]

    @cached_property
    def hits(self) -> Hits:
        """The matched targets of all frames."""
        return gather(self.frames)

    @property
    def hit_count(self) -> int:
        """Targets that were found."""
        return sum(len(frame.matching.hits) for frame in self.frames)

    @property
    def miss_count(self) -> int:
        """Targets that were not found."""
        return sum(len(frame.matching.misses) for frame in self.frames)

    @property
    def false_alarm_count(self) -> int:
        """Estimates where no object is."""
        return sum(len(frame.matching.false_alarms) for frame in self.frames)


def camera_names(recording: Recording) -> tuple[str, ...]:
    """The cameras of a run, simulated or real."""
    manifest = recording.manifest
    cameras = manifest.true_cameras or tuple(calibrated.camera for calibrated in manifest.calibrated_cameras)
    return tuple(camera.name for camera in cameras)


def fused_population(recording: Recording, gate_m: float) -> Population:
    """The positions fused over all cameras; an object counts as visible as in the camera that sees most of it.

    Where no camera filmed there is nothing to be found, so such frames do not count.
    """
    frames = (
        _matched(step.truth, step.fused, best_fractions(step.truth), gate_m)
        for step in recording.steps
        if step.truth is not None and step.truth.cameras
    )
    return Population(FUSED, tuple(frames))


def camera_population(recording: Recording, camera: str, gate_m: float) -> Population:
    """What ``camera`` alone placed on the ground."""
    frames = (
        _matched(truth, ground, view.visible_fractions, gate_m)
        for truth, view, ground in _views(recording.steps, camera)
    )
    return Population(camera, tuple(frames))


def best_fractions(truth: Truth) -> FloatArray:
    """Visible fraction of each object in the camera that sees most of it, (N,)."""
    views = [view.visible_fractions for view in truth.cameras]
    return np.max(views, axis=0) if views else np.zeros(len(truth.ids))


def _views(steps: tuple[RecordedStep, ...], camera: str) -> Iterator[tuple[Truth, CameraTruth, GroundTracks]]:
    for step in steps:
        if step.truth is None:
            continue
        views = {view.camera: view for view in step.truth.cameras}
        grounds = {ground.source: ground for ground in step.views}
        if camera in views and camera in grounds:
            yield step.truth, views[camera], grounds[camera]


def _matched(truth: Truth, ground: GroundTracks, fractions: FloatArray, gate_m: float) -> MatchedFrame:
    estimates_m = np.where(ground.valid[:, None], ground.positions_m, np.nan)  # (M, 2)
    matching = match(truth.positions_m[:, :2], estimates_m, fractions=fractions, gate_m=gate_m)
    return MatchedFrame(truth, fractions, ground, matching)


def gather(frames: tuple[MatchedFrame, ...]) -> Hits:
    """The hits of all frames as columns."""
    rows = [(frame.truth, frame.ground, a, b) for frame in frames for a, b in frame.matching.hits.tolist()]
    return Hits(
        index=np.array([truth.index for truth, _, _, _ in rows], dtype=np.int64),
        time_ns=np.array([truth.time_ns for truth, _, _, _ in rows], dtype=np.int64),
        objects=tuple(truth.ids[a] for truth, _, a, _ in rows),
        object_labels=tuple(truth.labels[a] for truth, _, a, _ in rows),
        track_ids=np.array([ground.ids[b] for _, ground, _, b in rows], dtype=np.int64),
        labels=tuple(ground.labels[b] for _, ground, _, b in rows),
        truths_m=np.array([truth.positions_m[a, :2] for truth, _, a, _ in rows]).reshape(-1, 2),
        estimates_m=np.array([ground.positions_m[b] for _, ground, _, b in rows]).reshape(-1, 2),
        covs_m2=np.array([ground.covs_m2[b] for _, ground, _, b in rows]).reshape(-1, 2, 2),
    )
