"""All light that depends on road users at one moment: their beams on the road, and any lamp's light on them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import Truth
from sim.air import Array32
from sim.body_shapes import Wardrobe
from sim.headlamps import REACH_M, Beam, Lamps, beams_of
from sim.lamplight import irradiance, near
from sim.lights import Light
from sim.renderer import Window
from sim.sight import Sight, normals_of

_HEAD_RGB = (0.98, 1.0, 0.95)  # relative to the strongest channel of the streetlamps
_EVERY_PX = 4  # beams are soft: their light on the road is looked at in so many pixels each way
_BRIGHTEST = 1.2  # irradiance on users towards which beams saturate: nearby they would blind any camera
_FAINT = 4e-3
_FAR_M = 1e4


@dataclass(frozen=True, eq=False)
class MovingLamps:
    """What shines on and from road users. lamps_m: (L, 3) streetlamps. beams: of vehicles."""

    light: Light
    lamps_m: FloatArray
    beams: tuple[Beam, ...] = field(default=())

    @staticmethod
    def of(state: Truth, wardrobe: Wardrobe, light: Light, lamps_m: FloatArray) -> "MovingLamps":
        """All lamps are on or off with the streetlamps."""
        beams = tuple(beams_of(state, Lamps.of(state, wardrobe))) if light.lamplit else ()
        return MovingLamps(light, lamps_m, beams)

    @property
    def head_bgr(self) -> Array32:
        """Colour and level of the beams."""
        return np.array(_HEAD_RGB[::-1], np.float32) * np.float32(max(self.light.lamps))

    def on_users(
        self, points_m: Array32, depth_m: NDArray[np.float32], instances: ImageArray, camera: Camera
    ) -> Array32:
        """Irradiance (h, w, 3) BGR on road users in a part of ``camera``'s picture, and just beside them.

        points_m: (h, w, 3) world, depth_m, instances: (h, w) of what that part shows.
        """
        users = instances > 0
        falling = np.zeros((*users.shape, 3), np.float32)
        if not users.any():
            return falling
        alone_m = np.where(users, depth_m, np.float32(_FAR_M))
        normals = normals_of(points_m, alone_m, camera)[users]
        places = points_m[users]
        street = irradiance(places, normals, near(self.lamps_m, places))[:, None]
        falling[users] = street * np.array(self.light.lamps[::-1], np.float32)
        heads = np.zeros(len(places), np.float32)
        for beam in self.beams:
            close = np.flatnonzero(np.abs(places[:, :2] - beam.position_m[:2].astype(np.float32)).max(axis=1) < REACH_M)
            heads[close] += beam.on(places[close], normals[close])
        falling[users] += (heads / (1 + heads / np.float32(_BRIGHTEST)))[:, None] * self.head_bgr
        return np.where(users[..., None], falling, cv2.dilate(falling, np.ones((3, 3), np.uint8)))


def pool(sight: Sight, beams: Sequence[Beam]) -> Array32:
    """Irradiance of beams on all ground in sight, (H, W)."""
    height, width = sight.kinds.shape
    rows, columns = (np.minimum(np.arange(0, n, _EVERY_PX) + _EVERY_PX // 2, n - 1) for n in (height, width))
    ground = sight.ground[np.ix_(rows, columns)]
    places = sight.points_m[np.ix_(rows, columns)][ground]
    light = np.zeros(len(places), np.float32)
    for beam in beams:
        close = np.flatnonzero(np.abs(places[:, :2] - beam.position_m[:2].astype(np.float32)).max(axis=1) < REACH_M)
        light[close] += beam.on_ground(places[close])
    coarse = np.zeros(ground.shape, np.float32)
    coarse[ground] = light
    fine = cv2.resize(coarse, None, fx=_EVERY_PX, fy=_EVERY_PX, interpolation=cv2.INTER_LINEAR)
    return np.asarray(fine[:height, :width])


def windows_of_light(light: Array32) -> Iterator[Window]:
    """Parts of a picture (H, W) that are lit to speak of."""
    lit = (light > _FAINT).astype(np.uint8)
    count, _, stats, _ = cv2.connectedComponentsWithStats(lit, connectivity=8, ltype=cv2.CV_16U)
    for left, top, width, height, _ in stats[1:count].tolist():
        yield slice(top, top + height), slice(left, left + width)
