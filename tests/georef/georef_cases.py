"""Cameras and points for the tests of this room: Hypothesis strategies and fixed cases."""

import numpy as np
from hypothesis import strategies as st

from contracts import Camera, FloatArray, IntArray, Intrinsics, Pose
from georef.projection import project


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


def board_poses(
    camera: Camera, points: FloatArray, count: int, rng: np.random.Generator, tilt: float = 0.6
) -> FloatArray:
    """Exact images (count, N, 2) of board points held at random before the camera, wholly in its image."""
    k, centre, views = camera.intrinsics, points.mean(axis=0), []
    while len(views) < count:
        camera_from_board = rotation(*rng.uniform(-0.6, 0.6, 2), 0.0) @ rotation(0.0, 0.0, rng.uniform(-3.0, 3.0))
        depth = rng.uniform(0.4, 0.8)
        place = depth * np.array([rng.uniform(-0.3, 0.3), rng.uniform(-0.16, 0.16), 1.0])
        pose = Pose(camera_from_board.T, centre - camera_from_board.T @ place)
        image, valid = project(Camera("board", k, pose), points)
        if valid.all() and (image > 10).all() and (image < [k.width_px - 10, k.height_px - 10]).all():
            views.append(image)
    return np.array(views)


def tile_corners() -> FloatArray:
    """Control points on a 0.4 m grid, far more than one camera sees, (187, 3)."""
    grid = np.stack(np.meshgrid(np.arange(-8, 9), np.arange(-5, 6)), axis=-1).reshape(-1, 2)
    return np.column_stack([0.4 * grid, np.zeros(len(grid))])


def in_ball(radius: float, rng: np.random.Generator) -> FloatArray:
    direction = rng.normal(size=3)
    return radius * rng.uniform() * direction / np.linalg.norm(direction)


def departed(camera: Camera, rng: np.random.Generator, position_m: float = 0.10, angle_deg: float = 3.0) -> Camera:
    """``camera`` hung by hand."""
    turn, shift = in_ball(np.deg2rad(angle_deg), rng), in_ball(position_m, rng)
    return perturbed(camera, np.concatenate([np.zeros(9), turn, shift]))


def seen_marks(camera: Camera, points_m: FloatArray) -> tuple[IntArray, FloatArray]:
    """Row numbers (K,) and exact pixels (K, 2) of the control points in the image."""
    image, valid = project(camera, points_m)
    inside = valid & (image > 6).all(axis=1) & (image < [1273, 713]).all(axis=1)
    return np.flatnonzero(inside), image[inside]
