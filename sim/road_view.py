"""One camera of the road's film: the empty road is kept, road users and what they do to the light are laid on it.

The camera stands still, so the empty road under a light is drawn once, with sky and air, the light of its lamps and
what its wet ground mirrors. Per frame OpenGL draws road users alone; their shadows on the ground are outlines, filled.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from contracts import Camera, ImageArray
from contracts.truth import Truth
from sim.air import Array32, in_colour
from sim.body_shapes import Wardrobe
from sim.camera_truth import box_corners
from sim.contact import shade_corners, shade_of
from sim.glow import Spot, added
from sim.lights import Light
from sim.mirror import is_wet
from sim.moving_lamps import MovingLamps, windows_of_light
from sim.renderer import Rendered, Still, Window
from sim.road_scene import KIND_CODES, PartKind
from sim.road_setting import RoadSetting
from sim.road_shadow import shadow_mask, thrown
from sim.road_stage import RoadStage, VeilStage
from sim.signals import Shown
from sim.still_view import StillView
from sim.users_view import UsersView
from sim.wet_ground import Change, WetGround
from sim.windows import apart, common, inside, meet, window_of


@dataclass(frozen=True, eq=False)
class EmptyRoad:
    """The road without users under one light while its signals do not change; (H, W, 3) float32 BGR levels throughout.

    lit, unlit: without beams the latter, both without what wet ground mirrors.
    dark: without any light on its surfaces; signals shine in all three.
    albedo: times an irradiance it is what a lamp adds; none without lamps.
    glow: what its lamps spread over everything; none without lamps.
    picture: all of it in whole levels.
    """

    lit: Array32
    unlit: Array32
    dark: Array32
    albedo: Array32 | None
    glow: Array32 | None
    picture: ImageArray


class RoadView:
    """What one camera sees.

    whole: the stage with the whole scene; veil: with its veil.
    """

    def __init__(self, camera: Camera, setting: RoadSetting, whole: RoadStage, veil: VeilStage) -> None:
        self._camera = camera
        self._wardrobe, self._scene = Wardrobe(setting.seed), setting.scene
        self._still, self._users = StillView(camera, setting, whole), UsersView(camera, setting, veil)
        self._sight = self._still.sight
        self._wet = WetGround(self._sight, setting, whole, veil) if is_wet(setting.weather) else None
        self._things = Still(self._sight.kinds, tuple(KIND_CODES), frozenset(kind for kind in PartKind if kind.upright))
        self._empty: dict[tuple[Light, Shown], EmptyRoad] = {}

    def render(self, state: Truth, light: Light) -> Rendered:
        """The users on the empty road."""
        empty = self._empty_road(light, self._scene.shown(state.time_ns))
        image, instances = empty.picture.copy(), np.zeros(empty.picture.shape[:2], np.uint8)
        places = self._places(state, light)
        if not places:
            return Rendered(image, instances, empty.picture, (), self._things)
        moving = MovingLamps.of(state, self._wardrobe, light, self._scene.lamps_m)
        layers = list(zip(places, self._users.seen(state, light, moving, places), strict=True))
        for place, users in layers:
            instances[place] = users.instances
        spots = self._still.vehicle_spots(state, light, instances)
        ground = _Ground(
            self._shadow(state, light),
            self._still.lit_ground.under(moving.beams) if moving.beams else None,
            None if self._wet is None else self._wet.change(state, light, moving),
        )
        windows = apart([*places, *(spot.window for spot in spots), *ground.windows])
        for window in windows:
            part = self._ground_in(window, empty, ground, state, moving)
            for place, users in layers:
                if meet(place, window):
                    there = inside(place, window)
                    part[there] = users.laid_on(part[there])
            image[window] = as_levels(_shining(part, window, empty, spots))
        return Rendered(image, instances, empty.picture, tuple(windows), self._things)

    def render_anew(self, state: Truth, light: Light) -> Rendered:
        """The same, everything drawn by OpenGL in one pass, shadows on the ground by its shadow map: the oracle."""
        moving = MovingLamps.of(state, self._wardrobe, light, self._scene.lamps_m)
        image, instances, free = self._still.with_users(state, light, moving, on_ground=True)
        image = image + free * self._still.signal_glow(light, self._scene.shown(state.time_ns))
        if self._wet is not None:
            image = self._wet.laid_anew(image, free, state, moving)
        lamps = [*self._still.vehicle_spots(state, light, instances), *self._still.street_spots(light)]
        return Rendered(as_levels(image + added(lamps, image.shape)), instances, things=self._things)

    def _empty_road(self, light: Light, shown: Shown) -> EmptyRoad:
        if (light, shown) not in self._empty:
            self._empty = {(light, shown): self._drawn_empty(light, shown)}
        return self._empty[light, shown]

    def _drawn_empty(self, light: Light, shown: Shown) -> EmptyRoad:
        signals = self._still.signal_glow(light, shown)
        lit = self._still.empty(light) + signals
        picture = lit if self._wet is None else self._wet.laid(lit, light, shown)
        glow = added(self._still.street_spots(light), lit.shape) if light.lamplit else None
        return EmptyRoad(
            lit=lit,
            unlit=self._still.empty(light.without_beams()) + signals if light.beams else lit,
            dark=self._still.darkness(light) + signals,
            albedo=self._still.albedo_seen(light) if light.lamplit else None,
            glow=glow,
            picture=as_levels(picture if glow is None else picture + glow),
        )

    def _places(self, state: Truth, light: Light) -> list[Window]:
        """Where users and their shadows can be seen; no two overlap."""
        found = []
        for row, box_m in enumerate(box_corners(state)):
            around = box_m if light.beams else np.concatenate([box_m, shade_corners(state, row)])
            found.append(self._users.reach(around, light.beams))
        return apart([window for window in found if window is not None])

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

    def _ground_in(
        self, window: Window, empty: EmptyRoad, ground: "_Ground", state: Truth, moving: MovingLamps
    ) -> Array32:
        """The empty road with all that users do to its light, (h, w, 3) to write on."""
        lit = empty.lit[window]
        if ground.shadow is not None:
            share = ground.shadow[window].astype(np.float32) * self._sight.ground[window] / np.float32(255.0)
            part = lit + (empty.unlit[window] - lit) * share[..., None]
        else:
            part = lit.copy()
            self._shade_contacts(part, window, empty, state)
        if ground.pool is not None and empty.albedo is not None:
            for lit_window in ground.lit_windows:
                if meet(lit_window, window):
                    shared = common(lit_window, window)
                    falling = ground.pool[shared] * self._sight.ground[shared]
                    part[inside(shared, window)] += empty.albedo[shared] * in_colour(falling, moving.head_bgr)
        if self._wet is None:
            return part
        return self._wet.laid(part, moving.light, self._scene.shown(state.time_ns), window, ground.mirrored)

    def _shade_contacts(self, part: Array32, window: Window, empty: EmptyRoad, state: Truth) -> None:
        """Take from a part of the ground (h, w, 3), written on, what users keep from it of the sky's light."""
        for row in range(len(state.ids)):
            near = window_of(self._camera, shade_corners(state, row))
            if near is not None and meet(near, window):
                shared = common(near, window)
                shade = shade_of(self._sight.points_m[shared], state, row) * self._sight.ground[shared]
                there = part[inside(shared, window)]
                there += (empty.dark[shared] - there) * in_colour(shade)


@dataclass(frozen=True, eq=False)
class _Ground:
    """What users do to the light of the ground.

    shadow: (H, W) uint8 share of the beam to 255. pool: (H, W) irradiance of their lamps. mirrored: in the wet.
    """

    shadow: ImageArray | None
    pool: Array32 | None
    mirrored: Change | None

    @cached_property
    def lit_windows(self) -> list[Window]:
        """Where their lamps throw light."""
        return [] if self.pool is None else list(windows_of_light(self.pool))

    @property
    def windows(self) -> list[Window]:
        """Where any of it may be seen away from the users."""
        return self.lit_windows if self.mirrored is None else [*self.lit_windows, self.mirrored.window]


def _shining(part: Array32, window: Window, empty: EmptyRoad, spots: Sequence[Spot]) -> Array32:
    """A part of the picture (h, w, 3), written on, with the light that lamps spread over it."""
    if empty.glow is not None:
        part += empty.glow[window]
    for spot in spots:
        if meet(spot.window, window):
            part[inside(spot.window, window)] += spot.levels
    return part


def as_levels(image: Array32) -> ImageArray:
    """Whole levels from 0 to 255."""
    return np.asarray(cv2.convertScaleAbs(np.maximum(image, 0.0)), np.uint8)
