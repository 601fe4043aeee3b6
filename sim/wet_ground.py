"""The wet ground before one camera, and what it mirrors: the empty scene, kept, and road users, frame by frame."""

from dataclasses import dataclass

import numpy as np

from contracts.truth import Truth
from sim.air import Array32
from sim.camera_truth import box_corners
from sim.glow import added
from sim.lens import EVERYWHERE
from sim.lights import Light
from sim.mirror import Mirror
from sim.moving_lamps import MovingLamps
from sim.renderer import Window
from sim.road_setting import RoadSetting
from sim.road_stage import RoadStage, VeilStage
from sim.sight import Sight
from sim.signals import Shown
from sim.still_view import StillView
from sim.users_view import UsersView
from sim.windows import apart, common, enclosing, inside, meet

_BRIGHTER = 7.0  # so bright are lamps that a picture cuts off at white: their mirror images show it


@dataclass(frozen=True, eq=False)
class Change:
    """What users add to the mirror image: levels (h, w, 3) in a window of the camera's own picture."""

    window: Window
    levels: Array32


@dataclass(frozen=True, eq=False)
class _Empty:
    """The mirror image of the empty scene: sharp in the reflected camera; smeared, in place."""

    sharp: Array32
    in_place: Array32


class WetGround:
    """What lies wet in ``sight``."""

    def __init__(self, sight: Sight, setting: RoadSetting, whole: RoadStage, veil: VeilStage) -> None:
        self._mirror = Mirror(sight, setting.weather, setting.seed)
        self._still = StillView(self._mirror.camera, setting, whole)
        self._users = UsersView(self._mirror.camera, setting, veil)
        self._scene = setting.scene
        self._empty: dict[tuple[Light, Shown], _Empty] = {}

    def laid(
        self,
        ground: Array32,
        light: Light,
        shown: Shown,
        window: Window = EVERYWHERE,
        change: Change | None = None,
    ) -> Array32:
        """The ground (h, w, 3) in a window with what it mirrors while signals show this."""
        picture = self._mirrored(light, shown).in_place[window]
        if change is not None and meet(change.window, window):
            picture = picture.copy()
            shared = common(change.window, window)
            picture[inside(shared, window)] += change.levels[inside(shared, change.window)]
        return self._mirror.laid(ground, picture, window)

    def laid_anew(self, ground: Array32, free: Array32, state: Truth, moving: MovingLamps) -> Array32:
        """The whole picture (H, W, 3), of which users leave the share ``free`` free; the mirror image in one pass."""
        light = moving.light
        picture, instances, _ = self._still.with_users(state, light, moving, on_ground=False)
        lamps = [*self._still.vehicle_spots(state, light, instances), *self._still.street_spots(light)]
        signals = self._still.signal_glow(light, self._scene.shown(state.time_ns))
        picture = picture + _BRIGHTER * (added(lamps, picture.shape) + signals)
        smeared = self._mirror.in_place(self._mirror.smeared(picture))
        return ground + free * (self._mirror.laid(ground, smeared, EVERYWHERE) - ground)

    def change(self, state: Truth, light: Light, moving: MovingLamps) -> Change | None:
        """What users change in the mirror image; None if nothing."""
        found = [self._users.reach(corners_m) for corners_m in box_corners(state)]
        windows = apart([window for window in found if window is not None])
        if not windows:
            return None
        sharp = self._mirrored(light, self._scene.shown(state.time_ns)).sharp
        changed, instances = np.zeros_like(sharp), np.zeros(sharp.shape[:2], np.uint8)
        for window, users in zip(windows, self._users.seen(state, light, moving, windows), strict=True):
            instances[window] = users.instances
            changed[window] = users.levels - users.opacity[..., None] * sharp[window]
        spots = self._still.vehicle_spots(state, light, instances)
        for spot in spots:
            changed[spot.window] += _BRIGHTER * spot.levels
        around = self._mirror.grown(enclosing([*windows, *(spot.window for spot in spots)]))
        smeared = self._mirror.smeared(changed[around])
        return Change(self._mirror.window_in_place(around), self._mirror.in_place(smeared, around))

    def _mirrored(self, light: Light, shown: Shown) -> _Empty:
        if (light, shown) not in self._empty:
            sharp = self._still.empty(light)
            lamps = added(self._still.street_spots(light), sharp.shape) + self._still.signal_glow(light, shown)
            smeared = self._mirror.smeared(sharp + _BRIGHTER * lamps)
            self._empty = {(light, shown): _Empty(sharp, self._mirror.in_place(smeared))}
        return self._empty[light, shown]
