"""One camera of the road's film: the empty road is kept, road users and their shadows are laid on it.

The camera stands still, so the empty road under a light is drawn once: lit and without its beams, with the mottle of
its surfaces, sky and air. Per frame OpenGL draws road users alone, behind a veil of all that stands upright, which
hides them and throws shadows on them, but is not seen; their shadows on the ground are outlines, filled.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.air import Air, Array32, Weather, rays_of, sky_picture
from sim.body_shapes import Wardrobe
from sim.camera_truth import box_corners
from sim.lights import Light
from sim.mottle import mottle
from sim.renderer import Rendered, Still, Window
from sim.road_scene import KIND_CODES, PartKind
from sim.road_shadow import shadow_mask, thrown
from sim.road_stage import FAR_M, RoadStage, VeilStage, hiding_parts
from sim.road_studio import RoadStudio
from sim.windows import apart, cropped, enclosing, inside, meet, window_of

_SHADOW_REACH_M, _SHADOW_AHEAD_M = 50.0, 35.0
_BOTH_ENDS, _AXES = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), -1).reshape(8, 3), np.arange(3)  # corners of a box
_FLAT = [KIND_CODES[kind] for kind in PartKind if not kind.upright]


@dataclass(frozen=True, eq=False)
class EmptyRoad:
    """The road without users under one light.

    lit, unlit: (H, W, 3) float32 BGR levels, without beams the latter. picture: ``lit`` in whole levels.
    """

    lit: Array32
    unlit: Array32
    picture: ImageArray


@dataclass(frozen=True, eq=False)
class Users:
    """Road users in a part of the picture, as they are seen through the air.

    levels: (h, w, 3) float32 BGR, multiplied by ``opacity`` (h, w). instances: (h, w) as in ``Rendered``.
    """

    levels: Array32
    opacity: Array32
    instances: ImageArray

    def laid_on(self, ground: Array32) -> Array32:
        """Before a picture (h, w, 3)."""
        return np.asarray(ground * (1 - self.opacity[..., None]) + self.levels)


class RoadView:
    """What one camera sees.

    whole: the stage with the whole scene; veil: with its veil.
    """

    def __init__(self, camera: Camera, studio: RoadStudio, whole: RoadStage, veil: VeilStage) -> None:
        self._camera, self._whole, self._veil = camera, whole, veil
        self._hiding = hiding_parts(studio.scene)
        self._wardrobe, self._weather = Wardrobe(studio.seed), studio.weather
        self._rays = rays_of(camera)
        self._stretch = np.linalg.norm(self._rays, axis=2)  # range over depth
        whole.aim(camera)
        whole.put(())
        kinds, depth_m = whole.still_kinds()
        self._things = Still(kinds, tuple(KIND_CODES), frozenset(kind for kind in PartKind if kind.upright))
        self._range_m = self._stretch * np.where(kinds == 0, np.float32(FAR_M), depth_m)
        self._ground = np.isin(kinds, _FLAT)
        points_m = self._rays * depth_m[..., None] + camera.pose.position_m.astype(np.float32)
        grazing = np.maximum(-self._rays[..., 2] / self._stretch, np.float32(0.02))
        size_m = depth_m / np.float32(camera.intrinsics.fx_px) / np.sqrt(grazing)
        self._mottle = mottle(kinds, points_m, size_m, studio.seed)[..., None]
        self._empty: dict[Light, EmptyRoad] = {}
        self._reaches: dict[Light, list[Window | None]] = {}

    def render(self, state: Truth, light: Light) -> Rendered:
        """The users on the empty road."""
        empty = self._empty_road(light)
        image, instances = empty.picture.copy(), np.zeros(empty.picture.shape[:2], np.uint8)
        windows = self._windows(state, light)
        if windows:
            shadow = self._shadow(state, light)
            for window, users in zip(windows, self._users(state, light, windows), strict=True):
                instances[window] = users.instances
                image[window] = as_levels(users.laid_on(self._ground_in(empty, shadow, window)))
        return Rendered(image, instances, empty.picture, tuple(windows), self._things)

    def render_anew(self, state: Truth, light: Light) -> Rendered:
        """The same, everything drawn by OpenGL in one pass, shadows on the ground by its shadow map: the oracle."""
        self._set_up(self._whole, light)
        self._whole.place(state)
        layer = self._whole.layer()
        instances, depth_m = self._whole.identities()
        texture = np.where((instances > 0)[..., None], np.float32(1.0), self._mottle)
        range_m = np.where(instances > 0, depth_m * self._stretch, self._range_m)
        image = self._aired(layer, texture, range_m, light)
        return Rendered(as_levels(image), instances, things=self._things)

    def _empty_road(self, light: Light) -> EmptyRoad:
        if light not in self._empty:
            self._whole.put(())
            self._set_up(self._whole, light)
            lit = self._aired(self._whole.layer(), self._mottle, self._range_m, light)
            unlit = lit
            if light.beams:
                self._set_up(self._whole, light.without_beams())
                unlit = self._aired(self._whole.layer(), self._mottle, self._range_m, light)
            self._empty = {light: EmptyRoad(lit, unlit, as_levels(lit))}
        return self._empty[light]

    def _set_up(self, stage: RoadStage, light: Light) -> None:
        pose = self._camera.pose
        ahead = pose.world_from_camera[:2, 2]
        centre = np.append(pose.position_m[:2] + _SHADOW_AHEAD_M * ahead / max(1e-6, float(np.hypot(*ahead))), 0.0)
        stage.aim(self._camera)
        stage.illuminate(light, centre, _SHADOW_REACH_M)

    def _windows(self, state: Truth, light: Light) -> list[Window]:
        """Where users and their shadows can be seen; no two overlap."""
        feet_m = state.positions_m[:, 2].tolist()
        found = [self._reach(box_m, foot, light) for box_m, foot in zip(box_corners(state), feet_m, strict=True)]
        return apart([window for window in found if window is not None])

    def _reach(self, corners_m: FloatArray, ground_m: float, light: Light) -> Window | None:
        """Where something with these corners (N, 3), and its shadow, can be seen."""
        shadows = [thrown(corners_m, beam, ground_m) for beam in light.beams]
        return window_of(self._camera, np.concatenate([corners_m, *shadows]))

    def _parts_before(self, windows: Sequence[Window], light: Light) -> list[int]:
        """Parts of the veil that may hide or shade something in these parts of the picture."""
        if light not in self._reaches:
            bounds = [
                np.array([part.mesh.vertices_m.min(axis=0), part.mesh.vertices_m.max(axis=0)]) for part in self._hiding
            ]
            found = [self._reach(bound[_BOTH_ENDS, _AXES], float(bound[0, 2]), light) for bound in bounds]
            self._reaches = {light: found}
        reaches = enumerate(self._reaches[light])
        return [number for number, reach in reaches if reach is not None and any(meet(reach, w) for w in windows)]

    def _users(self, state: Truth, light: Light, windows: Sequence[Window]) -> Iterator[Users]:
        """The users alone, in each part of the picture; OpenGL draws no more than the part that encloses them."""
        air = Air.of(self._weather, light)
        around = enclosing(windows)
        parts = [inside(window, around) for window in windows]
        self._set_up(self._veil, light)
        self._veil.aim(cropped(self._camera, around))
        self._veil.place_behind(self._parts_before(windows, light), state)
        layers = self._veil.layers(parts)
        numbers = self._veil.identities_in(parts, depth=not air.is_clear)
        ranges_m = np.linalg.norm(state.positions_m - self._camera.pose.position_m, axis=1).astype(np.float32)
        for window, layer, (instances, depth_m) in zip(windows, layers, numbers, strict=True):
            levels, opacity = layer[..., :3].astype(np.float32), layer[..., 3].astype(np.float32) / np.float32(255.0)
            if air.is_clear:
                range_m = np.append(np.float32(0.0), ranges_m)[with_edges(instances)]
            else:
                range_m = nearest_depth(instances, depth_m) * self._stretch[window]
            yield Users(air.seen_through(levels, range_m, opacity), opacity, instances)

    def _aired(self, layer: ImageArray, texture: Array32, range_m: Array32, light: Light) -> Array32:
        """A layer of the scene (H, W, 4), its surfaces textured, before the sky and through the air."""
        air = Air.of(self._weather, light)
        opacity = layer[..., 3].astype(np.float32) / np.float32(255.0)
        surfaces = air.seen_through(layer[..., :3] * texture, range_m, opacity)
        clear = self._weather is Weather.DRY and bool(light.beams)
        return np.asarray(surfaces + sky_picture(self._camera, air, clear=clear) * (1 - opacity[..., None]))

    def _shadow(self, state: Truth, light: Light) -> ImageArray | None:
        """How much of the beam the users keep from each pixel of the ground, (H, W) uint8 to 255."""
        if not light.beams:
            return None
        pieces = (
            thrown(piece, light.beams[0], float(state.positions_m[row, 2]))
            for row in range(len(state.ids))
            for piece in self._wardrobe.pieces(state, row)
        )
        return shadow_mask(self._camera, pieces)

    def _ground_in(self, empty: EmptyRoad, shadow: ImageArray | None, window: Window) -> Array32:
        """The empty road with the users' shadows."""
        if shadow is None:
            return empty.lit[window]
        share = shadow[window].astype(np.float32)[..., None] * self._ground[window][..., None] / np.float32(255.0)
        return np.asarray(empty.lit[window] + (empty.unlit[window] - empty.lit[window]) * share)


def as_levels(image: Array32) -> ImageArray:
    """Whole levels from 0 to 255."""
    return np.asarray(cv2.convertScaleAbs(np.maximum(image, 0.0)), np.uint8)


def with_edges(instances: ImageArray) -> ImageArray:
    """Identities (H, W), also just beside users, where the edge of one covers a part of a pixel."""
    return np.where(instances > 0, instances, cv2.dilate(instances, np.ones((3, 3), np.uint8)))


def nearest_depth(instances: ImageArray, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depths of users, (H, W), also just beside them, where the edge of one covers a part of a pixel."""
    known = np.where(instances > 0, depth_m, np.float32(FAR_M))
    beside = cv2.erode(known, np.ones((3, 3), np.uint8))
    return np.where(instances > 0, depth_m, beside)
