"""``Recording -> scores``: pure functions; nothing is simulated again, nothing is read but the recording.

Without a truth (real footage) every score is there, and none is valid.
"""

from bench.matching import gate_m as gate_of_world
from bench.recording import Recording
from bench.scores import Score
from bench.scoring.continuity import track_scores
from bench.scoring.detection import detection_scores, label_scores
from bench.scoring.ground import consistency_scores, error_scores
from bench.scoring.population import FUSED, camera_names, camera_population, fused_population


def score(recording: Recording, *, gate_m: float | None = None) -> tuple[Score, ...]:
    """All scores of a run.

    gate_m: largest distance at which an estimate belongs to an object; that of the recording's world if not given.
    """
    gate = gate_of_world(recording.manifest.world) if gate_m is None else gate_m
    fused = fused_population(recording, gate)
    cameras = [camera_population(recording, name, gate) for name in camera_names(recording)]
    scores = [
        *detection_scores("detection", cameras),
        *detection_scores(FUSED, [fused]),
        *label_scores(cameras),
        *track_scores("track", fused, gate),
        *error_scores("ground", fused.hits.errors_m),
        *consistency_scores("ground", fused.hits),
    ]
    for camera in cameras:
        scores += error_scores(f"ground.{camera.source}", camera.hits.errors_m)
        scores += consistency_scores(f"ground.{camera.source}", camera.hits)
        scores += track_scores(f"track.{camera.source}", camera, gate)
    return tuple(scores)
