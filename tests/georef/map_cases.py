"""Pole cameras over a road and picks on its map, imaged by OpenCV, for the tests of calibration from a map."""

import cv2
import numpy as np
from hypothesis import strategies as st

from contracts import Camera, FloatArray, Intrinsics, Pose
from georef.picks import LinePicks, PointPicks

SIZE = (1920, 1080)
PLAIN_PICKS_SEED = 11
STRONG_LENS = (-0.22, 0.04, 0.0, 0.0, 0.0)


def pole(
    *,
    height_m: float = 8.0,
    heading_deg: float = 20.0,
    down_deg: float = 17.0,
    roll_deg: float = 0.0,
    focal_px: float = 1700.0,
    offset_px: tuple[float, float] = (0.0, 0.0),
    distortion: tuple[float, ...] = (0.0,) * 5,
    foot_m: tuple[float, float] = (0.0, 0.0),
) -> Camera:
    """A camera on a pole that looks along ``heading_deg`` from east and ``down_deg`` below the horizon."""
    heading, down, roll = np.deg2rad([heading_deg, down_deg, roll_deg])
    ahead = np.array([np.cos(down) * np.cos(heading), np.cos(down) * np.sin(heading), -np.sin(down)])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    below = np.cross(ahead, right)
    right, below = np.cos(roll) * right + np.sin(roll) * below, np.cos(roll) * below - np.sin(roll) * right
    centre = np.array([959.5, 539.5]) + offset_px
    intrinsics = Intrinsics(*SIZE, focal_px, focal_px, float(centre[0]), float(centre[1]), np.array(distortion))
    return Camera("pole", intrinsics, Pose(np.stack([right, below, ahead], axis=1), np.array([*foot_m, height_m])))


@st.composite
def poles(draw: st.DrawFn, *, plain: bool = False) -> Camera:
    """Pole cameras; plain ones have neither lens nor roll and their principal point at the centre."""
    whole: dict[str, object] = {}
    if not plain:
        whole = {
            "roll_deg": draw(st.floats(-2.0, 2.0)),
            "offset_px": (draw(st.floats(-25.0, 25.0)), draw(st.floats(-25.0, 25.0))),
            "distortion": (draw(st.floats(-0.3, 0.05)), draw(st.floats(-0.03, 0.05)), 0.0, 0.0, 0.0),
        }
    return pole(
        height_m=draw(st.floats(6.0, 10.0)),
        heading_deg=draw(st.floats(-180.0, 180.0)),
        down_deg=draw(st.floats(14.0, 24.0)),
        focal_px=draw(st.floats(1300.0, 2400.0)),
        foot_m=(draw(st.floats(-50.0, 50.0)), draw(st.floats(-50.0, 50.0))),
        **whole,  # type: ignore[arg-type]
    )


def image(camera: Camera, points_m: FloatArray) -> FloatArray:
    """Pixels (N, 2) by OpenCV."""
    turn = cv2.Rodrigues(camera.pose.world_from_camera.T)[0]
    shift = -camera.pose.world_from_camera.T @ camera.pose.position_m
    lens = camera.intrinsics
    pixels = cv2.projectPoints(np.asarray(points_m, float).reshape(-1, 3), turn, shift, lens.matrix, lens.distortion)[0]
    return np.asarray(pixels, float).reshape(-1, 2)


def ground_points(camera: Camera, count: int, rng: np.random.Generator, *, raised: float = 0.0) -> FloatArray:
    """(count, 3) places in the image spread up to 60 m away; a share ``raised`` of them stand 2 to 6 m high."""
    ahead = camera.pose.world_from_camera[:2, 2] / np.hypot(*camera.pose.world_from_camera[:2, 2])
    beside = np.array([ahead[1], -ahead[0]])
    kept: list[FloatArray] = []
    while len(kept) < count:
        along, across = rng.uniform(8.0, 60.0), rng.uniform(-25.0, 25.0)
        height = rng.uniform(2.0, 6.0) if rng.uniform() < raised else 0.0
        point = np.array([*(camera.pose.position_m[:2] + along * ahead + across * beside), height])
        x, y, depth = (point - camera.pose.position_m) @ camera.pose.world_from_camera
        pixel = image(camera, point)[0]
        before_fold = np.hypot(x, y) < depth  # every lens here is one to one within 45 degrees
        if before_fold and (pixel > 5).all() and (pixel < np.array(SIZE) - 5).all():
            kept.append(point)
    return np.array(kept)


def picks(
    camera: Camera,
    seed: int,
    *,
    count: int = 25,
    noise_px: float = 0.0,
    wrong: int = 0,
    raised: float = 0.15,
) -> PointPicks:
    """``count`` picks, the first ``wrong`` of them anywhere in the image."""
    rng = np.random.default_rng(seed)
    points = ground_points(camera, count, rng, raised=raised)
    pixels = image(camera, points) + noise_px * rng.standard_normal((count, 2))
    pixels[:wrong] = rng.uniform([0, 0], SIZE, (wrong, 2))
    return PointPicks.exact(pixels, points)


def line_picks(camera: Camera, seed: int, *, lines: int = 4, each: int = 6, noise_px: float = 0.0) -> LinePicks:
    """Pixels on straight lines of the road that run along the viewing direction."""
    rng = np.random.default_rng(seed)
    ahead = camera.pose.world_from_camera[:2, 2] / np.hypot(*camera.pose.world_from_camera[:2, 2])
    beside = np.array([ahead[1], -ahead[0]])
    names, pixels, courses = [], [], []
    for number in range(lines):
        across = 3.5 * (number - (lines - 1) / 2)
        ends = [camera.pose.position_m[:2] + along * ahead + across * beside for along in (25.0, 40.0, 60.0)]
        course = np.column_stack([ends, np.zeros(3)])
        share = rng.uniform(0.0, 1.0, each)
        places = course[0] + share[:, None] * (course[2] - course[0])
        pixels.append(image(camera, places) + noise_px * rng.standard_normal((each, 2)))
        names += each * [f"line {number}"]
        courses += each * [course]
    return LinePicks(tuple(names), np.concatenate(pixels), tuple(courses), np.zeros(len(names)))
