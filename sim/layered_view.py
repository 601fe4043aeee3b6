"""One camera of the layered renderer: what is kept of the empty scene, and the vehicles that are laid on it."""

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.backdrop import Backdrop, Backdrops, film_depth
from sim.box_rays import SAMPLES_PX, Array32, Box, boxes_of, rays_through, seen, shaded, window_of
from sim.lights import Light, ShadowBand
from sim.paint import FACES, mean_of_samples, paint_table
from sim.renderer import Rendered, Window
from sim.scene import FLOOR_Z_M, Scene
from sim.shade import along_beam, world_points
from sim.stage import Stage

_SAME_DEPTH_M = np.float32(1e-5)  # of boxes that run into each other the first one shows
_COLOURS = slice(1, 5)  # the samples that decide colours; sample 0, the pixel's centre, decides identities


class LayeredView:
    """Pictures of one camera. Between frames the buffers hold the empty scene.

    depth: (S, H, W) of the nearest surface at each of ``SAMPLES_PX``, metres.
    owner: (S, H, W) 0 for the scene, 1 + FACES * row + axis for a vehicle's face.
    shade: (S, H, W) bit b is set where a vehicle keeps beam b away.
    """

    def __init__(self, camera: Camera, scene: Scene, stage: Stage) -> None:
        self._camera = camera
        self._depth = film_depth(stage, camera)
        self._owner = np.zeros(self._depth.shape, np.uint16)
        self._shade = np.zeros(self._depth.shape, np.uint8)
        self._backdrops = Backdrops(camera, scene, stage)
        self._across: tuple[tuple[float, float, float], Array32] | None = None

    def render(self, state: Truth, light: Light) -> Rendered:
        """The world at ``state`` under ``light``."""
        backdrop = self._backdrops.of(state, light)
        image = self._background(backdrop, light)
        instances = np.zeros(image.shape[:2], np.uint8)
        boxes = boxes_of(state)
        windows = [window_of(self._camera, _reached(box, light)) for box in boxes]
        touched = [window for window in windows if window is not None]
        before = [self._depth[(slice(None), *window)].copy() for window in touched]
        for row, box in enumerate(boxes):
            self._place(row, box)
        for row, (box, window) in enumerate(zip(boxes, windows, strict=True)):
            if window is not None:
                self._cast(row, box, window, light)
        table = paint_table(state, boxes, light, self._camera)
        for window in touched:
            image[window] = self._resolved(window, backdrop, table, light)
            instances[window] = (self._owner[0][window] + (FACES - 1)) // FACES
        for window, depth in zip(reversed(touched), reversed(before), strict=True):
            everywhere = (slice(None), *window)
            self._owner[everywhere], self._shade[everywhere], self._depth[everywhere] = 0, 0, depth
        changes = light.factor != 1.0 or light.band is not None
        return Rendered(image, instances, None if changes else backdrop.lit, tuple(touched))

    def _place(self, row: int, box: Box) -> None:
        """Let a vehicle own the samples at which it is nearest."""
        window = window_of(self._camera, box.corners_m)
        if window is None:
            return
        everywhere = (slice(None), *window)
        depth, axis = seen(rays_through(self._camera, window, box), box)
        nearest = depth < self._depth[everywhere] - _SAME_DEPTH_M
        np.copyto(self._depth[everywhere], depth, where=nearest)
        np.copyto(self._owner[everywhere], axis + np.uint16(1 + FACES * row), where=nearest)

    def _cast(self, row: int, box: Box, window: Window, light: Light) -> None:
        """Mark the samples that a vehicle keeps a beam from; its own faces know by themselves how they are turned."""
        if not light.beams:
            return
        samples = (_COLOURS, *window)
        rays = rays_through(self._camera, window, box, SAMPLES_PX[_COLOURS])
        others = (self._owner[samples] + np.uint16(FACES - 1)) // np.uint16(FACES) != row + 1
        for bit, beam in enumerate(light.beams):
            self._shade[samples] |= (shaded(rays, self._depth[samples], box, beam) & others).view(np.uint8) << bit

    def _resolved(self, window: Window, backdrop: Backdrop, table: Array32, light: Light) -> NDArray[np.uint8]:
        """The colours (h, w, 3) of a window: the mean of four samples, each of the scene or of a face."""
        owner, shade = self._owner[(_COLOURS, *window)], self._shade[(_COLOURS, *window)]
        shares = [share[window] for share in backdrop.shares]
        image = mean_of_samples(
            owner, shade, scene=backdrop.lit[window], shares=shares, table=table, factor=light.factor
        )
        if light.band is not None:
            dark = np.full_like(shade, (1 << len(light.beams)) - 1)
            unlit = mean_of_samples(
                owner, dark, scene=backdrop.unlit[window], shares=(), table=table, factor=light.factor
            )
            weight = self._band_shade(window, light.band, light)[..., None]
            image += (unlit - image) * weight
        return np.rint(image).astype(np.uint8)

    def _background(self, backdrop: Backdrop, light: Light) -> ImageArray:
        """The empty scene, a fresh picture."""
        image = backdrop.lit.copy()
        if light.factor != 1.0:
            cv2.convertScaleAbs(backdrop.lit, image, alpha=light.factor)
        if light.band is not None:
            weight = light.band.profile(self._coordinate(light.band, light))
            image = np.asarray(cv2.blendLinear(backdrop.unlit, backdrop.lit, weight, 1.0 - weight), np.uint8)
        return image

    def _band_shade(self, window: Window, band: ShadowBand, light: Light) -> FloatArray:
        """How much of the beams the band takes away at what now shows in the window, (h, w)."""
        points = world_points(self._camera, self._depth[0][window], top_px=window[0].start, left_px=window[1].start)
        return band.shade(along_beam(points, light.beams[0]))

    def _coordinate(self, band: ShadowBand, light: Light) -> Array32:
        """The empty scene's coordinate across the band, (H, W); kept, since bands move but do not turn."""
        key = (band.across_rad, light.beams[0].azimuth_rad, light.beams[0].elevation_rad)
        if self._across is None or self._across[0] != key:
            ground = along_beam(world_points(self._camera, self._depth[0]), light.beams[0])
            self._across = (key, band.coordinate(ground).astype(np.float32))
        return self._across[1]


def _reached(box: Box, light: Light) -> FloatArray:
    """Points (N, 3) around all that a vehicle can change: its box and its shadows on the ground."""
    corners = box.corners_m
    floor = np.array([0.0, 0.0, FLOOR_Z_M])
    shadows = [
        np.column_stack([along_beam(corners - floor, beam), np.full(len(corners), FLOOR_Z_M)]) for beam in light.beams
    ]
    return np.concatenate([corners, *shadows])
