"""A vehicle's outline at full resolution, and the shape gates of paper R's detector."""

from dataclasses import dataclass

import cv2
import numpy as np

from contracts import FloatArray, ImageArray, IntArray
from perception.colour_models import ColourModel
from perception.hue_saturation import back_projection, hue_saturation_value
from perception.view import LocalView

MEMBER_MIN = 0.2  # ratio from which a pixel belongs to the vehicle
REACH = 1.0  # of the window round a proposal, in roof lengths; walls lean farther
CLOSING_PX = 5
LEAST_PART = 0.5  # a vehicle hidden by so much is still looked for
MARGIN = 1.25  # a silhouette may be so much larger than a box that looks as big as the model says


@dataclass(frozen=True)
class ShapeGates:
    """What the outline of a vehicle may look like; every colour and every detector is held to the same ones.

    area_px: least and largest area inside the outline, in pixels.
    side_ratio: least and largest short / long side of its smallest rotated rectangle.
    fill_min: least area inside the outline over that of the rectangle.
    """

    area_px: tuple[float, float]
    side_ratio: tuple[float, float]
    fill_min: float

    @classmethod
    def at(cls, view: LocalView, model: ColourModel) -> "ShapeGates":
        """For a vehicle at a place of the image: from half a roof to a whole one and the walls that lean out of it."""
        long_px, short_px = (side_m * view.px_per_m for side_m in model.roof_size_m)
        lean_px = float(np.linalg.norm(view.lean_px))
        largest_px = long_px * short_px + lean_px * float(np.hypot(long_px, short_px))
        narrowest = min(short_px / (long_px + lean_px), long_px / (short_px + lean_px))
        area_px = LEAST_PART * long_px * short_px, MARGIN * largest_px
        return cls(area_px, (LEAST_PART * narrowest, 1.0), model.fill_min)

    def passes(self, silhouette: "Silhouette") -> bool:
        """Whether the outline can be a vehicle's."""
        return (
            self.area_px[0] <= silhouette.area_px <= self.area_px[1]
            and self.side_ratio[0] <= silhouette.side_ratio <= self.side_ratio[1]
            and silhouette.fill >= self.fill_min
        )


@dataclass(frozen=True, eq=False)
class Silhouette:
    """A vehicle's outline, roof and visible walls alike.

    origin_px: (2,) place of the window's first pixel in the image.
    mask: (H, W) 1 inside the outline, in the window.
    raw: (H, W) 1 where a pixel inside the outline had the vehicle's colour; nothing opened, closed or filled.
    rectangle: centre (u, v), size and angle in degrees of the smallest rotated rectangle, OpenCV's form; in the image.
    """

    origin_px: IntArray
    mask: ImageArray
    raw: ImageArray
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
        """Raw pixels over the area of the smallest rotated rectangle (Podczeck 1997): paper R's measure."""
        return self._share(float(np.count_nonzero(self.raw)))

    @property
    def fill(self) -> float:
        """Area inside the outline over that of the smallest rotated rectangle."""
        return self._share(self.area_px)

    @property
    def side_ratio(self) -> float:
        """Short over long side of the smallest rotated rectangle."""
        width, height = self.rectangle[1]
        return min(width, height) / max(width, height, 1.0)

    def _share(self, pixels: float) -> float:
        width, height = self.rectangle[1]
        return min(1.0, pixels / max(width * height, 1.0))


def silhouette_in(raw: ImageArray, origin_px: IntArray, gates: ShapeGates) -> Silhouette | None:
    """The largest patch of ``raw`` after opening and closing, if it passes the gates: paper R's post-processing.

    raw: (H, W) uint8, 1 where a pixel has the vehicle's colour and 0 elsewhere, in a window or the whole image.
    origin_px: (2,) place (u, v) of the window's first pixel in the image.
    """
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSING_PX, CLOSING_PX))
    tidy = cv2.morphologyEx(cv2.morphologyEx(raw, cv2.MORPH_OPEN, kernel), cv2.MORPH_CLOSE, kernel)
    contours, _ = cv2.findContours(tidy, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    contour = max(contours, key=cv2.contourArea)
    filled = np.zeros_like(raw)
    cv2.drawContours(filled, [contour], 0, 1, thickness=-1)
    (u, v), (width, height), angle_deg = cv2.minAreaRect(contour)
    place = u + float(origin_px[0]), v + float(origin_px[1])
    silhouette = Silhouette(origin_px, filled, raw & filled, (place, (width + 1, height + 1), angle_deg))
    return silhouette if gates.passes(silhouette) else None


def silhouette_at(
    image: ImageArray, near_px: FloatArray, ratio: FloatArray, model: ColourModel, view: LocalView
) -> Silhouette | None:
    """The vehicle's outline in the full-resolution window round ``near_px`` (u, v), if one passes the gates."""
    reach = REACH * model.roof_size_m[0] * view.px_per_m + float(np.abs(view.lean_px).max())
    low = np.maximum(np.floor(near_px - reach), 0).astype(int)
    high = np.ceil(near_px + reach + 1).astype(int)
    window = image[low[1] : high[1], low[0] : high[0]].copy()
    raw = (back_projection(hue_saturation_value(window), ratio) > MEMBER_MIN * 255).astype(np.uint8)
    return silhouette_in(raw, low, ShapeGates.at(view, model))
