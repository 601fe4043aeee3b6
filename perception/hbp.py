"""Histogram back-projection: finds in the whole image the vehicle of each colour.

The chain is that of Swain and Ballard (1991, eq. 3 and 4): ratio histogram R = min(M / I, 1) on hue and saturation,
back-projected, convolved with a disc of the object's area; then threshold, closing, dilation, contour, rotated box, and
gates on area, side ratio and rectangularity. It runs twice: on every few pixels of the whole frame to propose
windows, then at full resolution inside them.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from contracts import Detections, FloatArray, Frame, ImageArray
from perception.colour_models import ColourModel, ColourModels
from perception.hue_saturation import back_projection, histogram, hue_saturation_value

PROPOSALS = 3  # windows looked at per colour before giving up
DENSITY_MIN = 0.25  # share of the disc that must have the colour
MEMBER_MIN = 0.2  # ratio from which a pixel belongs to the vehicle
CELLS_ACROSS = 6.0  # the roof's short side covers at least so many cells of the coarse image


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A vehicle's outline, roof and visible walls alike.

    contour_px: (N, 2) outer contour, in pixels of the whole image.
    area_px: pixels inside.
    rectangle: centre (u, v), size and angle in degrees of the smallest rotated rectangle, OpenCV's form.
    """

    contour_px: FloatArray
    area_px: float
    rectangle: tuple[tuple[float, float], tuple[float, float], float]

    @property
    def quad_px(self) -> FloatArray:
        """(4, 2) corners of the smallest rotated rectangle, in order round it."""
        return np.asarray(cv2.boxPoints(self.rectangle), np.float64)

    @property
    def rectangularity(self) -> float:
        """Area over that of the smallest rotated rectangle (Podczeck 1997)."""
        width, height = self.rectangle[1]
        return min(1.0, self.area_px / max(width * height, 1.0))

    @property
    def side_ratio(self) -> float:
        """Short over long side of the smallest rotated rectangle."""
        width, height = self.rectangle[1]
        return min(width, height) / max(width, height, 1.0)


class HistogramBackProjection:
    """Detector: at most one vehicle per colour and frame; keeps no state."""

    def __init__(self, models: ColourModels) -> None:
        self._models = models.models
        shortest = min(min(model.roof_size_px) for model in self._models)
        self._stride = max(1, int(shortest / CELLS_ACROSS))

    def reset(self) -> None:
        """Nothing to forget."""

    def detect(self, frame: Frame) -> Detections:
        """At most one detection per model, in the models' order."""
        image = frame.image
        coarse = hue_saturation_value(image[:: self._stride, :: self._stride].copy())
        image_histogram = histogram(coarse) * self._stride**2
        found = []
        for model in self._models:
            ratio = ratio_histogram(model, image_histogram)
            silhouettes = [
                silhouette
                for peak_px in self._proposals_px(back_projection(coarse, ratio), model)
                if (silhouette := silhouette_at(image, peak_px, ratio, model)) is not None
            ]
            if silhouettes:
                found.append((model, max(silhouettes, key=lambda s: s.area_px)))
        return _detections(frame, found)

    def _proposals_px(self, likelihood: ImageArray, model: ColourModel) -> list[FloatArray]:
        """Places (u, v) where a disc of the vehicle's area is best filled with its colour, best first."""
        radius = float(np.sqrt(np.prod(model.roof_size_px) / np.pi)) / self._stride
        density = cv2.filter2D(likelihood, cv2.CV_32F, disc(radius), borderType=cv2.BORDER_CONSTANT)
        peaks: list[FloatArray] = []
        for _ in range(PROPOSALS):
            _, value, _, (column, row) = cv2.minMaxLoc(density)
            if value < DENSITY_MIN * 255:
                break
            peaks.append(np.array([column, row], np.float64) * self._stride)
            cv2.circle(density, (column, row), round(2 * radius), 0.0, thickness=-1)
        return peaks


def ratio_histogram(model: ColourModel, image_histogram: FloatArray) -> FloatArray:
    """R = min(M / I, 1): how sure a pixel of each bin belongs to the vehicle. Swain and Ballard 1991, eq. 3."""
    return np.asarray(np.minimum(model.histogram / np.maximum(image_histogram, 1.0), 1.0))


def disc(radius: float) -> FloatArray:
    """A disc of ones over its area, as a kernel; (2 r + 1, 2 r + 1)."""
    reach = int(np.ceil(radius))
    x, y = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    inside = (x**2 + y**2 <= radius**2).astype(np.float64)
    return np.asarray(inside / inside.sum())


def silhouette_at(image: ImageArray, near_px: FloatArray, ratio: FloatArray, model: ColourModel) -> Silhouette | None:
    """The vehicle's outline in the full-resolution window round ``near_px`` (u, v), if one passes the gates."""
    reach = 1.5 * max(model.roof_size_px)
    low = np.maximum(np.floor(near_px - reach), 0).astype(int)
    high = np.ceil(near_px + reach + 1).astype(int)
    window = image[low[1] : high[1], low[0] : high[0]].copy()
    mask = (back_projection(hue_saturation_value(window), ratio) > MEMBER_MIN * 255).astype(np.uint8)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5))
    mask = np.asarray(cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel), cv2.MORPH_CLOSE, kernel))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    contour = max(contours, key=cv2.contourArea)
    filled = np.zeros_like(mask)
    cv2.drawContours(filled, [contour], 0, 1, thickness=-1)
    points = contour[:, 0, :].astype(np.float64) + low  # (N, 2)
    (u, v), (width, height), angle_deg = cv2.minAreaRect(points.astype(np.float32))
    silhouette = Silhouette(points, float(filled.sum()), ((u, v), (width + 1, height + 1), angle_deg))
    return silhouette if _passes(silhouette, model) else None


def _passes(silhouette: Silhouette, model: ColourModel) -> bool:
    return (
        model.area_px[0] <= silhouette.area_px <= model.area_px[1]
        and model.side_ratio[0] <= silhouette.side_ratio <= model.side_ratio[1]
        and silhouette.rectangularity >= model.rectangularity_min
    )


def _detections(frame: Frame, found: list[tuple[ColourModel, Silhouette]]) -> Detections:
    if not found:
        return Detections.empty(frame.camera, frame.index, frame.time_ns)
    quads = np.array([silhouette.quad_px for _, silhouette in found])  # (N, 4, 2)
    return Detections(
        frame.camera,
        frame.index,
        frame.time_ns,
        tuple(model.label for model, _ in found),
        np.array([silhouette.rectangularity for _, silhouette in found]),
        np.concatenate([quads.min(axis=1), quads.max(axis=1)], axis=1),
        quads,
        quads.mean(axis=1),
        np.array([model.roof_height_m for model, _ in found]),
        np.array([np.eye(2) * max(model.anchor_moments_px2["whole"]) for model, _ in found]),
    )
