"""The sensor: defocus, exposure and noise, which change the image and nothing else."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, ImageArray, InputError
from sim.streams import stream

_PERIODS = np.array([1.13, 0.97, 0.83])  # of blue, green, red
_POOL_SPARE_PX = 256  # the noise pool is larger than the image by this much each way


@dataclass(frozen=True)
class SensorSpec:
    """Faults of a sensor.

    noise: standard deviation of the additive Gaussian noise, grey levels of 255.
    defocus_px: standard deviation of the blur disc, taken as Gaussian.
    gain: factor on all values; 1 is the exposure for which the light presets are balanced.
    exposure_ms: time for which the shutter is open; moving things smear.
    white_balance_drift: largest share by which the gain of a colour channel departs from ``gain`` as time goes by; red,
        green and blue go their own ways, each once round in about ``white_balance_period_s``.
    """

    noise: float = 1.5
    defocus_px: float = 0.5
    gain: float = 1.0
    exposure_ms: float = 2.0
    white_balance_drift: float = 0.0
    white_balance_period_s: float = 10.0

    def __post_init__(self) -> None:
        for name in ("noise", "defocus_px", "gain", "exposure_ms"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"SensorSpec.{name} = {value} must be a finite number, 0 or more")
        if not 0 <= self.white_balance_drift < 1:
            raise InputError(f"SensorSpec.white_balance_drift = {self.white_balance_drift} must lie in [0, 1)")
        if not (np.isfinite(self.white_balance_period_s) and self.white_balance_period_s > 0):
            raise InputError(f"SensorSpec.white_balance_period_s = {self.white_balance_period_s} must be positive")


class Sensor:
    """One camera's sensor. The noise of a frame depends on seed, camera and index alone, not on earlier frames."""

    def __init__(self, spec: SensorSpec, camera: str, width_px: int, height_px: int, noise_seed: int) -> None:
        self._spec = spec
        self._concern = f"noise/{camera}"
        self._seed = noise_seed
        self._phases = stream(noise_seed, f"white balance/{camera}").uniform(0.0, 2.0 * math.pi, 3)
        shape = (height_px + _POOL_SPARE_PX, width_px + _POOL_SPARE_PX, 3)
        drawn = stream(noise_seed, self._concern).integers(0, 1 << 16, shape if spec.noise else 1, np.uint16)
        brighter, darker = _whole_normals(spec.noise)  # two unsigned halves: saturating sums are fastest
        self._brighter, self._darker = brighter.take(drawn), darker.take(drawn)

    @property
    def reach_px(self) -> int:
        """How far defocus carries the light of a pixel."""
        return math.ceil(3.0 * self._spec.defocus_px) + 1 if self._spec.defocus_px else 0

    def expose(self, image: ImageArray, index: int) -> ImageArray:
        """The image (H, W, 3) as the sensor delivers frame ``index``; the input stays as it is."""
        return self.grain(self.focus(image), index)

    def focus(self, image: ImageArray) -> ImageArray:
        """The image, or a part of it, out of focus and exposed; the same for every frame."""
        spec = self._spec
        if spec.defocus_px:
            blurred = cv2.GaussianBlur(image, (0, 0), spec.defocus_px, borderType=cv2.BORDER_REPLICATE)
            image = np.asarray(blurred, np.uint8)
        if spec.gain != 1.0:
            image = np.asarray(cv2.convertScaleAbs(image, alpha=spec.gain), np.uint8)
        return image

    def channel_gains(self, time_ns: int) -> FloatArray:
        """Factors (3,) BGR of the white balance at a moment: sines of seeded phase, of periods a little apart."""
        angle = 2.0 * math.pi * time_ns * 1e-9 / (self._spec.white_balance_period_s * _PERIODS)
        return np.asarray(1.0 + self._spec.white_balance_drift * np.sin(angle + self._phases))

    def balance(self, image: ImageArray, time_ns: int) -> ImageArray:
        """The image with the white balance of a moment."""
        if not self._spec.white_balance_drift:
            return image
        gains = np.diag(self.channel_gains(time_ns)).astype(np.float32)
        return np.asarray(cv2.transform(image, gains), np.uint8)  # several times as fast as tables of levels

    def grain(self, image: ImageArray, index: int) -> ImageArray:
        """A fresh image with the noise of frame ``index``.

        It is a pool of noise, shifted at random: fresh normal noise would cost more than the rest of the frame.
        """
        if not self._spec.noise:
            return image.copy()
        top, left = stream(self._seed, f"{self._concern}/{index}").integers(0, _POOL_SPARE_PX, 2)
        window = np.s_[top : top + image.shape[0], left : left + image.shape[1]]
        noisy = cv2.add(image, self._brighter[window])
        return np.asarray(cv2.subtract(noisy, self._darker[window], dst=noisy), np.uint8)


def _whole_normals(sigma: float) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """2^16 equally likely values of a normal distribution, rounded to whole levels: what is above 0, what is below."""
    bounds = np.arange(-254.5, 255.0)
    below = [0.5 * math.erfc(-bound / (math.sqrt(2.0) * max(sigma, 1e-9))) for bound in bounds.tolist()]
    levels = np.searchsorted(below, (np.arange(1 << 16) + 0.5) / (1 << 16)) - 255
    return np.clip(levels, 0, 255).astype(np.uint8), np.clip(-levels, 0, 255).astype(np.uint8)
