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
from sim.headlamps import Beam, Lamps, beams_of
from sim.lamplight import irradiance, near
from sim.lights import Light
from sim.renderer import Window
from sim.sight import Sight, surfaces_at

_HEAD_RGB = (0.98, 1.0, 0.95)  # relative to the strongest channel of the streetlamps
_EVERY_PX = 4  # each way
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

    def on_users(self, camera: Camera, depth_m: NDArray[np.float32], instances: ImageArray) -> Array32:
        """Irradiance (h, w, 3) BGR on the road users that a pinhole shows, and just beside them.

        depth_m, instances: (h, w).
        """
        users = instances > 0
        falling = np.zeros((*users.shape, 3), np.float32)
        if not users.any():
            return falling
        points_m, normals = surfaces_at(camera, np.where(users, depth_m, np.float32(_FAR_M)), users)
        heads = np.zeros(len(points_m), np.float32)
        for beam in self.beams:
            heads += beam.on(points_m, normals)
        heads /= 1 + heads / np.float32(_BRIGHTEST)
        street = irradiance(points_m, normals, near(self.lamps_m, points_m))
        light = np.array([self.light.lamps[::-1], self.head_bgr], np.float32)
        falling[users] = np.stack([street, heads], axis=1) @ light
        beside = cv2.dilate(falling, np.ones((3, 3), np.uint8))
        beside[users] = falling[users]
        return np.asarray(beside)


class LitGround:
    """The ground in sight, on which beams fall: they are soft, so every few pixels will do."""

    def __init__(self, sight: Sight) -> None:
        self._shape = sight.kinds.shape
        rows, columns = (np.minimum(np.arange(0, n, _EVERY_PX) + _EVERY_PX // 2, n - 1) for n in self._shape)
        self._lies = sight.ground[np.ix_(rows, columns)]
        self._points_m = np.ascontiguousarray(sight.points_m[np.ix_(rows, columns)][self._lies].T).T

    def under(self, beams: Sequence[Beam]) -> Array32:
        """Irradiance of beams, (H, W); it reaches beyond the ground's edge by a few pixels."""
        light = np.zeros(len(self._points_m), np.float32)
        for beam in beams:
            light += beam.on_ground(self._points_m)
        coarse = np.zeros(self._lies.shape, np.float32)
        coarse[self._lies] = light
        fine = cv2.resize(coarse, None, fx=_EVERY_PX, fy=_EVERY_PX, interpolation=cv2.INTER_LINEAR)
        return np.asarray(fine[: self._shape[0], : self._shape[1]])


def windows_of_light(light: Array32) -> Iterator[Window]:
    """Parts of a picture (H, W) that are lit to speak of."""
    lit = (light > _FAINT).astype(np.uint8)
    count, _, stats, _ = cv2.connectedComponentsWithStats(lit, connectivity=8, ltype=cv2.CV_16U)
    for left, top, width, height, _ in stats[1:count].tolist():
        yield slice(top, top + height), slice(left, left + width)
