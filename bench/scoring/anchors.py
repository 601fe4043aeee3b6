"""The image points that stand for the objects, beside the true ones."""

from dataclasses import dataclass

import numpy as np

from bench.recording import Recording
from bench.scores import Score
from bench.scoring.ground import known_rows, rms
from bench.scoring.population import Hits, MatchedFrame, Population
from contracts import FloatArray, Tracks
from contracts.truth import CameraTruth


@dataclass(frozen=True, eq=False)
class Sightings:
    """The K hits of one camera whose track is recorded, with their anchors.

    hits: the same K rows on the ground.
    anchors_px, heights_m: (K, 2) and (K,) as perception stated them, the heights from z = 0 like the true ones.
    true_anchors_px, true_heights_m: (K, 2) and (K,) of the true point that is meant: the centre of the roof, or that of
        the footprint where the stated height is nearer to the ground.
    """

    hits: Hits
    anchors_px: FloatArray
    heights_m: FloatArray
    true_anchors_px: FloatArray
    true_heights_m: FloatArray

    @property
    def errors_px(self) -> FloatArray:
        """Stated anchor minus true one, (K, 2)."""
        return self.anchors_px - self.true_anchors_px


def sightings(recording: Recording, population: Population) -> Sightings:
    """The anchors behind the hits of one camera, row for row."""
    camera = population.source
    tracks = {(t.objects.camera, step.index): t for step in recording.steps for t in step.tracks}
    rows = [_frame_rows(frame, camera, tracks.get((camera, frame.truth.index))) for frame in population.frames]
    anchors = np.concatenate([np.empty((0, 6)), *rows])  # (K, 6)
    return Sightings(population.hits, anchors[:, 0:2], anchors[:, 2], anchors[:, 3:5], anchors[:, 5])


def anchor_scores(prefix: str, errors_px: FloatArray) -> list[Score]:
    """Root mean square and mean (the signed bias) of the anchors' errors (K, 2), u to the right and v down.

    Rows of NaN (not known) are left out.
    """
    errors_px = known_rows(errors_px)
    n = len(errors_px)
    return [
        score
        for k, axis in enumerate("uv")
        for score in (
            Score.of(f"{prefix}.rms_{axis}_px", rms(errors_px[:, k]), "px", n),
            Score.of(f"{prefix}.mean_{axis}_px", float(errors_px[:, k].mean()) if n else float("nan"), "px", n),
        )
    ]


def _frame_rows(frame: MatchedFrame, camera: str, tracks: Tracks | None) -> FloatArray:
    """One row per hit: anchor u, v, height; true anchor u, v, height. NaN where the track was not recorded."""
    hits = frame.matching.hits
    rows = np.full((len(hits), 6), np.nan)
    if tracks is None:
        return rows
    view = next(view for view in frame.truth.cameras if view.camera == camera)
    place = {track: k for k, track in enumerate(tracks.ids.tolist())}
    for row, (thing, estimate) in zip(rows, hits.tolist(), strict=True):
        k = place.get(int(frame.ground.ids[estimate]))
        if k is not None:
            height_m = tracks.objects.anchor_heights_m[k]
            row[:3] = *tracks.objects.anchors_px[k], height_m + float(frame.truth.positions_m[thing, 2])
            row[3:] = _true_anchor(frame, view, thing, height_m)
    return rows


def _true_anchor(frame: MatchedFrame, view: CameraTruth, thing: int, height_m: float) -> tuple[float, float, float]:
    foot_m = float(frame.truth.positions_m[thing, 2])
    roof_m = foot_m + float(frame.truth.sizes_m[thing, 2])
    on_roof = abs(height_m - (roof_m - foot_m)) <= abs(height_m)
    u, v = (view.roofs_px if on_roof else view.footprints_px)[thing]
    return float(u), float(v), roof_m if on_roof else foot_m
