"""A vehicle's outline at full resolution, and the shape gates of paper R's detector."""

from dataclasses import dataclass

import cv2
import numpy as np

from contracts import FloatArray, ImageArray, IntArray
from perception.colour_models import ColourModel
from perception.hue_saturation import back_projection, hue_saturation_value

MEMBER_MIN = 0.2  # ratio from which a pixel belongs to the vehicle
REACH = 1.5  # of the window round a proposal, in roof lengths
CLOSING_PX = 5


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A vehicle's outline, roof and visible walls alike.

    origin_px: (2,) place of the window's first pixel in the image.
    mask: (H, W) 1 inside the outline, in the window.
    rectangle: centre (u, v), size and angle in degrees of the smallest rotated rectangle, OpenCV's form; in the image.
    """

    origin_px: IntArray
    mask: ImageArray
    rectangle: tuple[tuple[float, float], tuple[float, float], float]

    @property
    def area_px(self) -> float:
        """Pixels inside."""
        return float(np.count_nonzero(self.mask))

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


def silhouette_at(image: ImageArray, near_px: FloatArray, ratio: FloatArray, model: ColourModel) -> Silhouette | None:
    """The vehicle's outline in the full-resolution window round ``near_px`` (u, v), if one passes the gates."""
    reach = REACH * max(model.roof_size_px)
    low = np.maximum(np.floor(near_px - reach), 0).astype(int)
    high = np.ceil(near_px + reach + 1).astype(int)
    window = image[low[1] : high[1], low[0] : high[0]].copy()
    mask = (back_projection(hue_saturation_value(window), ratio) > MEMBER_MIN * 255).astype(np.uint8)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSING_PX, CLOSING_PX))
    mask = np.asarray(cv2.morphologyEx(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel), cv2.MORPH_CLOSE, kernel))
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    contour = max(contours, key=cv2.contourArea)
    filled = np.zeros_like(mask)
    cv2.drawContours(filled, [contour], 0, 1, thickness=-1)
    (u, v), (width, height), angle_deg = cv2.minAreaRect(contour)
    rectangle = (u + float(low[0]), v + float(low[1])), (width + 1, height + 1), angle_deg  # pixels have a width
    silhouette = Silhouette(low, filled, rectangle)
    return silhouette if _passes(silhouette, model) else None


def _passes(silhouette: Silhouette, model: ColourModel) -> bool:
    return (
        model.area_px[0] <= silhouette.area_px <= model.area_px[1]
        and model.side_ratio[0] <= silhouette.side_ratio <= model.side_ratio[1]
        and silhouette.rectangularity >= model.rectangularity_min
    )
