"""One camera's film: a clean picture through shutter, lens and sensor, and the truth of what it shows."""

import math
from dataclasses import replace

import numpy as np

from contracts import Camera, Frame, ImageArray
from contracts.truth import CameraTruth, Truth
from sim.camera_truth import camera_truth
from sim.lens import Lens
from sim.renderer import Rendered, Renderer
from sim.sensor import Sensor, SensorSpec

_SMEAR_PER_PICTURE_PX = 0.5  # a vehicle that moves less than this while the shutter is open looks sharp


class CameraFilm:
    """Films states of the world with one camera; every frame depends on its state and index alone.

    renderer: knows the camera's pinhole (``pinhole_camera``) by its name.
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
    ) -> None:
        self._camera, self._lens, self._renderer = camera, lens, renderer
        self._exposure_s = sensor.exposure_ms * 1e-3
        self._keep_instances = keep_instances
        size = camera.intrinsics
        self._sensor = Sensor(sensor, camera.name, size.width_px, size.height_px, noise_seed)

    def shoot(self, state: Truth) -> tuple[Frame, CameraTruth]:
        """The frame whose mid-exposure is ``state``, and its truth."""
        rendered = self._exposed(state)
        image = self._sensor.expose(self._lens.bend(rendered.image), state.index)
        instances = self._lens.bend_mask(rendered.instances)
        frame = Frame(self._camera.name, state.index, state.time_ns, image)
        return frame, camera_truth(self._camera, state, instances, keep_instances=self._keep_instances)

    def _exposed(self, state: Truth) -> Rendered:
        """The mean of pictures spread evenly over the exposure; identities at its middle."""
        middle = self._renderer.render(state, self._camera.name)
        offsets_s = self._sub_frames_s(state)
        if len(offsets_s) == 1:
            return middle
        others = [self._renderer.render(advanced(state, t), self._camera.name).image for t in offsets_s if t != 0.0]
        return Rendered(_mean([middle.image, *others]), middle.instances)

    def _sub_frames_s(self, state: Truth) -> list[float]:
        """Moments relative to mid-exposure at which pictures are taken: an odd number, 0.0 among them."""
        fastest_mps = float(np.hypot(*state.velocities_mps.T).max(initial=0.0))
        px_per_m = self._camera.intrinsics.fx_px / self._camera.pose.position_m[2]
        half = math.ceil((fastest_mps * self._exposure_s * px_per_m / _SMEAR_PER_PICTURE_PX - 1.0) / 2.0)
        half = max(0, half)
        return [k * self._exposure_s / (2 * half + 1) for k in range(-half, half + 1)]


def advanced(state: Truth, by_s: float) -> Truth:
    """The state a moment later (or earlier), every object moving on straight."""
    moved = state.positions_m.copy()
    moved[:, :2] += state.velocities_mps * by_s
    return replace(state, time_ns=state.time_ns + round(by_s * 1e9), positions_m=moved)


def _mean(images: list[ImageArray]) -> ImageArray:
    total = np.zeros(images[0].shape, np.uint16)
    for image in images:
        total += image
    return ((total + len(images) // 2) // len(images)).astype(np.uint8)
