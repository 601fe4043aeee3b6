"""Highlights: a far lamp mirrored in all that lies level, floor and roofs alike.

Where a level surface mirrors a far lamp into the camera is decided by the pixel's ray alone, not by the place of the
surface: a highlight stands still in the picture, and what passes beneath it shines up. So it is one picture per camera,
added to each frame, whatever drew that.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contracts import Camera, FloatArray, ImageArray, InputError
from sim.shade import world_points


@dataclass(frozen=True)
class HighlightSpec:
    """The mirror image of a far lamp.

    azimuth_deg, elevation_deg: where the lamp is; azimuth counter-clockwise from east. The highlight lies on the ground
        at ``height / tan(elevation)`` from the foot of the camera, towards the lamp.
    width_deg: standard deviation of its bell shape, as an angle of view.
    strength: what it adds in its middle, 1 for white.
    """

    azimuth_deg: float
    elevation_deg: float
    width_deg: float = 1.5
    strength: float = 0.5

    def __post_init__(self) -> None:
        if not math.isfinite(self.azimuth_deg):
            raise InputError(f"azimuth_deg = {self.azimuth_deg} must be finite")
        if not 0 < self.elevation_deg <= 90:
            raise InputError(f"elevation_deg = {self.elevation_deg} must lie in (0, 90]")
        if not 0 < self.width_deg <= 45:
            raise InputError(f"width_deg = {self.width_deg} must lie in (0, 45]")
        if not 0 <= self.strength <= 1:
            raise InputError(f"strength = {self.strength} must lie in [0, 1]")

    @property
    def direction(self) -> FloatArray:
        """(3,) unit vector from any camera to the middle of the highlight, world."""
        azimuth, elevation = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        level = math.cos(elevation)
        return np.array([level * math.cos(azimuth), level * math.sin(azimuth), -math.sin(elevation)])


def glare(pinhole: Camera, highlights: Sequence[HighlightSpec], *, gain: float = 1.0) -> ImageArray | None:
    """What the highlights add to each pixel of a pinhole's picture, (H, W, 3) uint8; None without a highlight."""
    if not highlights:
        return None
    size = pinhole.intrinsics
    depth = np.ones((size.height_px, size.width_px), np.float32)
    rays = world_points(pinhole, depth) - pinhole.pose.position_m  # (H, W, 3)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    total = np.zeros(depth.shape)
    for highlight in highlights:
        apart = np.linalg.norm(rays - highlight.direction, axis=-1)  # chord, within 1 % of the angle up to 28 degrees
        total += highlight.strength * np.exp(-0.5 * (apart / math.radians(highlight.width_deg)) ** 2)
    levels = np.rint(np.minimum(255.0 * gain * total, 255.0)).astype(np.uint8)
    return np.repeat(levels[..., None], 3, axis=-1)
