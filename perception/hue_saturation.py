"""Hue-saturation histograms: the one place that says how colours are binned.

Hue and saturation do not change when light and paint merely scale, so a shaded wall has the bins of its roof.
"""

import cv2
import numpy as np

from contracts import FloatArray, ImageArray

HUE_BINS = 90  # 4 degrees of hue each
SATURATION_BINS = 32
SHAPE = (HUE_BINS, SATURATION_BINS)
_CHANNELS = (0, 1)
_RANGES = (0.0, 180.0, 0.0, 256.0)  # OpenCV's 8-bit hue counts half degrees
_FULL_SCALE = 255.0


def hue_saturation_value(image: ImageArray) -> ImageArray:
    """(H, W, 3) BGR -> (H, W, 3) OpenCV's 8-bit hue, saturation, value."""
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), np.uint8)


def histogram(hsv: ImageArray, mask: ImageArray | None = None) -> FloatArray:
    """Pixels per bin, (HUE_BINS, SATURATION_BINS); only where ``mask`` (H, W) uint8 is not 0, if one is given."""
    return cv2.calcHist([hsv], _CHANNELS, mask, SHAPE, _RANGES).astype(np.float64)


def back_projection(hsv: ImageArray, ratio: FloatArray) -> ImageArray:
    """Each pixel replaced by the value of its bin in ``ratio``, (H, W) uint8; 1 becomes 255.

    ratio: (HUE_BINS, SATURATION_BINS) in [0, 1].
    """
    lookup = np.asarray(ratio * _FULL_SCALE, np.float32)
    return np.asarray(cv2.calcBackProject([hsv], _CHANNELS, lookup, _RANGES, 1.0), np.uint8)


def widened(counts: FloatArray) -> FloatArray:
    """``counts`` with each bin raised to the largest of its neighbours; hue is a circle."""
    wrapped = np.concatenate([counts[-1:], counts, counts[:1]])
    return np.asarray(cv2.dilate(wrapped, np.ones((3, 3), np.uint8))[1:-1], np.float64)


def ratio_histogram(model: FloatArray, image: FloatArray) -> FloatArray:
    """R = min(M / I, 1): how sure a pixel of each bin belongs to the object. Swain and Ballard 1991, eq. 3."""
    return np.asarray(np.minimum(model / np.maximum(image, 1.0), 1.0))
