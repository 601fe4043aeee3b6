"""Small rigs, scenes and states for the tests of the film."""

import math

import numpy as np

from contracts import Camera, Intrinsics, Pose
from contracts.truth import Truth
from sim.rig import look_down
from sim.scene import Scene

FLOOR_M = np.array([-2.0, -2.0, 2.0, 2.0])


def camera(
    *,
    width_px: int = 640,
    height_px: int = 480,
    focal_px: float = 640.0,
    principal_px: tuple[float, float] | None = None,
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0),
    position_m: tuple[float, float, float] = (0.03, -0.05, 1.4),
    tilt_deg: float = 3.0,
    azimuth_deg: float = 70.0,
) -> Camera:
    cx, cy = principal_px or ((width_px - 1) / 2, (height_px - 1) / 2)
    intrinsics = Intrinsics(width_px, height_px, focal_px, focal_px, cx, cy, np.array(distortion))
    return Camera("eye", intrinsics, Pose(look_down(tilt_deg, azimuth_deg), np.array(position_m)))


def marks_grid(step_m: float, half_m: float = 1.0) -> Scene:
    ticks = np.arange(-half_m, half_m + step_m / 2, step_m)
    x, y = np.meshgrid(ticks, ticks)
    return Scene(FLOOR_M, np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]))


def empty_scene() -> Scene:
    return Scene(FLOOR_M, np.array([[1.95, 1.95, 0.0]]))  # one mark, far outside of the views used here


def state(
    *vehicles: tuple[str, float, float, float], time_ns: int = 0, index: int = 0, speed_mps: float = 0.0
) -> Truth:
    """Vehicles of 12 x 6 x 6 cm, each (colour, x, y, heading in degrees)."""
    n = len(vehicles)
    headings = np.array([math.radians(v[3]) for v in vehicles])
    return Truth(
        index=index,
        time_ns=time_ns,
        ids=tuple(v[0] for v in vehicles),
        labels=tuple(v[0] for v in vehicles),
        positions_m=np.array([[v[1], v[2], 0.0] for v in vehicles]).reshape(n, 3),
        headings_rad=headings,
        sizes_m=np.tile([0.12, 0.06, 0.06], (n, 1)),
        velocities_mps=speed_mps * np.stack([np.cos(headings), np.sin(headings)], axis=-1),
    )
