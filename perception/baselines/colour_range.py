"""Colour range detection (CRD of paper R): hue, saturation and value each within limits."""

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, ImageArray
from perception.baselines.colours import Bounds
from perception.baselines.mask_detector import MaskDetector
from perception.hue_saturation import hue_saturation_value

LAST_HUE = 179.0  # of OpenCV's 8-bit hue


class ColourRange(MaskDetector):
    """Detector: a pixel has a vehicle's colour if hue, saturation and value lie in its learned range."""

    def masks(self, image: ImageArray) -> tuple[ImageArray, ...]:
        """(H, W) uint8 per colour, 1 where a pixel has it; nothing filled."""
        hsv = hue_saturation_value(image)
        return tuple(in_hsv_range(hsv, colour.hsv) for colour in self.colours)


def in_hsv_range(hsv: ImageArray, bounds: Bounds) -> ImageArray:
    """1 where ``hsv`` (H, W, 3) lies within ``bounds``, whose hue may run across 0; (H, W) uint8."""
    low, high = bounds.low, bounds.high
    if low[0] <= high[0]:
        return within(hsv, low, high)
    upper = within(hsv, low, np.array([LAST_HUE, *high[1:]]))
    return upper | within(hsv, np.array([0.0, *low[1:]]), high)


def within(image: NDArray[np.uint8] | NDArray[np.float32], low: FloatArray, high: FloatArray) -> ImageArray:
    """1 where all three channels of ``image`` (H, W, 3) lie between ``low`` and ``high`` (3,); (H, W) uint8."""
    inside = np.asarray(cv2.inRange(image, (*low.tolist(), 0.0), (*high.tolist(), 0.0)), np.uint8)  # 255 for yes
    return inside & np.uint8(1)
