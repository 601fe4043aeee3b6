"""Rain near the camera: drops smeared to streaks while the shutter is open, before the lens, in every frame others.

Streaks are drawn once, on sheets larger than the picture; a frame shows one of them, shifted at random, as the sensor's
noise is. Drops farther away are seen as a veil: ``sim.air``.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from contracts import ImageArray, InputError
from sim.air import Air, Weather, diffused
from sim.lights import Light
from sim.streams import stream

_SHEETS, _SPARE_PX = 3, 160
_NEAREST_M, _FARTHEST_M = 1.2, 7.0
_DROPS_PER_M3, _DROP_M = 18.0, 0.0022  # those large enough to be seen one by one
_FALL_MPS, _SLANT_RAD, _GUSTS_RAD = 7.5, 0.10, 0.05
_SHOWN_S = 0.008  # streaks of a shorter exposure could not be told from noise: shutters are slow in the rain
_BRIGHT, _LAMPLIT = 0.55, 0.22  # of a drop's light, relative to the air's, and to that of lamps on the ground
_VISIBLE = 8.0  # a drop is brighter than what is behind it by far: it bends the sky's light into the camera
_SOFT_PX = 0.6
_SHIFT = 4  # bits of a pixel's fraction


@dataclass(frozen=True)
class RainSpec:
    """Rain before a camera. level: of a drop's light, 0 to 255. exposure_s: how long drops are smeared."""

    level: float
    exposure_s: float

    @staticmethod
    def of(weather: Weather, light: Light, exposure_s: float) -> "RainSpec | None":
        """What of a weather falls before the camera; None if nothing does."""
        if weather is not Weather.RAIN:
            return None
        air = Air.of(weather, diffused(light, weather))
        level = _BRIGHT * float(np.mean(air.bgr)) + _LAMPLIT * 255.0 * float(np.mean(light.lamps))
        return RainSpec(min(level, 255.0), exposure_s)

    def __post_init__(self) -> None:
        if not 0 <= self.level <= 255:
            raise InputError(f"RainSpec.level = {self.level} must lie in [0, 255]")
        if not 0 <= self.exposure_s < 1:
            raise InputError(f"RainSpec.exposure_s = {self.exposure_s} must lie in [0, 1)")


class Rain:
    """The streaks before one camera; those of a frame depend on seed, camera and index alone."""

    def __init__(
        self, spec: RainSpec, camera: str, size_px: tuple[int, int], focal_px: float, seed: int, *, gain: float = 1.0
    ) -> None:
        self._seed, self._concern = seed, f"rain/{camera}"
        rng = stream(seed, self._concern)
        self._sheets = [_sheet(spec, size_px, focal_px, gain, rng) for _ in range(_SHEETS)]

    def before(self, image: ImageArray, index: int) -> ImageArray:
        """The picture (H, W, 3) of frame ``index`` with the streaks that fall before it; the input stays as it is."""
        rng = stream(self._seed, f"{self._concern}/{index}")
        sheet = self._sheets[rng.integers(_SHEETS)]
        top, left = rng.integers(0, _SPARE_PX, 2).tolist()
        streaks = sheet[top : top + image.shape[0], left : left + image.shape[1]]
        return np.asarray(cv2.add(image, streaks), np.uint8)


def _sheet(
    spec: RainSpec, size_px: tuple[int, int], focal_px: float, gain: float, rng: np.random.Generator
) -> ImageArray:
    """Streaks on black, (H + spare, W + spare, 3): drops evenly in the volume before the camera."""
    width, height = (n + _SPARE_PX for n in size_px)
    volume_m3 = width * height / focal_px**2 * (_FARTHEST_M**3 - _NEAREST_M**3) / 3
    count = rng.poisson(_DROPS_PER_M3 * volume_m3)
    depth_m = np.cbrt(rng.uniform(_NEAREST_M**3, _FARTHEST_M**3, count))
    u, v = rng.uniform(0, width, count), rng.uniform(0, height, count)
    slant = rng.normal(_SLANT_RAD, _GUSTS_RAD, count)
    length = _FALL_MPS * max(spec.exposure_s, _SHOWN_S) * focal_px / depth_m
    thick = np.maximum(_DROP_M * focal_px / depth_m * rng.uniform(0.6, 1.4, count), 0.3)
    shown = _DROP_M * focal_px / depth_m / length  # share of the exposure for which a drop covers a pixel of its streak
    level = gain * spec.level * np.minimum(1.0, _VISIBLE * shown * np.minimum(thick, 1.0))
    sheet = np.zeros((height, width), np.uint8)
    ends = np.stack([u, v, u + length * np.sin(slant), v + length * np.cos(slant)], axis=1)
    fixed = np.rint(ends * (1 << _SHIFT)).astype(int)
    for k in np.argsort(level):  # where two cross the brighter one is seen
        start, end = (tuple(point) for point in fixed[k].reshape(2, 2).tolist())
        cv2.line(sheet, start, end, level[k], max(1, round(thick[k])), cv2.LINE_AA, _SHIFT)
    soft = cv2.GaussianBlur(sheet, (0, 0), _SOFT_PX)
    return np.repeat(soft[..., None], 3, axis=2)
