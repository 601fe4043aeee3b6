"""``Recording -> scores``: pure functions; nothing is simulated again, nothing is read but the recording.

Without a truth (real footage) every score is there, and none is valid.
"""

import numpy as np

from bench.matching import gate_m as gate_of_world
from bench.recording import Recording
from bench.scores import Score
from bench.scoring.anchors import Sightings, anchor_scores, sightings
from bench.scoring.calibration import calibration_scores
from bench.scoring.contacts import contact_scores
from bench.scoring.continuity import track_scores
from bench.scoring.detection import detection_scores, label_scores
from bench.scoring.direction import direction_scores
from bench.scoring.ground import consistency_scores, error_scores
from bench.scoring.latency import latency_scores
from bench.scoring.naive import ground_plane_errors
from bench.scoring.population import FUSED, Population, camera_names, camera_population, fused_population
from bench.scoring.stages import split, stage_scores


def score(recording: Recording, *, gate_m: float | None = None) -> tuple[Score, ...]:
    """All scores of a run: those of the whole first, then those of each camera.

    gate_m: largest distance at which an estimate belongs to an object; that of the recording's world if not given.
    Raises InputError if the gate is not positive.
    """
    gate = gate_of_world(recording.manifest.world) if gate_m is None else gate_m
    names = camera_names(recording)
    fused = fused_population(recording, gate)
    cameras = [camera_population(recording, name, gate) for name in names]
    seen = [(camera.source, sightings(recording, camera)) for camera in cameras]
    return (
        *detection_scores("detection", cameras),
        *detection_scores(FUSED, [fused]),
        *label_scores(cameras),
        *error_scores("ground", fused.hits.errors_m),
        *consistency_scores("ground", fused.hits),
        *error_scores("ground_z0", ground_plane_errors(recording, seen)),
        *stage_scores(split(recording, seen)),
        *anchor_scores("anchor", np.concatenate([np.empty((0, 2)), *(one.errors_px for _, one in seen)])),
        *track_scores("track", fused, gate),
        *latency_scores("track", cameras, recording.manifest.true_cameras),
        *direction_scores(recording, gate),
        *contact_scores(recording),
        *(
            one
            for camera, (_, sighting) in zip(cameras, seen, strict=True)
            for one in _of_camera(camera, sighting, gate)
        ),
        *calibration_scores(recording.manifest, names),
    )


def _of_camera(camera: Population, sighting: Sightings, gate_m: float) -> list[Score]:
    name = camera.source
    return [
        *detection_scores(f"detection.{name}", [camera]),
        *error_scores(f"ground.{name}", camera.hits.errors_m),
        *consistency_scores(f"ground.{name}", camera.hits),
        *anchor_scores(f"anchor.{name}", sighting.errors_px),
        *track_scores(f"track.{name}", camera, gate_m),
    ]
