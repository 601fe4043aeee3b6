"""Centre errors and overlaps in the image, as tracking papers plot them (Babenko et al. 2011; Wu, Lim & Yang 2013).

Every vehicle that must be found in a frame of a camera is one case, whether it was found or not. It is sought by its
label: a vehicle tracked under another's name is lost.
"""

from dataclasses import dataclass

import numpy as np
from shapely import MultiPoint

from bench.matching import is_target
from bench.recording import Recording
from bench.roofs import roof_quads_px
from contracts import FloatArray, Tracks
from contracts.truth import CameraTruth

AT_PX = 20.0  # the threshold at which precision plots are usually summarised
OVERLAP_STEPS = np.linspace(0.0, 1.0, 101)
DISTANCE_STEPS_PX = np.geomspace(0.02, 50.0, 120)


@dataclass(frozen=True, eq=False)
class Cases:
    """N cases. distances_px: (N,) of the centres of the roofs, infinite where lost. overlaps: (N,) of the roofs."""

    distances_px: FloatArray
    overlaps: FloatArray

    def __len__(self) -> int:
        return len(self.distances_px)

    def precision(self, thresholds_px: FloatArray) -> FloatArray:
        """Share of the cases whose centre lies within each threshold."""
        return np.asarray((self.distances_px[:, None] <= thresholds_px).mean(axis=0))

    def success(self, thresholds: FloatArray) -> FloatArray:
        """Share of the cases that overlap by more than each threshold."""
        return np.asarray((self.overlaps[:, None] > thresholds).mean(axis=0))


def cases(recording: Recording) -> Cases:
    """All cases of a run whose frames were filmed."""
    cameras = {camera.name: camera for camera in recording.manifest.true_cameras}
    rows = []
    for truth, tracks in [(step.truth, step.tracks) for step in recording.steps if step.truth is not None]:
        seen = {one.objects.camera: one for one in tracks}
        for view in truth.cameras:
            quads_px = roof_quads_px(truth, cameras[view.camera])
            for row in np.flatnonzero(is_target(view.visible_fractions)).tolist():
                rows.append(_case(seen[view.camera], truth.labels[row], view, row, quads_px[row]))
    table = np.array(rows).reshape(-1, 2)
    return Cases(table[:, 0], table[:, 1])


def together(parts: list[Cases]) -> Cases:
    """All cases of several runs."""
    return Cases(
        np.concatenate([np.empty(0), *(part.distances_px for part in parts)]),
        np.concatenate([np.empty(0), *(part.overlaps for part in parts)]),
    )


def _case(tracks: Tracks, label: str, view: CameraTruth, row: int, quad_px: FloatArray) -> tuple[float, float]:
    best = (np.inf, 0.0)
    for k, name in enumerate(tracks.objects.labels):
        if name == label:
            distance_px = float(np.linalg.norm(tracks.objects.anchors_px[k] - view.roofs_px[row]))
            best = min(best, (distance_px, quad_overlap(tracks.objects.quads_px[k], quad_px)))
    return best


def quad_overlap(a_px: FloatArray, b_px: FloatArray) -> float:
    """Area of both convex quadrangles (4, 2) over area of either.

    With shapely: OpenCV 5.0's intersectConvexConvex loses area where edges nearly coincide.
    """
    a, b = MultiPoint(a_px).convex_hull, MultiPoint(b_px).convex_hull
    either = float(a.union(b).area)
    return float(a.intersection(b).area) / either if either > 0 else 0.0
