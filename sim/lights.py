"""Light presets: pure functions of time."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray

Rgb = tuple[float, float, float]
_Real = TypeVar("_Real", np.float32, np.float64)


class LightPreset(StrEnum):
    """The lights that a scenario may name."""

    SUNNY = "sunny"
    CLOUDY = "cloudy"
    LAMPS = "lamps"
    DUSK = "dusk"
    MOVING_SHADOW = "moving_shadow"
    FLICKER = "flicker"
    NIGHT = "night"


RAIL_LIGHTS = tuple(light for light in LightPreset if light is not LightPreset.NIGHT)
"""Lights of a room."""
ROAD_LIGHTS = (LightPreset.SUNNY, LightPreset.CLOUDY, LightPreset.DUSK, LightPreset.NIGHT)
"""Lights under the sky."""


@dataclass(frozen=True)
class Beam:
    """Parallel light that casts shadows.

    azimuth_rad, elevation_rad: where it comes from; azimuth counter-clockwise from east.
    rgb: irradiance on a surface that faces it; 1 turns albedo 1 into level 255.
    """

    azimuth_rad: float
    elevation_rad: float
    rgb: Rgb

    @cached_property
    def direction(self) -> FloatArray:
        """(3,) unit vector in which the light travels, world; read-only."""
        level = math.cos(self.elevation_rad)
        towards = [level * math.cos(self.azimuth_rad), level * math.sin(self.azimuth_rad), math.sin(self.elevation_rad)]
        direction = -np.array(towards)
        direction.setflags(write=False)
        return direction


@dataclass(frozen=True)
class ShadowBand:
    """The soft-edged shadow of something large outside of the picture, as it lies on the ground.

    It covers ``|n . p - centre_m| < half_width_m`` with n the unit vector of ``across_rad``.
    strength: share of the beams that it takes away. edge_m: width of the penumbra.
    """

    across_rad: float
    centre_m: float
    half_width_m: float
    edge_m: float
    strength: float

    def shade(self, ground_m: FloatArray) -> FloatArray:
        """Share (...) of the beams taken away at ground points (..., 2)."""
        return self.profile(self.coordinate(ground_m))

    def coordinate(self, ground_m: FloatArray) -> FloatArray:
        """``n . p`` of ground points (..., 2), metres."""
        return np.asarray(ground_m @ (math.cos(self.across_rad), math.sin(self.across_rad)))

    def profile(self, coordinate_m: NDArray[_Real]) -> NDArray[_Real]:
        """Share of the beams taken away at a coordinate (...)."""
        inside = self.half_width_m - np.abs(coordinate_m - self.centre_m)
        return np.asarray(self.strength * np.clip(inside / self.edge_m + 0.5, 0.0, 1.0))


@dataclass(frozen=True)
class Light:
    """All light at one moment.

    beams: cast shadows. sky: from straight above without shadow. ambient: from everywhere, shadow or not.
    band: takes part of the beams away on a part of the ground, or nothing.
    factor: on all of it; lights that differ in nothing else look alike but for the exposure.
    lamps: of a road: irradiance on the ground below a streetlamp; black while they, and those of vehicles, are off.
    """

    beams: tuple[Beam, ...]
    sky: Rgb
    ambient: Rgb
    band: ShadowBand | None = None
    factor: float = 1.0
    lamps: Rgb = (0.0, 0.0, 0.0)

    @property
    def lamplit(self) -> bool:
        """Whether the lamps of a road are on."""
        return any(self.lamps)

    def without_beams(self) -> "Light":
        """What is left in full shadow."""
        return replace(self, beams=(), band=None)


ALBEDO = Light((), sky=(0.0, 0.0, 0.0), ambient=(1.0, 1.0, 1.0))
"""Under this light a picture shows albedos."""


def light_at(preset: LightPreset, time_ns: int) -> Light:
    """The light of ``preset`` at ``time_ns``."""
    return _PRESETS[preset](time_ns * 1e-9)


def _sunny(_time_s: float) -> Light:
    sun = Beam(math.radians(125.0), math.radians(52.0), (0.62, 0.59, 0.53))
    return Light((sun,), sky=(0.22, 0.235, 0.26), ambient=(0.25, 0.26, 0.28))


def _cloudy(_time_s: float) -> Light:
    return Light((), sky=(0.46, 0.47, 0.49), ambient=(0.34, 0.35, 0.36))


def _lamps(_time_s: float) -> Light:
    left = Beam(math.radians(200.0), math.radians(62.0), (0.44, 0.39, 0.31))
    right = Beam(math.radians(-35.0), math.radians(58.0), (0.38, 0.34, 0.27))
    return Light((left, right), sky=(0.04, 0.04, 0.04), ambient=(0.20, 0.19, 0.17))


def _dusk(_time_s: float) -> Light:
    return Light((), sky=(0.17, 0.19, 0.25), ambient=(0.13, 0.14, 0.18), lamps=(0.46, 0.39, 0.27))


def _night(_time_s: float) -> Light:
    return Light((), sky=(0.008, 0.009, 0.014), ambient=(0.012, 0.012, 0.016), lamps=(1.50, 1.28, 0.90))


def _moving_shadow(time_s: float) -> Light:
    """Somebody walks through the sun: the band crosses the middle every twelve seconds."""
    centre_m = -2.4 + 0.4 * (time_s % 12.0)
    return replace(_sunny(time_s), band=ShadowBand(math.radians(20.0), centre_m, 0.45, 0.12, 0.85))


def _flicker(time_s: float) -> Light:
    """Lamps on 49.3 Hz mains: filmed at 25 fps the 98.6 Hz ripple shows as a slow beat."""
    factor = 0.86 + 0.14 * math.cos(2.0 * math.pi * 98.6 * time_s)
    return replace(_lamps(time_s), factor=factor)


_PRESETS: dict[LightPreset, Callable[[float], Light]] = {
    LightPreset.SUNNY: _sunny,
    LightPreset.CLOUDY: _cloudy,
    LightPreset.LAMPS: _lamps,
    LightPreset.DUSK: _dusk,
    LightPreset.MOVING_SHADOW: _moving_shadow,
    LightPreset.FLICKER: _flicker,
    LightPreset.NIGHT: _night,
}
