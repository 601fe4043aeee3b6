"""CLEAR, IDF1 and HOTA of one sequence, as pure functions; held to TrackEval's own output in the tests.

They see numbers only: who was there, what was tracked, how similar each pair is, in [0, 1]. A similarity of at least
one half makes a possible pair in CLEAR and IDF1; HOTA takes 19 thresholds from 0.05 to 0.95.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from contracts import FloatArray, IntArray

SIMILAR = 0.5
HOTA_THRESHOLDS = np.arange(1, 20) * 0.05
_EPSILON = float(np.finfo(np.float64).eps)
_CONTINUED = 1000.0  # outweighs any sum of similarities: a pair of the previous frame stays a pair


@dataclass(frozen=True, eq=False)
class TrackFrame:
    """One frame of a sequence.

    objects: (N,) numbers of the true objects present, counted from 0 over the sequence.
    tracks: (M,) numbers of the tracks present, counted from 0 over the sequence.
    similarity: (N, M) in [0, 1].
    """

    objects: IntArray
    tracks: IntArray
    similarity: FloatArray


@dataclass(frozen=True)
class Clear:
    """Counts of CLEAR (Bernardin & Stiefelhagen 2008); ``similarity`` is the sum over the pairs."""

    pairs: int
    misses: int
    false_alarms: int
    id_switches: int
    similarity: float

    @property
    def mota(self) -> float:
        """1 - (misses + false alarms + switches) / objects; may be negative. NaN without an object."""
        return _ratio(self.pairs - self.false_alarms - self.id_switches, self.pairs + self.misses)


@dataclass(frozen=True)
class Identity:
    """Counts of IDF1 (Ristani et al. 2016): boxes that bear the one identity that suits their object best."""

    pairs: int
    misses: int
    false_alarms: int

    @property
    def idf1(self) -> float:
        """Harmonic mean of identity precision and recall. NaN without object and track."""
        return _ratio(2 * self.pairs, 2 * self.pairs + self.misses + self.false_alarms)


@dataclass(frozen=True, eq=False)
class Hota:
    """HOTA (Luiten et al. 2021) per threshold of ``HOTA_THRESHOLDS``, (19,): detection, association, localisation."""

    detection: FloatArray
    association: FloatArray
    localisation: FloatArray

    @property
    def hota(self) -> float:
        """Mean over the thresholds of sqrt(detection x association), eq. 4 and 5."""
        return float(np.sqrt(self.detection * self.association).mean())


def clear(frames: Sequence[TrackFrame]) -> Clear:
    """CLEAR's counts. Pairs of the previous frame are kept while they are similar, then similarity is maximised.

    As in TrackEval a frame without object or without track neither ends nor starts a pair.
    """
    last: dict[int, int] = {}  # object -> the track that it had last, however long ago: a change is a switch
    previous: dict[int, int] = {}  # object -> its track in the previous frame
    pair_count = misses = false_alarms = switches = 0
    similarity = 0.0
    for frame in frames:
        pairs = _continuing_pairs(frame, previous)
        named = {int(frame.objects[a]): int(frame.tracks[b]) for a, b in pairs}
        switches += sum(last.get(thing, track) != track for thing, track in named.items())
        last |= named
        if len(frame.objects) and len(frame.tracks):
            previous = named
        pair_count += len(pairs)
        misses += len(frame.objects) - len(pairs)
        false_alarms += len(frame.tracks) - len(pairs)
        similarity += float(frame.similarity[pairs[:, 0], pairs[:, 1]].sum())
    return Clear(pair_count, misses, false_alarms, switches, similarity)


def _continuing_pairs(frame: TrackFrame, previous: dict[int, int]) -> IntArray:
    """Rows of objects and tracks that belong together, (K, 2)."""
    before = np.array([previous.get(thing, -1) for thing in frame.objects.tolist()], dtype=np.int64)
    gain = frame.similarity + _CONTINUED * (frame.tracks[None, :] == before[:, None])  # (N, M)
    gain = np.where(frame.similarity >= SIMILAR - _EPSILON, gain, 0.0)
    rows, columns = linear_sum_assignment(-gain)
    chosen = gain[rows, columns] > _EPSILON
    return np.column_stack([rows[chosen], columns[chosen]]).astype(np.int64)


def identity(frames: Sequence[TrackFrame]) -> Identity:
    """IDF1's counts: each object gets at most one track over the whole sequence, the one that makes the best total."""
    together = np.zeros(_sizes(frames))  # (objects, tracks): frames in which the two could be a pair
    for frame in frames:
        together[np.ix_(frame.objects, frame.tracks)] += frame.similarity >= SIMILAR
    rows, columns = linear_sum_assignment(-together)
    pairs = int(together[rows, columns].sum())
    boxes, tracked = sum(len(frame.objects) for frame in frames), sum(len(frame.tracks) for frame in frames)
    return Identity(pairs, boxes - pairs, tracked - pairs)


