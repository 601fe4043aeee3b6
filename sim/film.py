"""One camera's film: a clean picture through shutter, lens and sensor, and the truth of what it shows."""

import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from contracts import Camera, Frame, ImageArray
from contracts.truth import CameraTruth, Truth
from sim.camera_truth import View, camera_truth
from sim.highlights import HighlightSpec, glare
from sim.lens import Lens, pinhole_camera
from sim.rain import Rain, RainSpec
from sim.renderer import Rendered, Renderer, Still, Window
from sim.sensor import Sensor, SensorSpec
from sim.windows import inside

_NEAREST_M = 0.1  # nobody comes nearer to a camera
_SMEAR_PER_PICTURE_PX = 1.0  # a vehicle that moves less than this while the shutter is open looks sharp


class CameraFilm:
    """Films states of the world with one camera; every frame depends on its state and index alone.

    renderer: knows the camera's pinhole (``pinhole_camera``) by its name.
    view: tells the truth of what the camera sees.
    """

    def __init__(
        self,
        camera: Camera,
        lens: Lens,
        renderer: Renderer,
        sensor: SensorSpec,
        *,
        noise_seed: int,
        keep_instances: bool = True,
        highlights: Sequence[HighlightSpec] = (),
        rain: RainSpec | None = None,
        view: View = camera_truth,
    ) -> None:
        self._camera, self._lens, self._renderer, self._view = camera, lens, renderer, view
        self._exposure_s = sensor.exposure_ms * 1e-3
        self._keep_instances = keep_instances
        self._still: ImageArray | None = None
        self._still_developed: ImageArray = np.empty((0, 0, 3), np.uint8)
        self._canvas, self._dirty = self._still_developed, tuple[Window, ...]()
        self._things: tuple[Still, Still] | None = None
        size = camera.intrinsics
        shine = glare(pinhole_camera(camera, lens), highlights, gain=sensor.gain)
        self._glare = None if shine is None else lens.bend(shine)
        px = size.width_px, size.height_px
        self._rain = None if rain is None else Rain(rain, camera.name, px, size.fx_px, noise_seed, gain=sensor.gain)
        self._sensor = Sensor(sensor, camera.name, size.width_px, size.height_px, noise_seed)

    def shoot(self, state: Truth) -> tuple[Frame, CameraTruth]:
        """The frame whose mid-exposure is ``state``, and its truth."""
        rendered = self._exposed(state)
        windows = self._lens.bent_windows(rendered.windows)
        image = self._developed(rendered, windows)
        if self._glare is not None:
            image = np.asarray(cv2.add(image, self._glare), np.uint8)
        if self._rain is not None:
            image = self._rain.before(image, state.index)
        image = self._sensor.grain(self._sensor.balance(image, state.time_ns), state.index)
        frame = Frame(self._camera.name, state.index, state.time_ns, image)
        seen = Rendered(image, self._bent_instances(rendered, windows), things=self._bent_things(rendered))
        truth = self._view(self._camera, state, seen)
        return frame, truth if self._keep_instances else replace(truth, instances=None)

    def _exposed(self, state: Truth) -> Rendered:
        """The mean of pictures spread evenly over the exposure; identities at its middle."""
        middle = self._renderer.render(state, self._camera.name)
        moments = [advanced(state, t) for t in self._sub_frames_s(state) if t != 0.0]
        return mean_picture(middle, [self._renderer.render(moment, self._camera.name) for moment in moments])

    def _developed(self, rendered: Rendered, windows: Sequence[Window]) -> ImageArray:
        """The picture through lens and defocus; outside of ``windows`` it stands still and has been through before.

        It is the film's own and lasts until the next one.
        """
        if rendered.still is None:
            return self._sensor.focus(self._lens.bend(rendered.image))
        if rendered.still is not self._still:
            self._still, self._still_developed = rendered.still, self._sensor.focus(self._lens.bend(rendered.still))
            self._canvas, self._dirty = self._still_developed.copy(), ()
        for window in self._dirty:
            self._canvas[window] = self._still_developed[window]
        self._dirty = tuple(_grown(window, self._sensor.reach_px, self._canvas.shape) for window in windows)
        for inner in self._dirty:
            outer = _grown(inner, self._sensor.reach_px, self._canvas.shape)
            if self._canvas[inner].size:
                part = self._sensor.focus(self._lens.bend(rendered.image, outer))
                self._canvas[inner] = part[inside(inner, outer)]
        return self._canvas

    def _bent_instances(self, rendered: Rendered, windows: Sequence[Window]) -> ImageArray:
        if rendered.still is None:
            return self._lens.bend_mask(rendered.instances)
        size = self._camera.intrinsics
        instances = np.zeros((size.height_px, size.width_px), np.uint8)
        for window in windows:
            if instances[window].size:
                instances[window] = self._lens.bend_mask(rendered.instances, window)
        return instances

    def _bent_things(self, rendered: Rendered) -> Still | None:
        """What stands still; bent anew only if it is another than before."""
        straight = rendered.things
        if straight is None:
            return None
        if self._things is None or self._things[0] is not straight:
            self._things = straight, replace(straight, kinds=self._lens.bend_mask(straight.kinds))
        return self._things[1]

    def _sub_frames_s(self, state: Truth) -> list[float]:
        """Moments relative to mid-exposure at which pictures are taken: an odd number, 0.0 among them."""
        away_m = np.linalg.norm(state.positions_m - self._camera.pose.position_m, axis=1)
        px_per_s = self._camera.intrinsics.fx_px * np.hypot(*state.velocities_mps.T) / np.maximum(away_m, _NEAREST_M)
        smear_px = float(px_per_s.max(initial=0.0)) * self._exposure_s
        half = math.ceil((smear_px / _SMEAR_PER_PICTURE_PX - 1.0) / 2.0)
        half = max(0, half)
        return [k * self._exposure_s / (2 * half + 1) for k in range(-half, half + 1)]


def advanced(state: Truth, by_s: float) -> Truth:
    """The state a moment later (or earlier), every object moving on straight."""
    moved = state.positions_m.copy()
    moved[:, :2] += state.velocities_mps * by_s
    travelled = state.travelled_m
    if travelled is not None:
        travelled = travelled + np.hypot(*state.velocities_mps.T) * by_s
    return replace(state, time_ns=state.time_ns + round(by_s * 1e9), positions_m=moved, travelled_m=travelled)


def mean_picture(middle: Rendered, others: Sequence[Rendered]) -> Rendered:
    """The mean image of all, with the identities of ``middle``."""
    if not others:
        return middle
    everyone = [middle, *others]
    if middle.still is None or any(other.still is not middle.still for other in others):
        return replace(middle, image=_mean([rendered.image for rendered in everyone]), still=None, windows=())
    windows = tuple(window for rendered in everyone for window in rendered.windows)
    image = middle.still.copy()
    for window in windows:
        image[window] = _mean([rendered.image[window] for rendered in everyone])
    return replace(middle, image=image, windows=windows)


def _mean(images: Sequence[ImageArray]) -> ImageArray:
    total = np.zeros(images[0].shape, np.float32)
    for image in images:
        cv2.accumulate(image, total)
    return np.asarray(cv2.convertScaleAbs(total, alpha=1.0 / len(images)), np.uint8)


def _grown(window: Window, by_px: int, shape: tuple[int, ...]) -> Window:
    """The window with ``by_px`` more on each side, within an image of ``shape``."""
    rows, columns = window
    return (
        slice(max(0, rows.start - by_px), min(shape[0], rows.stop + by_px)),
        slice(max(0, columns.start - by_px), min(shape[1], columns.stop + by_px)),
    )
