"""What one pinhole sees of road users alone: OpenGL draws them behind a veil of all that stands upright."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.air import Air, Array32, in_colour, rays_of
from sim.lights import ALBEDO, Beam, Light
from sim.moving_lamps import MovingLamps
from sim.renderer import Window
from sim.road_setting import RoadSetting
from sim.road_shadow import thrown
from sim.road_stage import FAR_M, VeilStage, hiding_parts
from sim.still_view import set_up
from sim.windows import cropped, enclosing, inside, meet, window_of

_BOTH_ENDS, _AXES = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1]), -1).reshape(8, 3), np.arange(3)  # corners of a box


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
        return np.asarray(ground * in_colour(1 - self.opacity) + self.levels)


class UsersView:
    """A pinhole before the veiled stage."""

    def __init__(self, camera: Camera, setting: RoadSetting, veil: VeilStage) -> None:
        self._camera, self._veil, self._weather = camera, veil, setting.weather
        self._hiding = hiding_parts(setting.scene)
        self._stretch = np.linalg.norm(rays_of(camera), axis=2)  # range over depth
        self._reaches: dict[Light, list[Window | None]] = {}

    def reach(self, corners_m: FloatArray, beams: Sequence[Beam] = ()) -> Window | None:
        """Where something with these corners (N, 3), and its shadows on the ground, can be seen."""
        ground_m = float(corners_m[:, 2].min())
        shadows = [thrown(corners_m, beam, ground_m) for beam in beams]
        return window_of(self._camera, np.concatenate([corners_m, *shadows]))

    def seen(self, state: Truth, light: Light, moving: MovingLamps, windows: Sequence[Window]) -> Iterator[Users]:
        """The users alone, in each part of the picture; OpenGL draws no more than the part that encloses them."""
        air = Air.of(self._weather, light)
        around = enclosing(windows)
        parts = [inside(window, around) for window in windows]
        crop = cropped(self._camera, around)
        self._veil.place_behind(self._parts_before(windows, light), state)
        set_up(self._veil, self._camera, light)
        self._veil.aim(crop)
        layers = self._veil.layers(parts)
        albedos = layers
        if light.lamplit:
            set_up(self._veil, self._camera, ALBEDO)
            self._veil.aim(crop)
            albedos = self._veil.layers(parts)
        numbers = self._veil.identities_in(parts, depth=light.lamplit or not air.is_clear)
        ranges_m = np.linalg.norm(state.positions_m - self._camera.pose.position_m, axis=1).astype(np.float32)
        for window, layer, albedo, (instances, depth_m) in zip(windows, layers, albedos, numbers, strict=True):
            levels, opacity = layer[..., :3].astype(np.float32), layer[..., 3].astype(np.float32) / np.float32(255.0)
            if light.lamplit:
                levels += albedo[..., :3] * moving.on_users(cropped(self._camera, window), depth_m, instances)
            if air.is_clear:
                range_m = np.append(np.float32(0.0), ranges_m)[with_edges(instances)]
            else:
                range_m = nearest_depth(instances, depth_m) * self._stretch[window]
            yield Users(air.seen_through(levels, range_m, opacity), opacity, instances)

    def _parts_before(self, windows: Sequence[Window], light: Light) -> list[int]:
        """Parts of the veil that may hide or shade something in these parts of the picture."""
        if light not in self._reaches:
            bounds = [
                np.array([part.mesh.vertices_m.min(axis=0), part.mesh.vertices_m.max(axis=0)]) for part in self._hiding
            ]
            found = [self.reach(bound[_BOTH_ENDS, _AXES], light.beams) for bound in bounds]
            self._reaches = {light: found}
        reaches = enumerate(self._reaches[light])
        return [number for number, reach in reaches if reach is not None and any(meet(reach, w) for w in windows)]


def with_edges(instances: ImageArray) -> ImageArray:
    """Identities (H, W), also just beside users, where the edge of one covers a part of a pixel."""
    return np.where(instances > 0, instances, cv2.dilate(instances, np.ones((3, 3), np.uint8)))


def nearest_depth(instances: ImageArray, depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depths of users, (H, W), also just beside them, where the edge of one covers a part of a pixel."""
    known = np.where(instances > 0, depth_m, np.float32(FAR_M))
    beside = cv2.erode(known, np.ones((3, 3), np.uint8))
    return np.where(instances > 0, depth_m, beside)
