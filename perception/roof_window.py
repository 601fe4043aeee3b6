r"""The window round a roof, turned so that the roof lies straight in it, and the profiles across its four sides.

::

              -------- side 0 --------
             |          |             |        u along the long axis, v along the short one; a side's mean
      side 3 |  before  |   after     | side 1          colours are its profile, read outwards; each half of a long
             |          |             |                 side has one of its own
              -------- side 2 --------
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray, ImageArray
from perception.roof import REACH_PX, SIDE_SHARE

SAMPLES = int(2 * REACH_PX + 1)
SIDE_OF_ROW = np.array([0, 0, 1, 2, 2, 3])  # the rows of ``Profiles``: the long sides before and after their middle
MARGIN_PX = 3.0  # of image that must be there beyond each side
LEAST_MARGIN_PX = 1.0  # the same, when the roof was cut to keep that margin and then moved a little
OPPOSITE = np.array([2, 3, 0, 1])
FORTH, BACK = np.array([1, 2]), np.array([3, 0])  # the sides at the ends of the long and the short axis
_CORNERS = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
_SAMPLING = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP


@dataclass(frozen=True, eq=False)
class RoofPose:
    """A rectangle in the image: centre (2,), unit vectors (2, 2) along its long and short axis, its size (2,)."""

    centre_px: FloatArray
    axes: FloatArray
    size_px: FloatArray

    @classmethod
    def of(cls, quad_px: FloatArray) -> "RoofPose":
        """The rectangle nearest to corners (4, 2) in order round it, the first side a long one."""
        along = quad_px[1] + quad_px[2] - quad_px[0] - quad_px[3]
        across = quad_px[2] + quad_px[3] - quad_px[0] - quad_px[1]
        length = float(np.hypot(*along))
        u = along / length
        v = np.array([-u[1], u[0]])
        side = float(across @ v)
        size = np.array([length, abs(side)]) / 2
        return cls(quad_px.mean(axis=0), np.array([u, v if side > 0 else -v]), size)

    @property
    def angle_rad(self) -> float:
        """Of the long axis, from the image's u towards its v."""
        return float(np.arctan2(self.axes[0, 1], self.axes[0, 0]))

    @property
    def corners_px(self) -> FloatArray:
        """(4, 2) in order round it, the first side a long one."""
        return np.asarray(self.centre_px + (_CORNERS * self.size_px) @ self.axes)

    def inside(self, image: ImageArray, hidden: BoolArray | None = None) -> bool:
        """Whether all of it lies in the image, with a margin beyond the sides that are not ``hidden`` (4,)."""
        if hidden is not None and hidden.any():
            margins = np.where(hidden, 0.0, LEAST_MARGIN_PX)
            corners = self.cut(-self.size_px / 2 - margins[BACK], self.size_px / 2 + margins[FORTH]).corners_px
            return bool((corners > -0.5).all() and (corners < np.array(image.shape[1::-1]) - 0.5).all())
        reach_u, reach_v = (np.abs(self.axes) * self.size_px[:, None]).sum(axis=0).tolist()
        (u, v), (height, width) = self.centre_px.tolist(), image.shape[:2]
        reach_u, reach_v = reach_u / 2 + MARGIN_PX, reach_v / 2 + MARGIN_PX
        return bool(reach_u <= u <= width - 1 - reach_u and reach_v <= v <= height - 1 - reach_v)

    def moved(self, offset: FloatArray, turn_rad: float) -> "RoofPose":
        """Shifted by ``offset`` (2,) along its axes, then turned from the long towards the short axis."""
        cos, sin = math.cos(turn_rad), math.sin(turn_rad)
        turned = np.array([[cos, sin], [-sin, cos]]) @ self.axes
        return RoofPose(self.centre_px + offset @ self.axes, turned, self.size_px)

    def facing(self, other: "RoofPose") -> "RoofPose":
        """The same rectangle, its axes named and pointing as those of the other lie nearest."""
        across = abs(self.axes[0] @ other.axes[0]) < abs(self.axes[1] @ other.axes[0])
        axes, size_px = (self.axes[::-1], self.size_px[::-1]) if across else (self.axes, self.size_px)
        signs = np.where((axes * other.axes).sum(axis=1) < 0, -1.0, 1.0)
        return RoofPose(self.centre_px, signs[:, None] * axes, size_px)

    def displaced(self, by_px: FloatArray, turn_rad: float) -> "RoofPose":
        """Shifted by ``by_px`` (2,) in the image, and turned from the image's u towards its v."""
        cos, sin = math.cos(turn_rad), math.sin(turn_rad)
        turned = self.axes @ np.array([[cos, sin], [-sin, cos]])
        return RoofPose(self.centre_px + by_px, turned, self.size_px)

    def cut(self, low: FloatArray, high: FloatArray) -> "RoofPose":
        """From ``low`` to ``high`` (2,) along its axes, counted from its middle."""
        return RoofPose(self.centre_px + (low + high) / 2 @ self.axes, self.axes, high - low)

    def completed(self, size_px: FloatArray, hidden: BoolArray) -> "RoofPose":
        """As large as ``size_px`` (2,) where one end of an axis is ``hidden`` (4,): it goes on beyond that end."""
        missing = np.where(hidden[FORTH] | hidden[BACK], size_px - self.size_px, 0.0)
        return self.cut(
            -self.size_px / 2 - np.where(hidden[BACK], missing, 0.0),
            self.size_px / 2 + np.where(hidden[FORTH], missing, 0.0),
        )

    def resized(self, by_px: FloatArray) -> "RoofPose":
        """Larger by ``by_px`` (2,)."""
        return RoofPose(self.centre_px, self.axes, self.size_px + by_px)


