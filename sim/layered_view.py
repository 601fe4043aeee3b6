"""One camera of the layered renderer: what is kept of the empty scene, and the vehicles that are laid on it."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.backdrop import Backdrop, Backdrops, film_surfaces
from sim.box_faces import faces_of, nearness_in
from sim.box_rays import SAMPLES_PX, Array32, Box, boxes_of, rays_at, shaded
from sim.box_shadow import BoxShadow
from sim.lights import Beam, Light, ShadowBand
from sim.outlines import covered, window_around
from sim.paint import FACES, darkened, paint_table, painted
from sim.plant_stage import PlantStage
from sim.renderer import Rendered, Window
from sim.scene import Scene
from sim.shade import along_beam, mixed, points_at, world_points
from sim.skyline import Skyline
from sim.still_solids import StillSolids

_NEARER = np.float32(1.0 - 4e-6)  # of boxes that run into each other the first one shows
_COLOURS = slice(1, 5)  # the samples that decide colours; sample 0, the pixel's centre, decides identities


class LayeredView:
    """Pictures of one camera. Between frames the buffers hold the empty scene.

    near: (S, H, W) one over the depth in metres of the nearest surface at each of ``SAMPLES_PX``.
    owner: (S, H, W) 0 for the scene, 1 + FACES * row + axis for a vehicle's face.
    shade: (S, H, W) bit b is set where a vehicle keeps beam b away.
    """

    def __init__(self, camera: Camera, scene: Scene, stage: PlantStage) -> None:
        self._camera = camera
        surfaces = film_surfaces(stage, camera)
        self._edge, self._shares = surfaces.edge, surfaces.shares
        self._skyline = Skyline(camera, surfaces.depth_m)
        self._near = np.float32(1.0) / surfaces.depth_m
        self._owner = np.zeros(self._near.shape, np.uint16)
        self._shade = np.zeros(self._near.shape, np.uint8)
        self._before: list[tuple[Window, Array32]] = []  # how near the scene was where vehicles now are
        self._still_solids = StillSolids(scene)
        self._backdrops = Backdrops(camera, scene, stage)
        self._across: tuple[tuple[float, float, float], Array32] | None = None

    def render(self, state: Truth, light: Light) -> Rendered:
        """The world at ``state`` under ``light``."""
        backdrop = self._backdrops.of(state, light)
        image = self._background(backdrop, light)
        instances = np.zeros(image.shape[:2], np.uint8)
        boxes = boxes_of(state)
        bodies = [self._place(row, box) for row, box in enumerate(boxes)]
        shadows = [self._cast(row, box, light) for row, box in enumerate(boxes)]
        for row, (box, body) in enumerate(zip(boxes, bodies, strict=True)):
            if body is not None:
                self._shade_by_scene(row, box, body, light)
        touched = _united(bodies, shadows)
        table = paint_table(state, boxes, light, self._camera)
        for window in touched:
            image[window] = self._resolved(window, backdrop, table, light)
            instances[window] = (self._owner[0][window] + (FACES - 1)) // FACES
        self._clear(touched)
        changes = light.factor != 1.0 or light.band is not None
        return Rendered(image, instances, None if changes else backdrop.lit, tuple(touched))

    def _place(self, row: int, box: Box) -> Window | None:
        """Let a vehicle own the samples at which it is nearest; the window in which it may be."""
        faces = faces_of(box, self._camera)
        window = window_around(self._camera, faces.points_px)
        if window is None:
            return None
        everywhere = (slice(None), *window)
        near, owner = self._near[everywhere], self._owner[everywhere]
        self._before.append((window, near.copy()))
        covers = covered(faces.outlines_px, window, SAMPLES_PX)  # (F, S, h, w)
        entry = nearness_in(faces, window, SAMPLES_PX)
        nearest = covers.any(axis=0)
        nearest &= entry * _NEARER > near
        np.copyto(near, entry, where=nearest)
        for axis, face in zip(faces.axes, covers, strict=True):
            np.copyto(owner, np.uint16(1 + FACES * row + axis), where=face & nearest)
        return window

    def _cast(self, row: int, box: Box, light: Light) -> list[Window]:
        """Mark the samples from which a vehicle keeps each beam; the windows in which they may be.

        Its own faces know by themselves how they are turned.
        """
        windows = []
        for bit, beam in enumerate(light.beams):
            shadow = BoxShadow(box, beam, self._camera)
            outline = shadow.outline_px()
            window = window_around(self._camera, outline)
            if window is not None:
                windows.append(window)
                self._shade[(_COLOURS, *window)] |= self._shaded(row, shadow, outline, window).view(np.uint8) << bit
        return windows

    def _shaded(self, row: int, shadow: BoxShadow, outline: FloatArray, window: Window) -> BoolArray:
        """Which samples (S, h, w) of a window lie in the shadow of vehicle ``row``; ``outline`` holds them all."""
        owner = self._owner[(_COLOURS, *window)]
        inner = shadow.sure_px(self._skyline.below_m(window))
        possible, *certain = covered((outline, *inner), window, SAMPLES_PX[_COLOURS])
        shade = np.logical_and.reduce([owner == 0, *certain]) if certain else np.zeros(owner.shape, np.bool_)
        possible &= ~shade
        possible &= owner - np.uint16(1 + FACES * row) >= FACES  # not its own: numbers below wrap round
        self._look(possible, shadow.box, shadow.beam, window, shade)
        return shade

    def _shade_by_scene(self, row: int, box: Box, window: Window, light: Light) -> None:
        """Mark the samples of a vehicle from which what stands still keeps a beam."""
        samples = (_COLOURS, *window)
        for bit, beam in enumerate(light.beams):
            solids = self._still_solids.before(box, beam)
            if not solids:
                continue
            sample, v, u = np.nonzero(self._owner[samples] - np.uint16(1 + FACES * row) < FACES)
            du, dv = SAMPLES_PX[_COLOURS][sample].T
            depth_m = np.float32(1.0) / self._near[samples][sample, v, u]
            points = points_at(self._camera, u + window[1].start + du, v + window[0].start + dv, depth_m)
            dark = np.logical_or.reduce([solid.shades(points, beam) for solid in solids])
            self._shade[samples][sample, v, u] |= dark.view(np.uint8) << bit

    def _look(self, at: BoolArray, box: Box, beam: Beam, window: Window, shade: BoolArray) -> None:
        """Look sample by sample, where ``at`` (S, h, w) says so, whether a box keeps a beam away: into ``shade``."""
        chosen = np.flatnonzero(at)
        sample, pixel = np.divmod(chosen, at[0].size)
        v, u = np.divmod(pixel, at.shape[2])
        du, dv = SAMPLES_PX[_COLOURS][sample].T
        rays = rays_at(self._camera, u + window[1].start + du, v + window[0].start + dv, box)
        near = self._near[(_COLOURS, *window)][sample, v, u]
        shade.reshape(-1)[chosen] = shaded(rays, np.float32(1.0) / near, box, beam)

    def _clear(self, touched: Sequence[Window]) -> None:
        """Leave the empty scene behind."""
        for window in touched:
            self._owner[(slice(None), *window)] = 0
            self._shade[(slice(None), *window)] = 0
        while self._before:
            window, near = self._before.pop()
            self._near[(slice(None), *window)] = near

    def _resolved(self, window: Window, backdrop: Backdrop, table: Array32, light: Light) -> ImageArray:
        """The colours (h, w, 3) of a window: the mean of four samples, each of the scene or of a face."""
        combinations = np.uint16(table.shape[1])
        code = self._owner[(_COLOURS, *window)] * combinations
        lit = [
            _exposed(picture, light)
            for picture in darkened(backdrop.lit[window], [share[window] for share in backdrop.shares])
        ]
        image = self._painted(window, code | self._shade[(_COLOURS, *window)], lit, table)
        if light.band is None:
            return image
        unlit = [_exposed(backdrop.unlit[window], light)]
        dark = self._painted(window, code // combinations, unlit, table[:, -1:])
        return mixed(image, dark, self._band_shade(window, light.band, light))

    def _painted(
        self, window: Window, code: NDArray[np.uint16], scene: Sequence[ImageArray], table: Array32
    ) -> ImageArray:
        return painted(code, scene, table, edge=self._edge[window], shares=self._shares)

    def _background(self, backdrop: Backdrop, light: Light) -> ImageArray:
        """The empty scene, a fresh picture."""
        if light.band is not None:
            weight = light.band.profile(self._coordinate(light.band, light))
            image = cv2.blendLinear(backdrop.unlit, backdrop.lit, weight, 1.0 - weight)
            return _exposed(np.asarray(image, np.uint8), light)
        image = _exposed(backdrop.lit, light)
        return image.copy() if image is backdrop.lit else image

    def _band_shade(self, window: Window, band: ShadowBand, light: Light) -> FloatArray:
        """How much of the beams the band takes away at what now shows in the window, (h, w)."""
        depth_m = np.float32(1.0) / self._near[0][window]
        points = world_points(self._camera, depth_m, top_px=window[0].start, left_px=window[1].start)
        return band.shade(along_beam(points, light.beams[0]))

    def _coordinate(self, band: ShadowBand, light: Light) -> Array32:
        """The empty scene's coordinate across the band, (H, W); kept, since bands move but do not turn."""
        key = (band.across_rad, light.beams[0].azimuth_rad, light.beams[0].elevation_rad)
        if self._across is None or self._across[0] != key:
            ground = along_beam(world_points(self._camera, np.float32(1.0) / self._near[0]), light.beams[0])
            self._across = (key, band.coordinate(ground).astype(np.float32))
        return self._across[1]


def _exposed(picture: ImageArray, light: Light) -> ImageArray:
    """A picture, or a part of one, in the light's strength."""
    if light.factor == 1.0:
        return picture
    return np.asarray(cv2.convertScaleAbs(picture, alpha=light.factor), np.uint8)


def _united(bodies: Sequence[Window | None], shadows: Sequence[Sequence[Window]]) -> list[Window]:
    """For each vehicle that the picture shows something of, the smallest window around it and its shadows."""
    united = []
    for body, cast in zip(bodies, shadows, strict=True):
        parts = [*cast] if body is None else [body, *cast]
        if parts:
            rows, columns = zip(*parts, strict=True)
            united.append((_around(rows), _around(columns)))
    return united


def _around(ranges: Sequence[slice]) -> slice:
    return slice(min(part.start for part in ranges), max(part.stop for part in ranges))
