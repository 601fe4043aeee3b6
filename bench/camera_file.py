"""A real camera's file (YAML): what calibration found, in plain numbers.

name: west
width_px: 1280
height_px: 720
fx_px: 4400.0
fy_px: 4400.0
cx_px: 639.5                     # the centre of the first pixel is (0, 0)
cy_px: 359.5
distortion: [0, 0, 0, 0, 0]      # k1, k2, p1, p2, k3; OpenCV's order
position_m: [0.0, 0.0, 2.8]      # the optical centre in the world
world_from_camera:               # rows; or instead of these two OpenCV's rvec and tvec
- [1, 0, 0]
- [0, -1, 0]
- [0, 0, -1]
sigmas: {fx_px: 2.0, x_m: 0.001} # optional: standard deviations, independent; what is not named is exact
"""

from pathlib import Path

import cv2
import msgspec
import numpy as np
import yaml

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from georef.calibrated import PARAMETERS, CalibratedCamera

Row = tuple[float, float, float]
_UNITS = {"px": ("fx", "fy", "cx", "cy"), "rad": ("rx", "ry", "rz"), "m": ("x", "y", "z")}
SIGMA_NAMES = tuple(
    next((f"{name}_{unit}" for unit, names in _UNITS.items() if name in names), name) for name in PARAMETERS
)
"""The parameters as the file names them, unit included, in the order of ``PARAMETERS``."""


class _CameraFile(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    width_px: int
    height_px: int
    fx_px: float
    fy_px: float
    cx_px: float
    cy_px: float
    distortion: tuple[float, float, float, float, float]
    position_m: Row | None = None
    world_from_camera: tuple[Row, Row, Row] | None = None
    rvec: Row | None = None
    tvec: Row | None = None
    sigmas: dict[str, float] = msgspec.field(default_factory=dict)


def load_camera(path: Path | str) -> CalibratedCamera:
    """The camera in the YAML file at ``path``.

    Raises InputError naming file and key if it cannot be read, lacks something or says something impossible.
    """
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        told = msgspec.convert(content, _CameraFile)
        camera = Camera(told.name, _intrinsics(told), _pose(told))
        if camera.pose.position_m[2] <= 0:
            raise InputError(f"the camera's height {camera.pose.position_m[2]:g} m lies below the ground, z = 0")
        return CalibratedCamera(camera, _covariance(told.sigmas))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text, so no YAML") from error
    except yaml.YAMLError as error:
        raise InputError(f"{path}: is not YAML: {' '.join(str(error).split())}") from error
    except (msgspec.ValidationError, InputError) as error:
        raise InputError(f"{path}: {error}") from error


def _intrinsics(told: _CameraFile) -> Intrinsics:
    numbers = told.fx_px, told.fy_px, told.cx_px, told.cy_px
    return Intrinsics(told.width_px, told.height_px, *numbers, np.array(told.distortion))


def _pose(told: _CameraFile) -> Pose:
    ours, opencv = (told.position_m, told.world_from_camera), (told.rvec, told.tvec)
    if None not in ours and opencv == (None, None):
        return Pose(np.array(told.world_from_camera, float), np.array(told.position_m, float))
    if None not in opencv and ours == (None, None):
        rvec, tvec = np.array(told.rvec, float), np.array(told.tvec, float)
        camera_from_world = np.asarray(cv2.Rodrigues(rvec)[0], dtype=float)
        return Pose(camera_from_world.T, -camera_from_world.T @ tvec)
    raise InputError("give the pose either as position_m and world_from_camera, or as rvec and tvec")


def _covariance(sigmas: dict[str, float]) -> FloatArray:
    for name, sigma in sigmas.items():
        if name not in SIGMA_NAMES:
            raise InputError(f"sigmas.{name}: no such parameter, choose from {', '.join(SIGMA_NAMES)}")
        if not sigma >= 0:
            raise InputError(f"sigmas.{name} = {sigma} must not be negative")
    return np.diag([sigmas.get(name, 0.0) ** 2 for name in SIGMA_NAMES])