def hota(frames: Sequence[TrackFrame]) -> Hota:
    """HOTA's parts. Pairs maximise similarity weighted by how well object and track agree over the whole sequence."""
    boxes, tracked = _presence(frames)  # (objects, 1), (1, tracks)
    alignment = _alignment(frames, boxes, tracked)
    together = np.zeros((len(HOTA_THRESHOLDS), *alignment.shape))  # (19, objects, tracks)
    similarity = np.zeros(len(HOTA_THRESHOLDS))
    for frame in frames:
        rows, columns = linear_sum_assignment(-alignment[np.ix_(frame.objects, frame.tracks)] * frame.similarity)
        near = frame.similarity[rows, columns]
        similar = near[None, :] >= HOTA_THRESHOLDS[:, None] - _EPSILON  # (19, K)
        together[:, frame.objects[rows], frame.tracks[columns]] += similar
        similarity += (near * similar).sum(axis=1)
    pairs = together.sum(axis=(1, 2))  # (19,)
    jaccard = together / np.maximum(1.0, boxes + tracked - together)  # eq. 2: association of each pair
    return Hota(
        detection=pairs / np.maximum(1.0, boxes.sum() + tracked.sum() - pairs),
        association=(together * jaccard).sum(axis=(1, 2)) / np.maximum(1.0, pairs),
        localisation=np.maximum(1e-10, similarity) / np.maximum(1e-10, pairs),
    )


def _alignment(frames: Sequence[TrackFrame], boxes: FloatArray, tracked: FloatArray) -> FloatArray:
    """Jaccard index of each object and track over the sequence, (objects, tracks), before any pair is chosen."""
    shared = np.zeros(_sizes(frames))
    for frame in frames:
        near = frame.similarity
        union = near.sum(axis=0)[None, :] + near.sum(axis=1)[:, None] - near
        share = np.divide(near, union, out=np.zeros_like(near), where=union > _EPSILON)
        shared[np.ix_(frame.objects, frame.tracks)] += share
    alignment: FloatArray = shared / np.maximum(1e-12, boxes + tracked - shared)
    return alignment


def _presence(frames: Sequence[TrackFrame]) -> tuple[FloatArray, FloatArray]:
    """In how many frames each object, (objects, 1), and each track, (1, tracks), is present."""
    objects, tracks = _sizes(frames)
    boxes, tracked = np.zeros((objects, 1)), np.zeros((1, tracks))
    for frame in frames:
        boxes[frame.objects, 0] += 1
        tracked[0, frame.tracks] += 1
    return boxes, tracked


def _sizes(frames: Sequence[TrackFrame]) -> tuple[int, int]:
    """How many objects and tracks the sequence has."""
    return (
        max((int(frame.objects.max(initial=-1)) for frame in frames), default=-1) + 1,
        max((int(frame.tracks.max(initial=-1)) for frame in frames), default=-1) + 1,
    )


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else float("nan")
