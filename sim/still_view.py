"""What one pinhole sees of a road's own scene under a light: surfaces with their mottle, lamps' light, air and sky."""

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray
from contracts.truth import Truth
from sim.air import Air, Array32, Weather, sky_picture
from sim.body_shapes import Wardrobe
from sim.contact import contact_shade
from sim.glow import Spot, added, signal_spots, street_spots, vehicle_spots
from sim.lamplight import irradiance
from sim.lights import ALBEDO, Light
from sim.mirror import DARKER, is_wet
from sim.mottle import mottle
from sim.moving_lamps import LitGround, MovingLamps
from sim.road_scene import KIND_CODES
from sim.road_setting import RoadSetting
from sim.road_stage import RoadStage
from sim.sight import Sight
from sim.signals import Shown

_SHADOW_REACH_M, _SHADOW_AHEAD_M = 50.0, 35.0
_DIM = frozenset((Weather.RAIN, Weather.FOG))


class StillView:
    """A pinhole before the whole stage."""

    def __init__(self, camera: Camera, setting: RoadSetting, stage: RoadStage) -> None:
        self._stage, self._weather, self._lamps_m = stage, setting.weather, setting.scene.lamps_m
        self._signals = setting.scene.signals
        self._camera, self._wardrobe = camera, Wardrobe(setting.seed)
        self.sight = Sight.of(camera, stage)
        sight = self.sight
        texture = mottle(sight.kinds, sight.points_m, sight.pixel_m, setting.seed)
        self._texture = (texture * _darkened(sight.kinds, setting.weather))[..., None]
        self._lamplight: Array32 | None = None
        self._lit_ground: LitGround | None = None

    @property
    def lit_ground(self) -> LitGround:
        """The ground on which beams fall."""
        if self._lit_ground is None:
            self._lit_ground = LitGround(self.sight)
        return self._lit_ground

    def air(self, light: Light) -> Air:
        """What lies before it all."""
        return Air.of(self._weather, light)

    def empty(self, light: Light) -> Array32:
        """The scene without users, (H, W, 3) levels."""
        self._stage.put(())
        layer = self._drawn(light)
        surfaces = layer[..., :3] * self._texture
        if light.lamplit:
            surfaces += self._drawn(ALBEDO)[..., :3] * self._texture * self._under_lamps(light) + self.sight.shining
        return self._aired(surfaces, layer[..., 3], self.sight.range_m, light)

    def albedo_seen(self, light: Light) -> Array32:
        """Albedo as it comes through the air, (H, W, 3) levels: times an irradiance it is what that adds."""
        self._stage.put(())
        through = self.air(light).transmission(self.sight.range_m)[..., None]
        return np.asarray(self._drawn(ALBEDO)[..., :3] * self._texture * through)

    def darkness(self, light: Light) -> Array32:
        """The light of the air before surfaces of no light, (H, W, 3) levels."""
        return self.air(light).seen_through(np.zeros_like(self.sight.rays), self.sight.range_m)

    def street_spots(self, light: Light) -> list[Spot]:
        """What the luminaires of burning streetlamps add."""
        if not light.lamplit:
            return []
        return list(street_spots(self._camera, self._lamps_m, self.sight.depth_m, self.air(light)))

    def signal_glow(self, light: Light, shown: Shown) -> Array32:
        """What signals add that show this, (H, W, 3) levels."""
        depth_m, air = self.sight.depth_m, self.air(light)
        spots = signal_spots(self._camera, self._signals, shown, depth_m, air, lamplit=light.lamplit)
        return added(spots, (*depth_m.shape, 3))

    def vehicle_spots(self, state: Truth, light: Light, instances: ImageArray) -> list[Spot]:
        """What the lamps of road users add, who have them on in rain and fog, too; instances: who is seen, (H, W)."""
        if not (light.lamplit or self._weather in _DIM):
            return []
        return list(vehicle_spots(self._camera, state, self._wardrobe, instances, self.air(light)))

    def with_users(
        self, state: Truth, light: Light, moving: MovingLamps, *, on_ground: bool
    ) -> tuple[Array32, ImageArray, Array32]:
        """All in one pass, (H, W, 3) levels; identities; share of each pixel that users leave free, (H, W, 1).

        on_ground: with what users do to the ground's light.
        """
        sight, lamplit = self.sight, light.lamplit
        self._stage.put(())
        empty = self._drawn(light)[..., :3].astype(np.float32)
        self._stage.place(state)
        layer = self._drawn(light)
        instances, depth_m = self._stage.identities()
        free = 1 - self._stage.users_share()[..., None]
        surfaces = layer[..., :3].astype(np.float32)
        if light.beams:  # users shade the ground, too: at their edges there is no telling who shows how much
            surfaces *= 1 + free * (self._texture - 1)
        else:
            shade = contact_shade(sight.points_m, state) * sight.ground if on_ground else np.zeros_like(depth_m)
            surfaces += free * empty * (self._texture * (1 - shade[..., None]) - 1)
        if lamplit:
            surfaces += self._lamplit(state, moving, instances, depth_m, free, on_ground=on_ground)
        range_m = np.where(instances > 0, depth_m * sight.stretch, sight.range_m)
        return self._aired(surfaces, layer[..., 3], range_m, light), instances, free

    def _lamplit(
        self,
        state: Truth,
        moving: MovingLamps,
        instances: ImageArray,
        depth_m: NDArray[np.float32],
        free: Array32,
        *,
        on_ground: bool,
    ) -> Array32:
        """What lamps add to surfaces before which users leave the share ``free`` of each pixel free."""
        sight = self.sight
        together = self._drawn(ALBEDO)[..., :3].astype(np.float32)
        self._stage.put(())
        still = free * self._drawn(ALBEDO)[..., :3]
        on_users = (together - still) * moving.on_users(self._camera, depth_m, instances)
        shaded = self._under_lamps(moving.light)
        if on_ground:
            shaded = shaded * (1 - (contact_shade(sight.points_m, state) * sight.ground)[..., None])
            shaded = shaded + (self.lit_ground.under(moving.beams) * sight.ground)[..., None] * moving.head_bgr
        return np.maximum(on_users, 0.0) + still * self._texture * shaded + free * sight.shining

    def _drawn(self, light: Light) -> ImageArray:
        set_up(self._stage, self._camera, light)
        return self._stage.layer()

    def _under_lamps(self, light: Light) -> Array32:
        """What streetlamps throw on what stands still, (H, W, 3)."""
        if self._lamplight is None:
            self._lamplight = irradiance(self.sight.points_m, self.sight.normals, self._lamps_m)
        return self._lamplight[..., None] * np.array(light.lamps[::-1], np.float32)

    def _aired(self, surfaces: Array32, opacity: ImageArray, range_m: NDArray[np.float32], light: Light) -> Array32:
        """Surfaces, multiplied by their opacity to 255 (H, W), through the air and before the sky."""
        air = self.air(light)
        cover = opacity.astype(np.float32) / np.float32(255.0)
        clear = self._weather is Weather.DRY and bool(light.beams)
        seen = air.seen_through(surfaces, range_m, cover)
        return np.asarray(seen + sky_picture(self._camera, air, clear=clear) * (1 - cover[..., None]))


def set_up(stage: RoadStage, camera: Camera, light: Light) -> None:
    """Turn the stage's camera and lights; shadows are right in what the camera sees nearby."""
    ahead = camera.pose.world_from_camera[:2, 2]
    places = camera.pose.position_m[:2] + _SHADOW_AHEAD_M * ahead / max(1e-6, float(np.hypot(*ahead)))
    stage.aim(camera)
    stage.illuminate(light, np.append(places, 0.0), _SHADOW_REACH_M)


def _darkened(kinds: ImageArray, weather: Weather) -> Array32:
    """Factors (H, W) on the albedo by the weather."""
    factors = np.ones(1 + len(KIND_CODES), np.float32)
    if is_wet(weather):
        for kind, factor in DARKER.items():
            factors[KIND_CODES[kind]] = factor
    return factors[kinds]
