"""What a camera sees of a still scene, pixel by pixel: kinds, places, and which way surfaces face."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray
from sim.air import Array32, rays_of
from sim.road_scene import KIND_CODES, PartKind
from sim.road_stage import FAR_M, RoadStage

_FLAT = [KIND_CODES[kind] for kind in PartKind if not kind.upright]
_UP = np.array([0.0, 0.0, 1.0], np.float32)


@dataclass(frozen=True, eq=False)
class Sight:
    """A pinhole's view on a scene without users.

    kinds: (H, W) codes of ``KIND_CODES``, 0 for the sky. depth_m: (H, W) along the axis.
    shining: (H, W, 3) BGR levels that parts send out by themselves when lamps are on.
    """

    camera: Camera
    kinds: ImageArray
    depth_m: NDArray[np.float32]
    shining: ImageArray

    @staticmethod
    def of(camera: Camera, stage: RoadStage) -> "Sight":
        """Look from ``camera`` at the stage's own scene."""
        stage.aim(camera)
        stage.put(())
        return Sight(camera, *stage.still_kinds(), stage.still_shining())

    @cached_property
    def rays(self) -> Array32:
        """Where pixels look, (H, W, 3) world, of unit depth."""
        return rays_of(self.camera)

    @cached_property
    def stretch(self) -> Array32:
        """Range over depth, (H, W)."""
        return np.asarray(np.linalg.norm(self.rays, axis=2))

    @cached_property
    def range_m(self) -> Array32:
        """How far away what each pixel shows is, (H, W); the sky is at the end of the world."""
        return np.asarray(self.stretch * np.where(self.kinds == 0, np.float32(FAR_M), self.depth_m))

    @cached_property
    def points_m(self) -> Array32:
        """What each pixel shows, (H, W, 3) world."""
        return self.rays * self.depth_m[..., None] + self.camera.pose.position_m.astype(np.float32)

    @cached_property
    def ground(self) -> NDArray[np.bool_]:
        """Where something lies rather than stands, (H, W)."""
        return np.isin(self.kinds, _FLAT)

    @cached_property
    def normals(self) -> Array32:
        """Which way surfaces face, (H, W, 3): up where they lie, and 0 in the sky."""
        found = normals_of(self.points_m, self.depth_m, self.camera)
        found[self.ground] = _UP
        found[self.kinds == 0] = 0.0
        return found

    @cached_property
    def pixel_m(self) -> Array32:
        """Length of a pixel on the surface, (H, W), the mean of along and across."""
        grazing = np.maximum(-self.rays[..., 2] / self.stretch, np.float32(0.02))
        return np.asarray(self.depth_m / np.float32(self.camera.intrinsics.fx_px) / np.sqrt(grazing))


def normals_of(points_m: Array32, depth_m: Array32, camera: Camera) -> Array32:
    """Unit normals (H, W, 3) of the surfaces through neighbouring pixels, towards the camera.

    points_m: (H, W, 3) world; depth_m: (H, W), of which the smaller step to either side decides on an edge.
    """
    across = _step(points_m, depth_m, axis=1)
    along = _step(points_m, depth_m, axis=0)
    normals = np.cross(across, along)
    normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), np.float32(1e-12))
    inward = ((points_m - camera.pose.position_m.astype(np.float32)) * normals).sum(axis=2) > 0
    normals[inward] *= -1
    return np.asarray(normals)


def _step(points_m: Array32, depth_m: Array32, *, axis: int) -> Array32:
    """From each pixel to its neighbour along an axis, (H, W, 3): to the side on which the depth changes less."""
    if points_m.shape[axis] < 2:
        return np.zeros_like(points_m)
    steps, jumps = np.diff(points_m, axis=axis), np.abs(np.diff(depth_m, axis=axis))
    last = np.take(steps, [-1], axis), np.take(jumps, [-1], axis)
    first = np.take(steps, [0], axis), np.take(jumps, [0], axis)
    ahead = np.concatenate([steps, last[0]], axis), np.concatenate([jumps, last[1]], axis)
    behind = np.concatenate([first[0], steps], axis), np.concatenate([first[1], jumps], axis)
    return np.where((behind[1] < ahead[1])[..., None], behind[0], ahead[0])
