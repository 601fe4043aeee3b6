"""Which stage caused the position error: the error of every hit of every camera, split into three parts that add up.

    anchor       true camera,       stated anchor at its stated height, minus the truth: what perception caused
    calibration  calibrated camera, true anchor at its true height, minus the truth: what calibration caused
    location     the rest: what the location did to both, and their (small) product

Rays are cast with OpenCV, not with the code under test, so that a fault in the location appears as its own part.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.recording import Recording
from bench.scores import Score
from bench.scoring.anchors import Sightings
from bench.scoring.ground import error_scores
from bench.scoring.rays import to_plane
from contracts import Camera, FloatArray
from georef.calibrated import CalibratedCamera


@dataclass(frozen=True, eq=False)
class StageErrors:
    """Parts of the position error in metres, (K, 2) each; their sum is the error of the camera's position."""

    anchor_m: FloatArray
    calibration_m: FloatArray
    location_m: FloatArray


def stage_errors(sightings: Sightings, true_camera: Camera, calibrated: CalibratedCamera) -> StageErrors:
    """Split the error of every sighting of one camera; NaN where its track was not recorded."""
    truths_m = sightings.hits.truths_m
    anchor_m = to_plane(true_camera, sightings.anchors_px, sightings.heights_m) - truths_m
    calibration_m = to_plane(calibrated.camera, sightings.true_anchors_px, sightings.true_heights_m) - truths_m
    return StageErrors(anchor_m, calibration_m, sightings.hits.errors_m - anchor_m - calibration_m)


def split(recording: Recording, seen: Sequence[tuple[str, Sightings]]) -> StageErrors:
    """The split of all cameras together, for those whose true and calibrated camera are both known."""
    true_cameras = {camera.name: camera for camera in recording.manifest.true_cameras}
    calibrated = {one.camera.name: one for one in recording.manifest.calibrated_cameras}
    parts = [
        stage_errors(sightings, true_cameras[name], calibrated[name])
        for name, sightings in seen
        if name in true_cameras and name in calibrated
    ]
    return StageErrors(
        anchor_m=_stacked([part.anchor_m for part in parts]),
        calibration_m=_stacked([part.calibration_m for part in parts]),
        location_m=_stacked([part.location_m for part in parts]),
    )


def stage_scores(errors: StageErrors) -> list[Score]:
    """The summaries of ``error_scores`` for each part."""
    return [
        *error_scores("stage.anchor", errors.anchor_m),
        *error_scores("stage.calibration", errors.calibration_m),
        *error_scores("stage.location", errors.location_m),
    ]


def _stacked(parts: list[FloatArray]) -> FloatArray:
    return np.concatenate([np.empty((0, 2)), *parts])
