"""A pinhole camera with a lens: the numbers only. The projection itself is in ``georef`` (and, apart, in ``sim``)."""

from dataclasses import dataclass

import numpy as np

from contracts.arrays import FloatArray, freeze
from contracts.errors import InputError

DISTORTION_SIZE = 5  # k1, k2, p1, p2, k3: OpenCV's order


@dataclass(frozen=True, eq=False)
class Intrinsics:
    """Focal length, principal point and lens of a camera; the centre of the first pixel is (0, 0).

    width_px, height_px: image size.
    fx_px, fy_px, cx_px, cy_px: the matrix K = [[fx, 0, cx], [0, fy, cy], [0, 0, 1]].
    distortion: (5,) k1, k2, p1, p2, k3 of Brown's model in OpenCV's order (Brown 1971; OpenCV calib3d).
    """

    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "distortion", shape=(DISTORTION_SIZE,))
        if self.width_px < 1 or self.height_px < 1:
            raise InputError(f"Intrinsics: image size {self.width_px} x {self.height_px} px is not positive")
        numbers = (self.fx_px, self.fy_px, self.cx_px, self.cy_px)
        if not np.isfinite(numbers).all() or min(self.fx_px, self.fy_px) <= 0:
            raise InputError(f"Intrinsics: (fx, fy, cx, cy) = {numbers} must be finite with positive focal lengths")

    @property
    def matrix(self) -> FloatArray:
        """K, (3, 3)."""
        return np.array([[self.fx_px, 0.0, self.cx_px], [0.0, self.fy_px, self.cy_px], [0.0, 0.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a camera stands. Camera axes are OpenCV's: x right, y down, z into the scene.

    world_from_camera: (3, 3) rotation.
    position_m: (3,) optical centre in the world.
    """

    world_from_camera: FloatArray
    position_m: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "world_from_camera", shape=(3, 3))
        freeze(self, "position_m", shape=(3,))
        rotation = self.world_from_camera
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6 or np.linalg.det(rotation) < 0:
            raise InputError("Pose.world_from_camera is not a rotation matrix")


@dataclass(frozen=True, eq=False)
class Camera:
    """A named camera: intrinsics and pose."""

    name: str
    intrinsics: Intrinsics
    pose: Pose
