"""What lies between the camera and what it sees: sky, haze, fog, and the veil of rain far away.

Light on its way through air loses the share 1 - exp(-extinction * range) and gains the same share of the air's own
light (Koschmieder 1924). The sky is air without end.
"""

from dataclasses import dataclass, replace
from enum import StrEnum

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera
from sim.lights import Light

_KOSCHMIEDER = 3.912  # extinction times the range at which a contrast has sunk to 2 %
_VEHICLE_M, _UNSEEN = 10.0, 0.02  # long; share of the light that may get lost before it shows
_LAMPS_GLOW, _LAMPS_REACH_M = 0.16, 40.0  # share of lamps' light that stays in fog, and way that it goes through it
_TOP_RAD = 0.6  # elevation at which the sky has its own colour; the horizon has that of the air
_ZENITH_BGR, _CLOUDY_BGR = (1.0, 0.78, 0.58), (0.93, 0.93, 0.93)  # high above, relative to the horizon
Array32 = NDArray[np.float32]


class Weather(StrEnum):
    """The weathers that a scenario of the road may name."""

    DRY = "dry"
    WET = "wet"
    RAIN = "rain"
    FOG = "fog"


_CLOSED = frozenset((Weather.RAIN, Weather.FOG))
_FROM_ABOVE, _FROM_AROUND = 0.45, 0.20  # shares of a beam that come through clouds and fog, and whence
VISIBILITY_M = {Weather.DRY: 4000.0, Weather.WET: 2500.0, Weather.RAIN: 700.0, Weather.FOG: 140.0}
"""Meteorological range: how far one sees."""


def diffused(light: Light, weather: Weather) -> Light:
    """What of a light comes down through rain clouds or fog: no beam, and what it brought from the whole sky."""
    if weather not in _CLOSED or not light.beams:
        return light
    brought = sum(np.array(beam.rgb) * np.sin(beam.elevation_rad) for beam in light.beams)
    sky, ambient = np.array(light.sky) + _FROM_ABOVE * brought, np.array(light.ambient) + _FROM_AROUND * brought
    return replace(light.without_beams(), sky=tuple(sky.tolist()), ambient=tuple(ambient.tolist()))


@dataclass(frozen=True)
class Air:
    """The air under one light. extinction_per_m: per metre of range; bgr: its own light, levels from 0 to 255."""

    extinction_per_m: float
    bgr: tuple[float, float, float]

    @staticmethod
    def of(weather: Weather, light: Light) -> "Air":
        """The air of a weather."""
        sky = np.array(light.sky[::-1]) + np.array(light.ambient[::-1])
        glow = np.sum([np.array(beam.rgb[::-1]) for beam in light.beams], axis=0) if light.beams else np.zeros(3)
        extinction = _KOSCHMIEDER / VISIBILITY_M[weather]
        scattered = _LAMPS_GLOW * (1.0 - np.exp(-extinction * _LAMPS_REACH_M)) * np.array(light.lamps[::-1])
        level = light.factor * (0.92 * sky + 0.45 * glow) + scattered
        blue, green, red = np.minimum(255.0 * level, 250.0).tolist()
        return Air(extinction, (blue, green, red))

    @property
    def is_clear(self) -> bool:
        """Whether it makes no difference to the eye that one end of a vehicle is nearer than the other."""
        return self.extinction_per_m * _VEHICLE_M < _UNSEEN

    def transmission(self, range_m: Array32) -> Array32:
        """Share of the light that comes through from so far."""
        return np.asarray(np.exp(np.float32(-self.extinction_per_m) * range_m), np.float32)

    def seen_through(self, image: Array32, range_m: Array32, opacity: Array32 | None = None) -> Array32:
        """An image (H, W, 3) of things at ranges (H, W) as it is seen; ``opacity`` (H, W) where it is a layer."""
        through = self.transmission(range_m)
        veil = 1 - through if opacity is None else (1 - through) * opacity
        return np.asarray(image * in_colour(through) + in_colour(veil, np.array(self.bgr, np.float32)), np.float32)


def in_colour(levels: Array32, bgr: Array32 | None = None) -> Array32:
    """The same in all channels, (H, W, 3), or times a colour; NumPy's own broadcasting is several times slower."""
    channels = [levels] * 3 if bgr is None else [levels * channel for channel in bgr]
    return np.asarray(cv2.merge(channels), np.float32)


def sky_picture(camera: Camera, air: Air, *, clear: bool) -> Array32:
    """The sky, (H, W, 3) BGR levels: the light of the air at the horizon, bluer above if it is clear."""
    rays = rays_of(camera)
    up = np.clip(rays[..., 2] / np.linalg.norm(rays, axis=2) / np.sin(_TOP_RAD), 0.0, 1.0)[..., None]
    horizon = np.array(air.bgr, np.float32)
    above = horizon * np.array(_ZENITH_BGR if clear else _CLOUDY_BGR, np.float32)
    return np.asarray(horizon * (1 - up) + above * up, np.float32)


def rays_of(camera: Camera) -> Array32:
    """Where each pixel of a pinhole looks, (H, W, 3) world, of unit depth: times the depth it leads to what is seen."""
    size = camera.intrinsics
    u = (np.arange(size.width_px) - size.cx_px) / size.fx_px
    v = (np.arange(size.height_px) - size.cy_px) / size.fy_px
    turn = camera.pose.world_from_camera
    rays = u[None, :, None] * turn[:, 0] + v[:, None, None] * turn[:, 1] + turn[:, 2]
    return rays.astype(np.float32)
