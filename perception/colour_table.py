"""Which vehicle's colour has a pixel? Answered by one look into a table of coarse colours, 32 steps to each channel."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray, ImageArray
from perception.colour_models import ColourModel
from perception.hue_saturation import HUE_BINS, SATURATION_BINS, hue_saturation_value

TYPICAL_SHARE = 0.02  # of a vehicle's pixels, that one of its typical bins gets under some light
_LEVELS = 32


def coarse_colours(image: ImageArray) -> NDArray[np.uint16]:
    """(H, W) each pixel's place in the table, from an image (H, W, 3) BGR."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2BGR555).view(np.uint16)[..., 0])


def typical_colours(model: ColourModel) -> BoolArray:
    """(32768,) whether each coarse colour is typical of the vehicle."""
    return np.asarray(_shares(model) >= TYPICAL_SHARE)


def distinctive_colours(models: Sequence[ColourModel]) -> BoolArray:
    """(M, 32768) whether each coarse colour is typical of a vehicle and of none more than of that one."""
    shares = np.array([_shares(model) for model in models])
    most = shares >= shares.max(axis=0)
    return np.asarray(most & np.array([typical_colours(model) for model in models]))


def _shares(model: ColourModel) -> FloatArray:
    """(32768,) what the model says of the bin of each coarse colour; OpenCV's order, red in the highest bits."""
    level = (np.arange(_LEVELS, dtype=np.uint8) << 3) + 4  # the middle of each step
    red, green, blue = np.meshgrid(level, level, level, indexing="ij")
    hsv = hue_saturation_value(np.stack([blue, green, red], axis=-1).reshape(1, -1, 3))[0].astype(np.intp)
    return np.asarray(model.histogram[hsv[:, 0] * HUE_BINS // 180, hsv[:, 1] * SATURATION_BINS // 256])
