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
        found = np.zeros((*self.kinds.shape, 3), np.float32)
        found[self.ground] = _UP
        upright = ~self.ground & (self.kinds != 0)
        found[upright] = surfaces_at(self.camera, self.depth_m, upright)[1]
        return found

    @cached_property
    def pixel_m(self) -> Array32:
        """Length of a pixel on the surface, (H, W), the mean of along and across."""
        grazing = np.maximum(-self.rays[..., 2] / self.stretch, np.float32(0.02))
        return np.asarray(self.depth_m / np.float32(self.camera.intrinsics.fx_px) / np.sqrt(grazing))


def surfaces_at(camera: Camera, depth_m: NDArray[np.float32], where: NDArray[np.bool_]) -> tuple[Array32, Array32]:
    """Points (N, 3), world, and unit normals (N, 3), towards the camera, in the N pixels of ``where`` (H, W).

    depth_m: (H, W) of what a pinhole shows. A surface goes on to that neighbour to which the depth changes less.
    """
    v, u = np.nonzero(where)
    size, depth = camera.intrinsics, depth_m[v, u]
    x, y = ((u - size.cx_px) / size.fx_px).astype(np.float32), ((v - size.cy_px) / size.fy_px).astype(np.float32)
    du, beside = _slope(depth_m, (v, u), axis=1)
    dv, below = _slope(depth_m, (v, u), axis=0)
    p, q = beside / np.float32(size.fx_px), below / np.float32(size.fy_px)
    # the surface is depth (x, y, 1): its steps are (du x + p, du y, du) and (dv x, dv y + q, dv); this is their product
    normals = np.stack([-q * du, -p * dv, p * q + x * q * du + y * p * dv])
    outwards = -np.sign(x * normals[0] + y * normals[1] + normals[2])
    lengths = np.sqrt(normals[0] ** 2 + normals[1] ** 2 + normals[2] ** 2)
    normals *= outwards / np.maximum(lengths, np.float32(1e-12))
    turn = camera.pose.world_from_camera.astype(np.float32)
    points = turn @ np.stack([x * depth, y * depth, depth]) + camera.pose.position_m.astype(np.float32)[:, None]
    return points.T, (turn @ normals).T


def _slope(
    depth_m: NDArray[np.float32], at: tuple[NDArray[np.intp], NDArray[np.intp]], *, axis: int
) -> tuple[Array32, Array32]:
    """By how much the depth grows from pixel to pixel along an axis, (N,), and the depth of that neighbour."""
    here, last = depth_m[at], depth_m.shape[axis] - 1
    before, after = (
        depth_m[tuple(np.clip(n + shift, 0, last) if k == axis else n for k, n in enumerate(at))] for shift in (-1, 1)
    )
    back, on = here - before, after - here
    # what is beyond the picture's edge is no neighbour
    takes_back = ((np.abs(back) < np.abs(on)) & (at[axis] > 0)) | (at[axis] == last)
    return np.where(takes_back, back, on), np.where(takes_back, before, after)
