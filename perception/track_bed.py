"""Where in the image a vehicle's roof can be, if it stands on its track: the plan of the track as a camera sees it.

A book of a vehicle's colour and size looks like one from above, but books lie beside the track. The plan only says what
may be a vehicle; where it is, the image alone says.
"""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from contracts import Camera, FloatArray
from georef.projection import project
from perception.anchor import Anchor
from perception.colour_models import ColourModel, ColourModels

BESIDE_M = 0.02  # a roof's middle is off the track by no more: the chord in a curve, the plan's and the camera's error
SIGMAS = 4.0  # of the anchor, on top
_STEP_M = 0.01  # over which the way along the track is projected


class TrackBed:
    """The track's middle, at the height of a vehicle's roof, as a camera sees it.

    centrelines_m: (N, 2) points along each piece of track, nearer to each other than a vehicle is wide.
    """

    def __init__(self, camera: Camera, centrelines_m: Sequence[FloatArray], height_m: float) -> None:
        points, tangents = zip(*(_in_view(camera, line_m, height_m) for line_m in centrelines_m), strict=True)
        self._points_px, self._by_metre = np.concatenate(points), np.concatenate(tangents)  # (N, 2), (N, 2)
        self._tree = cKDTree(self._points_px)

    def bears(self, anchor: Anchor) -> bool:
        """Whether an anchor, with the error that it states, is that of a roof on the track."""
        if not len(self._points_px):
            return False
        _, nearest = self._tree.query(anchor.point_px)
        by_metre = self._by_metre[nearest]
        scale = float(np.hypot(*by_metre))
        along = by_metre / scale
        axes = np.array([along, (-along[1], along[0])])
        off_px = np.abs(axes @ (anchor.point_px - self._points_px[nearest]))
        sigmas_px = np.sqrt(((axes @ anchor.cov_px2) * axes).sum(axis=1))
        return bool((off_px <= BESIDE_M * scale + SIGMAS * sigmas_px).all())


class TrackBeds:
    """The bed of every model's vehicle, before one camera."""

    def __init__(self, models: ColourModels, camera: Camera, centrelines_m: Sequence[FloatArray]) -> None:
        heights = {model.roof_height_m for model in models.models}
        self._beds = {height_m: TrackBed(camera, centrelines_m, height_m) for height_m in heights}

    def bear(self, anchor: Anchor, model: ColourModel) -> bool:
        """Whether an anchor can be that of a vehicle of this model."""
        return self._beds[model.roof_height_m].bears(anchor)


def _in_view(camera: Camera, line_m: FloatArray, height_m: float) -> tuple[FloatArray, FloatArray]:
    """The points of a line that lie before the camera, in pixels, and the way along it there, pixels per metre."""
    along_m = np.gradient(line_m, axis=0)
    along_m /= np.maximum(np.linalg.norm(along_m, axis=1, keepdims=True), 1e-9)
    ends_m = np.stack([line_m - along_m * _STEP_M / 2, line_m + along_m * _STEP_M / 2])  # (2, N, 2)
    ends_px, valid = project(camera, np.concatenate([ends_m, np.full((*ends_m.shape[:2], 1), height_m)], axis=2))
    seen = valid.all(axis=0)
    return ends_px.mean(axis=0)[seen], (ends_px[1] - ends_px[0])[seen] / _STEP_M
