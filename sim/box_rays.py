"""Rays against boxes: what a camera sees of a box, what a box hides from the light (slabs; Kay & Kajiya 1986)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray
from contracts.truth import Truth
from sim.lights import Beam
from sim.renderer import Window

Array32 = NDArray[np.float32]
_NOT_ZERO = np.float32(1e-9)
CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])  # of a box, in half sizes
SKIN_M = 1e-3  # a beam must run this far inside a box to be stopped: points on its surface are lit


# Where pixels are looked at, (u, v) from the centre: the centre itself, which decides identities, and the four places
# of 4x multisampling (Direct3D's standard pattern, which OpenGL implementations share), which decide colours.
SAMPLES_PX = np.array([[0.0, 0.0], [-0.125, 0.375], [0.375, 0.125], [-0.375, -0.125], [0.125, -0.375]])


@dataclass(frozen=True, eq=False)
class Box:
    """A box in the world: centre (3,), half sizes (3,), rotation (3, 3)."""

    centre_m: FloatArray
    half_m: FloatArray
    world_from_box: FloatArray

    @property
    def corners_m(self) -> FloatArray:
        """(8, 3) world, in the order of ``CORNERS``."""
        return np.asarray((CORNERS * self.half_m) @ self.world_from_box.T + self.centre_m)


@dataclass(frozen=True, eq=False)
class Rays:
    """Rays through the samples of a window of a pinhole's image, depth 1 along the axis; seen from one box.

    direction: three arrays (...). origin: (3,). Both in the box's axes, from its centre.
    """

    direction: tuple[Array32, Array32, Array32]
    origin: FloatArray


def upright_box(foot_m: FloatArray, heading_rad: float, size_m: FloatArray) -> Box:
    """A box of ``size_m`` (3,) that stands with its footprint's centre at ``foot_m`` (3,)."""
    cos, sin = np.cos(heading_rad), np.sin(heading_rad)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return Box(foot_m + np.array([0.0, 0.0, size_m[2] / 2]), size_m / 2, turn)


def boxes_of(state: Truth) -> list[Box]:
    """The boxes of all objects."""
    return [
        upright_box(position, heading, size)
        for position, heading, size in zip(state.positions_m, state.headings_rad, state.sizes_m, strict=True)
    ]


def rays_through(camera: Camera, window: Window, box: Box, samples_px: FloatArray = SAMPLES_PX) -> Rays:
    """The rays of ``window`` in the axes of ``box``."""
    u = np.arange(window[1].start, window[1].stop) + samples_px[:, :1]  # (S, w)
    v = np.arange(window[0].start, window[0].stop) + samples_px[:, 1:]  # (S, h)
    return rays_at(camera, u[:, None, :], v[:, :, None], box)


def rays_at(camera: Camera, u_px: FloatArray, v_px: FloatArray, box: Box) -> Rays:
    """The rays through pixels u, v, which together have any shape (...), in the axes of ``box``."""
    numbers, pose = camera.intrinsics, camera.pose
    x = ((u_px - numbers.cx_px) / numbers.fx_px).astype(np.float32)
    y = ((v_px - numbers.cy_px) / numbers.fy_px).astype(np.float32)
    turn = box.world_from_box.T @ pose.world_from_camera
    axes = [np.float32(a) * x + (np.float32(b) * y + np.float32(c)) for a, b, c in turn]
    for along in axes:
        along[along == 0] = _NOT_ZERO  # a ray along a face would divide by zero
    origin = box.world_from_box.T @ (pose.position_m - box.centre_m)
    return Rays((axes[0], axes[1], axes[2]), origin)


def seen(rays: Rays, box: Box) -> tuple[Array32, NDArray[np.uint8]]:
    """Depth (...) at which each ray enters the box, infinite where it misses; the axis of the face it enters.

    What ``sim.box_faces`` says faster of whole windows, one ray at a time.
    """
    entry, leave = None, None
    axis = np.zeros(rays.direction[0].shape, np.uint8)
    with np.errstate(divide="ignore", invalid="ignore"):
        for k, (along, start, half) in enumerate(zip(rays.direction, rays.origin, box.half_m, strict=True)):
            per_metre = np.float32(1.0) / along
            middle = per_metre * np.float32(-start)
            reach = np.abs(per_metre) * np.float32(half)
            if entry is None or leave is None:
                entry, leave = middle - reach, middle + reach
                continue
            first = middle - reach
            axis[first > entry] = k
            np.maximum(entry, first, out=entry)
            np.minimum(leave, middle + reach, out=leave)
    assert entry is not None
    assert leave is not None
    return np.where((entry < leave) & (entry > 0), entry, np.float32(np.inf)), axis


def shaded(rays: Rays, depth_m: Array32, box: Box, beam: Beam) -> NDArray[np.bool_]:
    """Whether the box keeps the beam from the points at ``depth_m`` (...) along the rays."""
    to_light = box.world_from_box.T @ -beam.direction
    to_light = np.where(np.abs(to_light) < _NOT_ZERO, _NOT_ZERO, to_light)
    entry, leave = np.float32(-np.inf), np.float32(np.inf)
    for along, start, half, slope in zip(rays.direction, rays.origin, box.half_m, to_light, strict=True):
        middle = (along * depth_m + np.float32(start)) * np.float32(-1.0 / slope)
        reach = np.float32(half / abs(slope))
        entry, leave = np.maximum(entry, middle - reach), np.minimum(leave, middle + reach)
    return np.asarray(leave - np.maximum(entry, 0) > SKIN_M)
