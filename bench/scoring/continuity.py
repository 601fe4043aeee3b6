"""Does an object keep its identity? CLEAR, IDF1 and HOTA on the ground.

The similarity of an object and a track falls linearly from 1 at no distance to 0 at twice the gate, so that one half,
the threshold of CLEAR and IDF1, is the gate itself. Ignored objects and the estimates matched to them are left out.
"""

from collections.abc import Hashable, Iterable

import numpy as np

from bench.matching import is_target
from bench.scores import Score
from bench.scoring.population import MatchedFrame, Population
from bench.scoring.tracking import TrackFrame, clear, hota, identity
from contracts import FloatArray, IntArray


def track_scores(prefix: str, population: Population, gate_m: float) -> list[Score]:
    """MOTA, identity switches, IDF1 and HOTA with its parts; none is valid without a target."""
    frames = sequence(population, gate_m)
    n = sum(len(frame.objects) for frame in frames)
    counts, same, higher = clear(frames), identity(frames), hota(frames)
    return [
        Score.of(f"{prefix}.mota", counts.mota, "1", n),
        Score.of(f"{prefix}.id_switches", counts.id_switches, "count", n),
        Score.of(f"{prefix}.idf1", same.idf1, "1", n),
        Score.of(f"{prefix}.hota", higher.hota, "1", n),
        Score.of(f"{prefix}.deta", float(higher.detection.mean()), "1", n),
        Score.of(f"{prefix}.assa", float(higher.association.mean()), "1", n),
    ]


def sequence(population: Population, gate_m: float) -> list[TrackFrame]:
    """Targets and tracks of each frame, numbered over the sequence."""
    objects = _numbers(thing for frame in population.frames for thing in frame.truth.ids)
    tracks = _numbers(track for frame in population.frames for track in frame.ground.ids.tolist())
    return [_track_frame(frame, objects, tracks, gate_m) for frame in population.frames]


def _track_frame(
    frame: MatchedFrame, objects: dict[Hashable, int], tracks: dict[Hashable, int], gate_m: float
) -> TrackFrame:
    targets = np.flatnonzero(is_target(frame.fractions))
    kept = np.setdiff1d(np.arange(len(frame.ground)), frame.matching.ignored[:, 1])
    truths_m = frame.truth.positions_m[targets, :2]
    estimates_m = np.where(frame.ground.valid[kept, None], frame.ground.positions_m[kept], np.inf)
    distances_m = np.linalg.norm(truths_m[:, None] - estimates_m[None, :], axis=2)  # (N, M)
    return TrackFrame(
        objects=_rows(objects, [frame.truth.ids[k] for k in targets]),
        tracks=_rows(tracks, frame.ground.ids[kept].tolist()),
        similarity=_similarity(distances_m, gate_m),
    )


def _similarity(distances_m: FloatArray, gate_m: float) -> FloatArray:
    return np.maximum(0.0, 1.0 - distances_m / (2.0 * gate_m))


def _numbers(names: Iterable[Hashable]) -> dict[Hashable, int]:
    """0, 1, 2, ... in order of first appearance."""
    return {name: k for k, name in enumerate(dict.fromkeys(names))}


def _rows(numbers: dict[Hashable, int], names: Iterable[Hashable]) -> IntArray:
    return np.array([numbers[name] for name in names], dtype=np.int64)
