"""Camera rigs: where cameras should be, and where they truly are."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from sim.sensor import SensorSpec
from sim.streams import stream


@dataclass(frozen=True)
class Departure:
    """How far a true camera may depart from its data sheet; every value is a limit.

    position_m, rotation_deg: of the pose.
    focal: relative, of both focal lengths together.
    principal_px: of the principal point, each axis.
    """

    position_m: float = 0.10
    rotation_deg: float = 3.0
    focal: float = 0.005
    principal_px: float = 8.0

    def __post_init__(self) -> None:
        for name in ("position_m", "rotation_deg", "focal", "principal_px"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"Departure.{name} = {value} must be a finite number, 0 or more")


@dataclass(frozen=True)
class CameraSpec:
    """One camera's data sheet and where it should hang.

    resolution_px: width, height.
    focal_px: f, both axes alike.
    position_m: optical centre in the world.
    principal_px: cx, cy; the image's centre if not given.
    distortion: k1, k2, p1, p2, k3 of the true lens, in OpenCV's order; the nominal camera has none of it.
    tilt_deg: away from straight down, towards ``azimuth_deg``.
    azimuth_deg: direction on the ground of the image's *upper* edge, counter-clockwise from east; 90 has north up.
    """

    name: str
    resolution_px: tuple[int, int]
    focal_px: float
    position_m: tuple[float, float, float]
    principal_px: tuple[float, float] | None = None
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    tilt_deg: float = 0.0
    azimuth_deg: float = 90.0

    def __post_init__(self) -> None:
        if self.position_m[2] <= 0:
            raise InputError(
                f"camera {self.name}: position_m = {list(self.position_m)} is not above the ground; give z > 0"
            )
        if not 0 <= self.tilt_deg < 90:
            raise InputError(f"camera {self.name}: tilt_deg = {self.tilt_deg} must lie in [0, 90)")
        self.nominal()  # lets Intrinsics and Pose refuse what is wrong with the rest

    def nominal(self) -> Camera:
        """The camera of the data sheet: no distortion, exactly where it should hang."""
        width, height = self.resolution_px
        cx, cy = self.principal_px or ((width - 1) / 2, (height - 1) / 2)
        intrinsics = Intrinsics(width, height, self.focal_px, self.focal_px, cx, cy, np.zeros(5))
        return Camera(
            self.name, intrinsics, Pose(look_down(self.tilt_deg, self.azimuth_deg), np.array(self.position_m))
        )


@dataclass(frozen=True)
class RigSpec:
    """Cameras that film one plant, and how well they were built and hung."""

    cameras: tuple[CameraSpec, ...]
    departure: Departure = field(default_factory=Departure)
    sensor: SensorSpec = field(default_factory=SensorSpec)

    def __post_init__(self) -> None:
        names = [camera.name for camera in self.cameras]
        if not names:
            raise InputError("a rig needs at least one camera")
        if twice := {name for name in names if names.count(name) > 1}:
            raise InputError(f"camera {min(twice)} occurs twice in the rig; give each camera its own name")


def look_down(tilt_deg: float, azimuth_deg: float) -> FloatArray:
    """``world_from_camera`` of a camera that looks down, the image's upper edge towards ``azimuth_deg``; (3, 3).

    A tilt lifts the optical axis from straight down towards the azimuth.
    """
    tilt, azimuth = math.radians(tilt_deg), math.radians(azimuth_deg)
    ahead = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    down = np.array([0.0, 0.0, -1.0])
    axis = math.sin(tilt) * ahead + math.cos(tilt) * down
    image_down = math.sin(tilt) * down - math.cos(tilt) * ahead
    return np.column_stack([np.cross(image_down, axis), image_down, axis])


def nominal_cameras(rig: RigSpec) -> tuple[Camera, ...]:
    """The cameras as their owner believes them to be."""
    return tuple(spec.nominal() for spec in rig.cameras)


def true_cameras(rig: RigSpec, seed: int) -> tuple[Camera, ...]:
    """The cameras as they are under ``seed``: real lenses, hung by hand."""
    return tuple(_departed(spec, rig.departure, stream(seed, f"camera/{spec.name}")) for spec in rig.cameras)


def _departed(spec: CameraSpec, limit: Departure, rng: np.random.Generator) -> Camera:
    nominal = spec.nominal()
    turn, _ = cv2.Rodrigues(_in_ball(rng, math.radians(limit.rotation_deg)))
    position = nominal.pose.position_m + _in_ball(rng, limit.position_m)
    scale = 1.0 + rng.uniform(-limit.focal, limit.focal)
    shift = rng.uniform(-limit.principal_px, limit.principal_px, 2)
    plain = nominal.intrinsics
    intrinsics = Intrinsics(
        plain.width_px,
        plain.height_px,
        plain.fx_px * scale,
        plain.fy_px * scale,
        plain.cx_px + shift[0],
        plain.cy_px + shift[1],
        np.array(spec.distortion),
    )
    return Camera(spec.name, intrinsics, Pose(turn @ nominal.pose.world_from_camera, position))


def _in_ball(rng: np.random.Generator, radius: float) -> FloatArray:
    """A vector of random direction and a length uniform in [0, radius]; (3,)."""
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction) * rng.uniform(0.0, radius)
