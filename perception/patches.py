"""Windows cut out of an image at any centre and angle, ready to be correlated."""

import math
from dataclasses import dataclass

import cv2
import numpy as np

from contracts import FloatArray, ImageArray
from perception.correlation import Float32Array

_SPARE = 2  # interpolation looks one pixel beyond


@dataclass(frozen=True)
class WindowShape:
    """A rotated window of evenly spaced samples.

    samples: (H, W), even, products of small primes so that transforms are fast.
    step_px: distance of neighbouring samples, alike in both directions.
    """

    samples: tuple[int, int]
    step_px: float

    @classmethod
    def around(
        cls, size_px: tuple[float, float], *, padding: float, budget: int, multiple_of: int = 2
    ) -> "WindowShape":
        """A window ``padding`` times as long and as wide as a target, with about ``budget`` samples.

        size_px: (along, across). The image is not sampled finer than its pixels.
        multiple_of: of what number both sides are multiples; even.
        """
        length, width = size_px[0] * padding, size_px[1] * padding
        step = max(1.0, math.sqrt(length * width / budget))
        rows, columns = (multiple_of * _fast(side / step / multiple_of) for side in (width, length))
        return cls((rows, columns), step)

    @property
    def reach_px(self) -> float:
        """Distance of the corners from the centre."""
        return math.hypot(*self.samples) / 2 * self.step_px

    def distance(self, size_px: tuple[float, float]) -> FloatArray:
        """(H, W) 1 on the outline of a centred rectangle of ``size_px`` (along, across), 0 in the middle."""
        v, u = ((np.arange(n) - (n - 1) / 2) * self.step_px for n in self.samples)
        return np.asarray(np.maximum(np.abs(v[:, None]) / (size_px[1] / 2), np.abs(u) / (size_px[0] / 2)))


def _fast(least: float) -> int:
    """The next length of 2, 3 and 5 as prime factors, which transforms like."""
    return int(cv2.getOptimalDFTSize(max(2, round(least))))


@dataclass(frozen=True, eq=False)
class Crop:
    """An upright piece of an image, averaged over squares of pixels so that coarser sampling does not alias.

    pixels: (h, w, 3) uint8, BGR. origin_px: (u, v) of its first pixel's centre in the image.
    scale: image pixels per pixel of it. reach_px: all within so much of centre_px is in it, if it is in the image.
    """

    pixels: ImageArray
    origin_px: tuple[float, float]
    scale: int
    centre_px: tuple[float, float]
    reach_px: float

    @classmethod
    def around(cls, image: ImageArray, centre_px: FloatArray, reach_px: float, step_px: float) -> "Crop":
        """All within ``reach_px`` of ``centre_px`` (u, v) that the image (H, W, 3) holds, at least one pixel."""
        halvings = max(0, math.frexp(step_px)[1] - 1)  # repeatedly halving is many times faster than any other area
        scale = 2**halvings
        centre = float(centre_px[0]), float(centre_px[1])
        left, columns = _span(centre[0], reach_px, scale, image.shape[1])
        top, rows = _span(centre[1], reach_px, scale, image.shape[0])
        pixels = image[top : top + rows, left : left + columns]
        for _ in range(halvings):
            size = pixels.shape[1] // 2, pixels.shape[0] // 2
            pixels = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)
        offset = (scale - 1) / 2
        return cls(pixels, (left + offset, top + offset), scale, centre, reach_px)

    def covers(self, centre_px: FloatArray, reach_px: float) -> bool:
        """Whether all within ``reach_px`` of ``centre_px`` is in the crop, as far as it is in the image."""
        away = math.hypot(float(centre_px[0]) - self.centre_px[0], float(centre_px[1]) - self.centre_px[1])
        return away + reach_px <= self.reach_px

    def window(self, centre_px: FloatArray, angle_rad: float, shape: WindowShape) -> ImageArray:
        """(H, W, 3) uint8 samples; what lies outside the image repeats its border.

        centre_px: (u, v) of the middle, in the image. angle_rad: of the window's long way, from u towards v.
        """
        rows, columns = shape.samples
        step = shape.step_px / self.scale
        c, s = math.cos(angle_rad) * step, math.sin(angle_rad) * step
        u = (float(centre_px[0]) - self.origin_px[0]) / self.scale
        v = (float(centre_px[1]) - self.origin_px[1]) / self.scale
        i, j = (columns - 1) / 2, (rows - 1) / 2
        crop_from_window = np.array([[c, -s, u - c * i + s * j], [s, c, v - s * i - c * j]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = columns, rows
        window = cv2.warpAffine(self.pixels, crop_from_window, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(window, np.uint8)


def _span(centre: float, reach: float, scale: int, length: int) -> tuple[int, int]:
    """First pixel and number of pixels, a multiple of ``scale``, of what a row of ``length`` pixels holds.

    The first is a multiple of it too, so that the same pixels are averaged wherever the window is.
    """
    reach += _SPARE * scale
    first = min(max(math.floor((centre - reach) / scale) * scale, 0), max(length - scale, 0) // scale * scale)
    count = min(math.ceil(centre + reach) + 1, length) - first
    return first, max(count // scale, 1) * scale


def cosine_window(shape: tuple[int, int]) -> Float32Array:
    """(H, W) Hann's window: what wraps round in a cyclic shift fades out first."""
    v, u = (np.hanning(n + 2)[1:-1] for n in shape)
    return np.outer(v, u).astype(np.float32)


def to_image(shift: tuple[float, float], angle_rad: float, step_px: float) -> FloatArray:
    """(2,) displacement in the image, px, of a shift (u, v) in samples along a window's own axes."""
    c, s = math.cos(angle_rad) * step_px, math.sin(angle_rad) * step_px
    return np.array([c * shift[0] - s * shift[1], s * shift[0] + c * shift[1]])
