"""The baselines' colours learned from frames whose vehicles are marked: what lies on the roofs, over all lights."""

from collections.abc import Iterable

import cv2
import numpy as np

from contracts import FloatArray, ImageArray, InputError
from perception.baselines.colour_ratio import component_ratios
from perception.baselines.colours import Bounds, PlainColour, PlainColours
from perception.baselines.mixture import fit_mixture, log_sum
from perception.hue_saturation import hue_saturation_value
from perception.learning import LEAST_VISIBLE, LabelledFrame

OUTSIDE = 0.01  # share of a roof's pixels left outside at each end of a range
COMPONENTS = 4
DENSITY_MARGIN = 2.3  # a pixel may be ten times rarer than the rarest that were learned from: lights vary on
PIXELS_OF_A_ROOF = 150  # that are learned from: every vehicle counts alike
INNER = 0.9  # of a roof's size: its rim mixes with what lies beside it
RATIO_STEP = 0.01  # by which a ratio of whole levels jumps from one level of light to the next
HUES = 180.0


def learn_colours(samples: Iterable[LabelledFrame]) -> PlainColours:
    """One colour per label, in alphabetical order.

    samples: frames with the vehicles that can be seen in them. Vehicles hidden or cut are not learned from.
    Raises InputError if no sample holds a whole vehicle.
    """
    pixels: dict[str, list[ImageArray]] = {}
    for sample in samples:
        for row in np.flatnonzero(sample.inside & (sample.visible_fractions >= LEAST_VISIBLE)).tolist():
            roof = roof_pixels(sample.frame.image, sample.roof_quads_px[row])
            pixels.setdefault(sample.labels[row], []).append(roof)
    if not pixels:
        raise InputError("learn: none of the samples holds a vehicle wholly inside its image")
    return PlainColours(tuple(plain_colour(label, np.concatenate(pixels[label])) for label in sorted(pixels)))


def roof_pixels(image: ImageArray, quad_px: FloatArray) -> ImageArray:
    """(P, 3) BGR pixels within a roof of corners ``quad_px`` (4, 2), evenly thinned to ``PIXELS_OF_A_ROOF``."""
    inner = quad_px.mean(axis=0) + INNER * (quad_px - quad_px.mean(axis=0))
    mask = np.zeros(image.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, np.round(inner).astype(np.int32), 1)
    inside: ImageArray = np.asarray(image[mask > 0], np.uint8)  # (all, 3)
    thinned: ImageArray = inside[np.linspace(0, len(inside) - 1, min(PIXELS_OF_A_ROOF, len(inside))).astype(int)]
    return thinned


def plain_colour(label: str, pixels: ImageArray) -> PlainColour:
    """The colour of ``pixels`` (P, 3), BGR, in all three descriptions."""
    row = pixels[None]  # an image of one row
    mixture = fit_mixture(pixels.astype(np.float64), COMPONENTS)
    densities = log_sum(mixture.log_densities(pixels.astype(np.float64)))
    return PlainColour(
        label,
        hsv=_hsv_bounds(hue_saturation_value(row)[0].astype(np.float64)),
        ratios=_ratio_bounds(component_ratios(row)[0].astype(np.float64)),
        mixture=mixture,
        density_min=float(np.quantile(densities, OUTSIDE)) - DENSITY_MARGIN,
    )


def _hsv_bounds(hsv: FloatArray) -> Bounds:
    """Quantiles about the circular mean of the hue, which may run across 0."""
    angle = hsv[:, 0] * (2 * np.pi / HUES)
    middle = np.arctan2(np.sin(angle).sum(), np.cos(angle).sum()) * (HUES / (2 * np.pi))
    unrolled = hsv.copy()
    unrolled[:, 0] = middle + (hsv[:, 0] - middle + HUES / 2) % HUES - HUES / 2
    bounds = _bounds(unrolled)
    low, high = np.floor(bounds.low), np.ceil(bounds.high)
    low[0], high[0] = low[0] % HUES, high[0] % HUES
    return Bounds(low, high)


def _ratio_bounds(ratios: FloatArray) -> Bounds:
    bounds = _bounds(ratios)
    return Bounds(bounds.low * (1 - RATIO_STEP), bounds.high * (1 + RATIO_STEP))


def _bounds(values: FloatArray) -> Bounds:
    low, high = np.quantile(values, (OUTSIDE, 1 - OUTSIDE), axis=0)
    return Bounds(low, high)
