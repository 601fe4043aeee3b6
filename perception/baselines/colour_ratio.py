"""Colour component ratio (CCR of paper R): the ratios between blue, green and red each within limits.

Ratios do not change when light and paint merely scale.
"""

import numpy as np
from numpy.typing import NDArray

from contracts import ImageArray
from perception.baselines.colour_range import within
from perception.baselines.mask_detector import MaskDetector


class ColourRatio(MaskDetector):
    """Detector: a pixel has a vehicle's colour if all three ratios of its components lie in the learned range."""

    def masks(self, image: ImageArray) -> tuple[ImageArray, ...]:
        """(H, W) uint8 per colour, 1 where a pixel has it; nothing filled."""
        ratios = component_ratios(image)
        return tuple(within(ratios, colour.ratios.low, colour.ratios.high) for colour in self.colours)


def component_ratios(image: ImageArray) -> NDArray[np.float32]:
    """(H, W, 3) of BGR (H, W, 3): G / B, R / G and B / R, each component raised by one level, so that none is 0."""
    levels = image.astype(np.float32) + 1
    return np.asarray(levels[..., (1, 2, 0)] / levels)
