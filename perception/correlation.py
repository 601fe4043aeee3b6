"""Kernelized correlation in the Fourier domain: training, detection and the peak, as pure functions on one window.

Henriques, Caseiro, Martins and Batista, "High-speed tracking with kernelized correlation filters" (TPAMI 2015), called
H below: all cyclic shifts of a window are training samples, so the kernel matrix is circulant and ridge regression on
(H * W) samples costs a few transforms.

Windows are (H, W) float32 with even sides. A *spectrum* is OpenCV's packed transform of a real array: (H, W) float32
too, real and imaginary parts in slots of their own. It was the fastest by far when measured on one core with 32 x 64
samples: 4 us, against 12 us of SciPy's rfft2 and 24 us of NumPy's, so that stacking the windows of many targets into
one SciPy call gains nothing. Only windows of many channels are transformed that way: ``spectra``.

Shifts are counted from the middle: response[H // 2, W // 2] is the answer for "has not moved".
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
import scipy.fft
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]
Spectrum = NDArray[np.float32]
Spectra = NDArray[np.complex64]

MAIN_LOBE = 5  # half width of the square round the peak that is not side lobe (Bolme et al. 2010, section 3.5)
_NOTHING = 1e-6  # of the peak: keeps logarithms finite


def spectrum(window: Float32Array) -> Spectrum:
    """The packed spectrum of a window (H, W)."""
    return np.asarray(cv2.dft(window), np.float32)


def inverse(packed: Spectrum) -> Float32Array:
    """The window (H, W) of a packed spectrum."""
    return np.asarray(cv2.idft(packed, flags=cv2.DFT_SCALE), np.float32)


def spectra(window: Float32Array) -> Spectra:
    """(C, H, W // 2 + 1) half spectra of a window (C, H, W) of C channels, in one call."""
    return np.asarray(scipy.fft.rfft2(window, workers=1), np.complex64)


def cross_correlation(of: Spectrum, by: Spectrum) -> Float32Array:
    """(H, W) sum over m of of[m + shift] * by[m], for every cyclic shift."""
    return inverse(_product(of, by, conjugate=True))


def channel_correlation(of: Spectra, by: Spectra, shape: tuple[int, int]) -> Float32Array:
    """The cross-correlation summed over the channels (H, eq. 31): one inverse transform for all of them."""
    product = np.einsum("chw,chw->hw", of, by.conj())
    return np.asarray(scipy.fft.irfft2(product, s=shape, workers=1), np.float32)


def _product(of: Spectrum, by: Spectrum, *, conjugate: bool = False) -> Spectrum:
    return np.asarray(cv2.mulSpectrums(of, by, 0, conjB=conjugate), np.float32)


def gaussian_kernel(cross: Float32Array, energy: float, bandwidth: float, size: int) -> Float32Array:
    """(H, W) Gaussian kernel between one window and all cyclic shifts of another (H, eq. 30).

    cross: their cross-correlation, overwritten. energy: the sum of both windows' squared norms.
    bandwidth: sigma; squared distances are divided by ``size``, the number of samples, as in the authors' own code.
    """
    scale = 1.0 / (bandwidth**2 * size)
    cv2.addWeighted(cross, 2.0 * scale, cross, 0.0, -energy * scale, dst=cross)
    cv2.exp(cross, dst=cross)
    return cross


def gaussian_target(shape: tuple[int, int], sigma: float) -> Float32Array:
    """(H, W) regression target: 1 in the middle, falling off with ``sigma`` samples."""
    v, u = (np.minimum(np.abs(np.arange(n) - n // 2), n - np.abs(np.arange(n) - n // 2)) for n in shape)
    return np.asarray(np.exp(-(v[:, None] ** 2 + u**2) / (2 * sigma**2)), np.float32)


def ridge_spectrum(shape: tuple[int, int], ridge: float) -> Spectrum:
    """What ``train`` adds to the kernel's spectrum: lambda at every frequency.

    The spectrum of one impulse is 1 + 0i everywhere, so it marks the real slots. The imaginary ones take 1: there both
    the kernel of a window with itself and the target, being symmetric, are nothing but rounding, and stay so.
    """
    impulse = np.zeros(shape, np.float32)
    impulse[0, 0] = 1.0
    real = spectrum(impulse) > 0.5
    return np.where(real, ridge, 1.0).astype(np.float32)


def train(kernel: Float32Array, target_f: Spectrum, ridge_f: Spectrum) -> Spectrum:
    """Spectrum of the dual coefficients alpha of the ridge regression over all cyclic shifts (H, eq. 17).

    kernel: Gaussian kernel of the window with itself. target_f: spectrum of ``gaussian_target``.
    """
    denominator = spectrum(kernel)
    denominator += ridge_f
    return np.divide(target_f, denominator, out=denominator)


def respond(kernel: Float32Array, alpha_f: Spectrum) -> Float32Array:
    """(H, W) the regression's answer at every cyclic shift of a window (H, eq. 22).

    kernel: Gaussian kernel between that window and the learned one.
    """
    return inverse(_product(spectrum(kernel), alpha_f))


@dataclass(frozen=True)
class Peak:
    """The highest place of a response.

    shift: (u, v) in samples, from the middle, to a fraction of a sample.
    height: the response there; about 1 where the window looks as learned.
    sharpness: peak to side lobe ratio, (height - mean) / deviation of all that is not near the peak (Bolme 2010).
    """

    shift: tuple[float, float]
    height: float
    sharpness: float


def find_peak(response: Float32Array) -> Peak:
    """The highest place of a response (H, W), a parabola through the logarithms giving the fraction of a sample.

    The regression's target is a Gaussian, whose logarithm is a parabola, so the fraction is exact where the response
    is the shifted target.
    """
    height, width = response.shape
    _, top, _, (u, v) = cv2.minMaxLoc(response)
    du = _vertex(response[v, u - 1], top, response[v, (u + 1) % width])
    dv = _vertex(response[v - 1, u], top, response[(v + 1) % height, u])
    return Peak((u - width // 2 + du, v - height // 2 + dv), top, side_lobe_ratio(response, (u, v), top))


def side_lobe_ratio(response: Float32Array, place: tuple[int, int], top: float) -> float:
    """(top - mean) / deviation of a response outside the square round ``place`` (u, v)."""
    u, v = place
    lobe = response[max(v - MAIN_LOBE, 0) : v + MAIN_LOBE + 1, max(u - MAIN_LOBE, 0) : u + MAIN_LOBE + 1]
    count = response.size - lobe.size
    if count < 2:
        return 0.0
    flat, near = response.ravel(), lobe.ravel()
    mean = (cv2.sumElems(response)[0] - cv2.sumElems(lobe)[0]) / count
    variance = max(float(flat @ flat - near @ near) / count - mean**2, 0.0)
    return (top - mean) / (math.sqrt(variance) + _NOTHING)


def _vertex(before: float, top: float, after: float) -> float:
    """Where the parabola through the logarithms of three neighbours is highest, from the middle one: within half."""
    least = max(top, 0.0) * _NOTHING + 1e-30
    low, middle, high = (math.log(max(float(value), least)) for value in (before, top, after))
    bend = low - 2.0 * middle + high
    return 0.0 if bend >= 0 else max(-0.5, min(0.5, 0.5 * (low - high) / bend))
