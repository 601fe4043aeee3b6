"""Histogram back-projection: finds in the whole image the vehicle of each colour.

The chain is that of Swain and Ballard (1991, eq. 3 and 4): ratio histogram R = min(M / I, 1) on hue and saturation,
back-projected, summed over a square of the object's area (paper R: a disc); then threshold, closing, contour, rotated
box, and gates on area, side ratio and rectangularity. It runs twice: on every few pixels of the whole frame to propose
windows, then at full resolution inside them, where the roof is measured.
"""

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from contracts import Camera, Detections, FloatArray, Frame, ImageArray
from perception.anchor import Anchor, find_anchor
from perception.colour_models import SHIPPED, ColourModel, ColourModels
from perception.hue_saturation import back_projection, histogram, hue_saturation_value, ratio_histogram
from perception.model_views import ModelViews
from perception.silhouette import Silhouette, silhouette_at
from perception.track_bed import TrackBeds
from perception.view import RoofView

PROPOSALS = 3  # windows looked at per colour before giving up
DENSITY_MIN = 0.25  # share of the square that must have the colour
CELLS_ACROSS = 4.5  # the roof's short side covers at least so many cells of the coarse image


class HistogramBackProjection:
    """Detector: at most one vehicle per colour and frame; keeps no state.

    models: what to look for; those shipped with the package if none are given.
    camera: whose frames they will be, as well as it is known; if none is given, one like that of the training.
    beds: where vehicles can be; anywhere if not known.
    """

    def __init__(
        self, models: ColourModels | None = None, camera: Camera | None = None, beds: TrackBeds | None = None
    ) -> None:
        self._models = models or ColourModels.load(SHIPPED)
        self._views = ModelViews(self._models, camera)
        self._beds = beds

    def reset(self) -> None:
        """Nothing to forget."""

    def detect(self, frame: Frame) -> Detections:
        """At most one detection per model, in the models' order."""
        found = []
        for model, view, outlines in self._outlines(frame.image):
            anchors = (find_anchor(frame.image, outline, model, view) for outline in outlines)
            anchor = next((each for each in anchors if self._beds is None or self._beds.bear(each, model)), None)
            if anchor is not None:
                found.append((model, anchor))
        return detections_of(frame, found)

    def silhouettes(self, image: ImageArray) -> dict[str, Silhouette]:
        """The outline of each vehicle that is found in an image (H, W, 3), by its label."""
        return {model.label: outlines[0] for model, _, outlines in self._outlines(image)}

    def _outlines(self, image: ImageArray) -> Iterator[tuple[ColourModel, RoofView, list[Silhouette]]]:
        """Of each model that is found, the outlines that may be it, the largest first."""
        views = self._views.of(image)
        middle = np.array(image.shape[1::-1]) / 2
        scale = min(view.at(middle).px_per_m for view in views)
        stride = max(1, int(min(model.roof_size_m[1] for model in self._models.models) * scale / CELLS_ACROSS))
        coarse = hue_saturation_value(_every(stride, image))
        image_histogram = histogram(coarse) * stride**2
        for model, view in zip(self._models.models, views, strict=True):
            size_px = np.array(model.roof_size_m) * scale
            ratio = ratio_histogram(model.histogram * float(np.prod(size_px)), image_histogram)
            peaks_px = [peak * stride for peak in _peaks(back_projection(coarse, ratio), size_px / stride)]
            outlines = [silhouette_at(image, peak_px, ratio, model, view.at(peak_px)) for peak_px in peaks_px]
            passed = [outline for outline in outlines if outline is not None]
            if passed:
                yield model, view, sorted(passed, key=lambda outline: outline.area_px, reverse=True)


def _every(stride: int, image: ImageArray) -> ImageArray:
    """(H // s, W // s, 3) every so-manyth row and column."""
    rows, columns = max(image.shape[0] // stride, 1), max(image.shape[1] // stride, 1)
    cropped = image[: rows * stride, : columns * stride]
    return np.asarray(cv2.resize(cropped, (columns, rows), interpolation=cv2.INTER_NEAREST), np.uint8)


def _peaks(likelihood: ImageArray, size: FloatArray) -> list[FloatArray]:
    """Places (column, row) where a square of the vehicle's area is best filled with its colour, best first.

    size: (2,) of the roof, in cells of ``likelihood``. Paper R takes a disc; a square's sum costs the same however
    large it is, and the window that a peak proposes is larger than what the two differ by.
    """
    side = max(1, round(float(np.sqrt(np.prod(size)))))
    density = cv2.boxFilter(likelihood, cv2.CV_32F, (side, side), borderType=cv2.BORDER_CONSTANT)
    peaks: list[FloatArray] = []
    for _ in range(PROPOSALS):
        _, value, _, (column, row) = cv2.minMaxLoc(density)
        if value < DENSITY_MIN * 255:
            break
        peaks.append(np.array([column, row], np.float64))
        cv2.circle(density, (column, row), round(1.2 * side), 0.0, thickness=-1)
    return peaks


def detections_of(frame: Frame, found: Sequence[tuple[ColourModel, Anchor]]) -> Detections:
    """One detection per model and anchor, scored by the share of the roof that was seen."""
    if not found:
        return Detections.empty(frame.camera, frame.index, frame.time_ns)
    quads = np.array([anchor.quad_px for _, anchor in found])  # (N, 4, 2)
    return Detections(
        frame.camera,
        frame.index,
        frame.time_ns,
        tuple(model.label for model, _ in found),
        np.array([anchor.visible for _, anchor in found]),
        np.concatenate([quads.min(axis=1), quads.max(axis=1)], axis=1),
        quads,
        np.array([anchor.point_px for _, anchor in found]),
        np.array([model.roof_height_m for model, _ in found]),
        np.array([anchor.cov_px2 for _, anchor in found]),
    )
