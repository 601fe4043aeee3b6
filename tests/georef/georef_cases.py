"""Cameras and points for the tests of this room: Hypothesis strategies and fixed cases."""

import numpy as np
from hypothesis import strategies as st

from contracts import Camera, FloatArray, Intrinsics, Pose


def rotation(rx: float, ry: float, rz: float) -> FloatArray:
    """exp([r]) by Rodrigues' formula, written out apart from the code under test."""
    r = np.array([rx, ry, rz])
    angle = float(np.linalg.norm(r))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = r / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


LOOKING_DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])  # u east, v south


def overhead(
    name: str = "west",
    position_m: tuple[float, float, float] = (0.0, 0.0, 2.8),
    tilt_rad: tuple[float, float, float] = (0.0, 0.0, 0.0),
    distortion: tuple[float, ...] = (-0.12, 0.05, 0.0006, -0.0004, 0.0),
    focal_px: float = 1600.0,
) -> Camera:
    """The usual overhead camera: 1280 x 720 px, 2.8 m high."""
    intrinsics = Intrinsics(1280, 720, focal_px, focal_px * 1.001, 642.3, 355.8, np.array(distortion))
    return Camera(name, intrinsics, Pose(rotation(*tilt_rad) @ LOOKING_DOWN, np.array(position_m)))


@st.composite
def lenses(draw: st.DrawFn) -> FloatArray:
    k1 = draw(st.floats(-0.3, 0.3))
    k2 = draw(st.floats(-0.1, 0.1))
    p1, p2 = draw(st.floats(-0.002, 0.002)), draw(st.floats(-0.002, 0.002))
    return np.array([k1, k2, p1, p2, draw(st.floats(-0.02, 0.02))])


@st.composite
def cameras(draw: st.DrawFn) -> Camera:
    """Cameras above the ground that look downwards within 40 degrees, with any yaw and an ordinary lens."""
    focal_px = draw(st.floats(900.0, 4500.0))
    intrinsics = Intrinsics(
        1280,
        720,
        focal_px,
        focal_px * draw(st.floats(0.98, 1.02)),
        draw(st.floats(560.0, 720.0)),
        draw(st.floats(300.0, 420.0)),
        draw(lenses()),
    )
    tilts = [draw(st.floats(-0.5, 0.5)) for _ in range(2)]
    yaw = draw(st.floats(-3.0, 3.0))
    position = [draw(st.floats(-50.0, 50.0)), draw(st.floats(-50.0, 50.0)), draw(st.floats(1.0, 12.0))]
    pose = Pose(rotation(0, 0, yaw) @ rotation(*tilts, 0.0) @ LOOKING_DOWN, np.array(position))
    return Camera("any", intrinsics, pose)


@st.composite
def pixels(draw: st.DrawFn, count: int = 5) -> FloatArray:
    """Points within a 1280 x 720 image, (count, 2)."""
    return np.array([[draw(st.floats(0.0, 1279.0)), draw(st.floats(0.0, 719.0))] for _ in range(count)])


def perturbed(camera: Camera, step: FloatArray) -> Camera:
    """``camera`` with its 15 parameters moved by ``step``, as ``georef.calibrated.PARAMETERS`` means them."""
    k = camera.intrinsics
    numbers = np.array([k.fx_px, k.fy_px, k.cx_px, k.cy_px]) + step[:4]
    intrinsics = Intrinsics(k.width_px, k.height_px, *(float(n) for n in numbers), k.distortion + step[4:9])
    pose = Pose(rotation(*step[9:12]) @ camera.pose.world_from_camera, camera.pose.position_m + step[12:15])
    return Camera(camera.name, intrinsics, pose)