@dataclass(frozen=True, eq=False)
class WindowPlan:
    """How a roof of one size is cut out; the same for all frames.

    size_px: (2,) of the roof. half_px: (2,) pixels from the window's middle to its border.
    t_px: (6, T) offsets of the profiles' samples, outwards from where the side should be.
    apart_px: between the middles of a long side's halves.
    """

    size_px: FloatArray
    half_px: tuple[int, int]
    long_px: tuple[int, int]
    short_px: tuple[int, int]
    t_px: FloatArray
    apart_px: float

    @classmethod
    def of(cls, size_px: FloatArray) -> "WindowPlan":
        """For a roof of ``size_px`` (2,), long and short."""
        half = np.floor(size_px / 2 + REACH_PX).astype(int)
        reach = np.maximum((SIDE_SHARE * size_px / 2).astype(int), 1)
        first = half - size_px / 2 - SAMPLES + 1  # (2,) of the samples across the short and the long sides
        t_px = first[[1, 1, 0, 1, 1, 0]][:, None] + np.arange(SAMPLES)
        (left, top), (right, bottom) = (half - reach).tolist(), (half + reach + 1).tolist()
        return cls(size_px, (int(half[0]), int(half[1])), (left, right), (top, bottom), t_px, float(reach[0] + 1))

    def profiles(self, image: ImageArray, pose: RoofPose) -> NDArray[np.float32]:
        """(6, T, 3) mean BGR outwards across the sides, in the order of ``SIDE_OF_ROW``."""
        (right, bottom), n = self.half_px, SAMPLES
        origin = pose.centre_px - np.array(self.half_px, np.float64) @ pose.axes
        from_window = np.column_stack([pose.axes.T, origin])
        window = cv2.warpAffine(image, from_window, (2 * right + 1, 2 * bottom + 1), flags=_SAMPLING)
        before = _mean(window[:, self.long_px[0] : right], 1)
        after = _mean(window[:, right + 1 : self.long_px[1]], 1)
        across = _mean(window[self.short_px[0] : self.short_px[1]], 0)
        rows = np.empty((6, n, 3), np.float32)
        rows[0], rows[1] = before[n - 1 :: -1], after[n - 1 :: -1]
        rows[3], rows[4] = before[-n:], after[-n:]
        rows[2], rows[5] = across[-n:], across[n - 1 :: -1]
        return rows


def _mean(pixels: MatLike, along: int) -> NDArray[np.float32]:
    return np.asarray(cv2.reduce(pixels, along, cv2.REDUCE_AVG, dtype=cv2.CV_32F), np.float32).reshape(-1, 3)
