"""The rail paper's projection, shown beside: every anchor taken to lie on the ground; same tracks, same cameras."""

from collections.abc import Sequence

import numpy as np

from bench.recording import Recording
from bench.scoring.anchors import Sightings
from contracts import FloatArray
from georef.location import on_plane


def ground_plane_errors(recording: Recording, seen: Sequence[tuple[str, Sightings]]) -> FloatArray:
    """Errors (K, 2) that the hits of all cameras would have had with z = 0, metres.

    seen: the sightings of each camera by name; cameras without a calibration are left out.
    The hits are those of the run itself: the naive position is compared with the object that the track was matched to,
    however far off it is. NaN where the track was not recorded.
    """
    calibrated = {one.camera.name: one.camera for one in recording.manifest.calibrated_cameras}
    errors = [
        on_plane(calibrated[name], sightings.anchors_px, 0.0)[0][:, :2] - sightings.hits.truths_m
        for name, sightings in seen
        if name in calibrated
    ]
    return np.concatenate([np.empty((0, 2)), *errors])
