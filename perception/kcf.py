"""Our kernelized correlation filter: follows one target through the frames of one camera.

After Henriques et al. (TPAMI 2015), with four additions. The window is turned to the target's heading, so that a
vehicle on a curve looks the same in it and the peak stays unbiased. It is reduced to the one mixture of colours in
which the target differs most from what is round it. The peak is found to a fraction of a sample. And finding and
learning are two calls, so that whoever knows better may correct the place before it is learned.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, ImageArray, InputError
from perception.colour_axis import GREY, colour_axis
from perception.correlation import (
    Float32Array,
    Spectrum,
    channel_correlation,
    cross_correlation,
    find_peak,
    gaussian_kernel,
    gaussian_target,
    respond,
    ridge_spectrum,
    spectra,
    spectrum,
    train,
)
from perception.hog import CELL, CHANNELS, hog
from perception.patches import Crop, WindowShape, cosine_window, to_image
from perception.target_filter import Found

_INSIDE, _OUTSIDE = 0.9, 1.1  # of the target's outline: what surely belongs to it, and what surely does not
_SETTLED_PX = 0.25  # what a look that moves the target less has hidden is not worth another
_MARGIN_PX = 4.0  # a place found so far from the predicted one is looked at without cutting the image again


class Features(StrEnum):
    """What the filter looks at."""

    GREY = "grey"  # brightness
    COLOUR = "colour"  # the mixture of colours that tells the target best from its surroundings when it is first seen
    HOG = "hog"  # that mixture's gradients in cells of 4 x 4 samples; wants 8192 samples, and a floor with texture


@dataclass(frozen=True)
class KcfSettings:
    """How a target is followed; the defaults were chosen on the training sequences.

    features: what the filter looks at.
    padding: length and width of the window over the target's.
    samples: about so many samples in the window; more are slower and, up to the image's own pixels, more exact.
    bandwidth: sigma of the Gaussian kernel, for windows of unit deviation.
    target_sigma: width of the regression's target, as a share of the root of the target's area.
    ridge: lambda, the weight of the regularization.
    learning_rate: share of the new window in the learned one.
    looks: how often at most a target is sought again where it was just found, until it stays there. The window hides
        a seventh of a shift, since it fades what leaves it: one look is the textbook's.
    """

    features: Features = Features.COLOUR
    padding: float = 2.0
    samples: int = 2048
    bandwidth: float = 2.0
    target_sigma: float = 0.08
    ridge: float = 1e-3
    learning_rate: float = 0.05
    looks: int = 3

    def __post_init__(self) -> None:
        if self.features not in list(Features):
            raise InputError(f"KcfSettings.features = {self.features!r}: choose from {', '.join(Features)}")
        for name in ("bandwidth", "target_sigma", "ridge"):
            if not 0 < getattr(self, name) < math.inf:
                raise InputError(f"KcfSettings.{name} = {getattr(self, name)} must be positive and finite")
        if not 1.25 <= self.padding <= 10:
            raise InputError(f"KcfSettings.padding = {self.padding} must lie in [1.25, 10]")
        if not 64 <= self.samples <= 2**20:
            raise InputError(f"KcfSettings.samples = {self.samples} must lie in [64, {2**20}]")
        if not 0 <= self.learning_rate <= 1:
            raise InputError(f"KcfSettings.learning_rate = {self.learning_rate} must lie in [0, 1]")
        if self.looks < 1:
            raise InputError(f"KcfSettings.looks = {self.looks} must be at least 1")


class CorrelationTracker:
    """TargetFilter: ``start`` once, then ``find`` and, when it pays, ``learn`` in every frame."""

    def __init__(self, settings: KcfSettings | None = None) -> None:
        self._settings = settings or KcfSettings()
        self._model: _Model | None = None
        self._searched: tuple[ImageArray, Crop] | None = None

    def start(self, image: ImageArray, centre_px: FloatArray, size_px: tuple[float, float], angle_rad: float) -> None:
        """Learn a target from one image and forget all before."""
        if not 1 <= min(size_px) <= max(size_px) < math.inf:
            raise InputError(f"CorrelationTracker: size_px = {size_px} must be finite and at least one pixel each way")
        self._model = _Model(size_px, self._settings)
        self._searched = None
        self._model.start(self._window(image, centre_px, angle_rad, self._model.shape))

    def find(self, image: ImageArray, predicted_centre_px: FloatArray, angle_rad: float) -> Found:
        """Where the target is, near the predicted place and heading as predicted; nothing is learned."""
        model = self._started()
        centre = np.asarray(predicted_centre_px, np.float64)
        crop = Crop.around(image, centre, model.shape.reach_px + _MARGIN_PX, model.shape.step_px)
        self._searched = image, crop
        for _ in range(self._settings.looks):
            peak = find_peak(model.response(self._window(image, centre, angle_rad, model.shape)))
            moved = to_image(peak.shift, angle_rad, model.stride_px)
            centre = centre + moved
            if abs(moved[0]) + abs(moved[1]) < _SETTLED_PX:
                break
        return Found(centre, peak.height, peak.sharpness)

    def learn(self, image: ImageArray, centre_px: FloatArray, angle_rad: float) -> None:
        """Blend what the target looks like at a place into what was learned.

        Cheapest for the image that was searched last, which must not have changed since.
        """
        model = self._started()
        model.learn(self._window(image, centre_px, angle_rad, model.shape), self._settings.learning_rate)

    def _started(self) -> "_Model":
        if self._model is None:
            raise InputError("CorrelationTracker: there is no target yet, call start() first")
        return self._model

    def _window(self, image: ImageArray, centre_px: FloatArray, angle_rad: float, shape: WindowShape) -> ImageArray:
        crop = None
        if self._searched is not None and self._searched[0] is image:
            crop = self._searched[1]
        if crop is None or not crop.covers(centre_px, shape.reach_px):
            crop = Crop.around(image, centre_px, shape.reach_px, shape.step_px)
        return crop.window(centre_px, angle_rad, shape)


class _Model:
    """What was learned of one target: its mean window, and the regression's coefficients that belong to it.

    shape: of the window. stride_px: distance of neighbouring places of the response.
    """

    def __init__(self, size_px: tuple[float, float], settings: KcfSettings) -> None:
        self._size_px = size_px
        self._settings = settings
        self._hog = settings.features == Features.HOG
        cell = CELL if self._hog else 1
        budget, multiple = settings.samples, 2 * cell
        self.shape = WindowShape.around(size_px, padding=settings.padding, budget=budget, multiple_of=multiple)
        self.stride_px = self.shape.step_px * cell
        self._grid = self.shape.samples[0] // cell, self.shape.samples[1] // cell
        self._fade = cosine_window(self._grid)
        sigma = settings.target_sigma * math.sqrt(size_px[0] * size_px[1]) / self.stride_px
        self._target_f = spectrum(gaussian_target(self._grid, sigma))
        self._ridge_f = ridge_spectrum(self._grid, settings.ridge)
        self._weights = GREY
        self._template: Float32Array = np.zeros((CHANNELS, *self._grid) if self._hog else self._grid, np.float32)
        self._template_f = self._transformed(self._template)
        self._alpha_f: Spectrum = self._target_f
        self._energy = 0.0

    def start(self, window: ImageArray) -> None:
        """Forget all; choose the mixture of colours; learn the window (H, W, 3)."""
        if self._settings.features != Features.GREY:
            distance = self.shape.distance(self._size_px)
            self._weights = colour_axis(window, distance < _INSIDE, distance > _OUTSIDE)
        self.learn(window, 1.0)

    def learn(self, window: ImageArray, rate: float) -> None:
        """Blend the window into the template by ``rate``; solve the regression for the new template."""
        self._template *= 1.0 - rate
        self._template += rate * self._features(window)
        self._template_f = self._transformed(self._template)
        self._energy = _energy(self._template)
        self._alpha_f = train(self._kernel(self._template_f, self._energy), self._target_f, self._ridge_f)

    def response(self, window: ImageArray) -> Float32Array:
        """The regression's answer at every place of the window."""
        features = self._features(window)
        return respond(self._kernel(self._transformed(features), _energy(features)), self._alpha_f)

    def _kernel(self, of: NDArray[Any], energy: float) -> Float32Array:
        if self._hog:
            cross = channel_correlation(of, self._template_f, self._grid)
        else:
            cross = cross_correlation(of, self._template_f)
        return gaussian_kernel(cross, energy + self._energy, self._settings.bandwidth, self._template.size)

    def _transformed(self, features: Float32Array) -> NDArray[Any]:
        return spectra(features) if self._hog else spectrum(features)

    def _features(self, window: ImageArray) -> Float32Array:
        """(H, W) one channel, or (31, H / 4, W / 4), faded; the strength of light and contrast leaves no trace."""
        channel = np.asarray(cv2.transform(window.astype(np.float32), self._weights), np.float32)
        features = hog(channel) if self._hog else channel
        _standardize(features, centred=not self._hog)
        return np.multiply(features, self._fade, out=features)


_FLAT = 0.25  # deviation, grey levels, below which a window has no contrast to scale up
_FLAT_HOG = 1e-6  # mean square of gradient histograms, which are normalized already, of a window without any


def _standardize(features: Float32Array, *, centred: bool) -> None:
    """Bring features to unit mean square, less their mean if ``centred``; in place."""
    if centred:
        mean, deviation = cv2.meanStdDev(features)
        scale = 1.0 / max(float(deviation[0, 0]), _FLAT)
        cv2.addWeighted(features, scale, features, 0.0, -float(mean[0, 0]) * scale, dst=features)
    else:
        features *= 1.0 / math.sqrt(_energy(features) / features.size + _FLAT_HOG)


def _energy(window: Float32Array) -> float:
    flat = window.ravel()
    return float(flat @ flat)
