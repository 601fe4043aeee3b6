"""A filter in the manner of MOSSE, the correlation filter before kernels: a baseline.

After Bolme et al. (CVPR 2010, eq. 10-12): the filter that maps the windows seen so far to a Gaussian peak with the
least squared error, as a ratio of running averages in the Fourier domain. Windows are grey, their logarithms normalised
and faded (their section 3.1), upright, for it knows no headings; the first window is learned with small turns.
"""

import numpy as np
import scipy.fft

from contracts import FloatArray, ImageArray, InputError
from perception.colour_axis import GREY
from perception.correlation import Float32Array, Spectra, find_peak, gaussian_target
from perception.patches import Crop, WindowShape, cosine_window
from perception.target_filter import Found

PADDING = 2.0
SAMPLES = 4096
LEARNING_RATE = 0.125  # the paper's
RIDGE = 1e-2
TARGET_SIGMA = 2.0  # samples, the paper's
TURNS_RAD = (-0.1, -0.05, 0.0, 0.05, 0.1)


class MosseFilter:
    """TargetFilter: ``start`` once, then ``find`` and ``learn`` in every frame. Angles are not used."""

    def __init__(self) -> None:
        self._shape: WindowShape | None = None

    def start(self, image: ImageArray, centre_px: FloatArray, size_px: tuple[float, float], angle_rad: float) -> None:
        """Learn a target from one image and forget all before."""
        if not 1 <= min(size_px) <= max(size_px) < np.inf:
            raise InputError(f"MosseFilter: size_px = {size_px} must be finite and at least one pixel each way")
        length, width = size_px
        c, s = abs(np.cos(angle_rad)), abs(np.sin(angle_rad))
        upright = length * c + width * s, length * s + width * c
        self._shape = WindowShape.around(upright, padding=PADDING, budget=SAMPLES)
        self._fade = cosine_window(self._shape.samples)
        self._target: Spectra = _spectrum(gaussian_target(self._shape.samples, TARGET_SIGMA))
        windows = [_spectrum(self._window(image, centre_px, self._shape, turn)) for turn in TURNS_RAD]
        self._above: Spectra = np.mean([self._target * window.conj() for window in windows], axis=0)
        self._below: Spectra = np.mean([window * window.conj() for window in windows], axis=0)

    def find(self, image: ImageArray, predicted_centre_px: FloatArray, angle_rad: float) -> Found:
        """Where the target is, near the predicted place; nothing is learned."""
        shape = self._started()
        window = _spectrum(self._window(image, predicted_centre_px, shape))
        response = scipy.fft.irfft2(window * self._above / (self._below + RIDGE), s=shape.samples, workers=1)
        peak = find_peak(np.asarray(response, np.float32))
        moved = np.array(peak.shift) * shape.step_px
        return Found(np.asarray(predicted_centre_px, np.float64) + moved, peak.height, peak.sharpness)

    def learn(self, image: ImageArray, centre_px: FloatArray, angle_rad: float) -> None:
        """Blend what the target looks like at a place into what was learned."""
        window = _spectrum(self._window(image, centre_px, self._started()))
        self._above = (1 - LEARNING_RATE) * self._above + LEARNING_RATE * self._target * window.conj()
        self._below = (1 - LEARNING_RATE) * self._below + LEARNING_RATE * window * window.conj()

    def _started(self) -> WindowShape:
        if self._shape is None:
            raise InputError("MosseFilter: there is no target yet, call start() first")
        return self._shape

    def _window(
        self, image: ImageArray, centre_px: FloatArray, shape: WindowShape, turn_rad: float = 0.0
    ) -> Float32Array:
        """(H, W) logarithms of grey, less their mean, in units of their deviation, faded."""
        crop = Crop.around(image, centre_px, shape.reach_px, shape.step_px)
        grey = crop.window(centre_px, turn_rad, shape).astype(np.float32) @ GREY[0]
        tones = np.log1p(grey)
        tones -= tones.mean()
        return np.asarray(tones / max(float(tones.std()), 1e-2) * self._fade, np.float32)


def _spectrum(window: Float32Array) -> Spectra:
    return np.asarray(scipy.fft.rfft2(window, workers=1), np.complex64)
