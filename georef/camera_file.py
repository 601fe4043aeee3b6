"""A real camera's file (YAML): what calibration found, in plain numbers.

For example::

    name: west
    width_px: 1280
    height_px: 720
    fx_px: 4400.0
    fy_px: 4400.0
    cx_px: 639.5                     # the centre of the first pixel is (0, 0)
    cy_px: 359.5
    distortion: [0, 0, 0, 0, 0]      # k1, k2, p1, p2, k3; OpenCV's order
    position_m: [0.0, 0.0, 2.8]      # the optical centre in the world
    world_from_camera: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
    sigmas: {fx_px: 2.0, x_m: 0.001}

Instead of ``position_m`` and ``world_from_camera`` the file may give OpenCV's ``rvec`` and ``tvec``. ``sigmas`` are
standard deviations, taken as independent; what is not named is exact. Instead of them there may be the whole
``covariance``, row by row in the order of ``georef.calibrated.PARAMETERS``.
"""

from pathlib import Path

import cv2
import msgspec
import numpy as np
import yaml

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from contracts.arrays import frozen_array
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
    covariance: list[list[float]] | None = None


def read_camera(path: Path | str) -> CalibratedCamera:
    """The camera in the YAML file at ``path``.

    Raises InputError naming file and key if it cannot be read, lacks something or says something impossible.
    """
    path = Path(path)
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
        told = msgspec.convert(content, _CameraFile, strict=False)  # to YAML 1.1, 1e-3 is a string
        camera = Camera(told.name, _intrinsics(told), _pose(told))
        if camera.pose.position_m[2] <= 0:
            raise InputError(f"the camera's height {camera.pose.position_m[2]:g} m lies below the ground, z = 0")
        return CalibratedCamera(camera, _covariance(told))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text, so no YAML") from error
    except yaml.YAMLError as error:
        raise InputError(f"{path}: is not YAML: {' '.join(str(error).split())}") from error
    except (msgspec.ValidationError, InputError) as error:
        raise InputError(f"{path}: {error}") from error


def write_camera(path: Path | str, calibrated: CalibratedCamera) -> None:
    """Write ``calibrated`` as a YAML file that ``read_camera`` reads back to the bit.

    Raises InputError if the file cannot be written.
    """
    camera = calibrated.camera
    numbers = camera.intrinsics
    content = {
        "name": camera.name,
        "width_px": numbers.width_px,
        "height_px": numbers.height_px,
        "fx_px": numbers.fx_px,
        "fy_px": numbers.fy_px,
        "cx_px": numbers.cx_px,
        "cy_px": numbers.cy_px,
        "distortion": numbers.distortion.tolist(),
        "position_m": camera.pose.position_m.tolist(),
        "world_from_camera": camera.pose.world_from_camera.tolist(),
        "covariance": calibrated.covariance.tolist(),
    }
    try:
        Path(path).write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error


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


def _covariance(told: _CameraFile) -> FloatArray:
    if told.covariance is not None and told.sigmas:
        raise InputError("give either sigmas or covariance, not both")
    if told.covariance is not None:
        return frozen_array(told.covariance, name="covariance", shape=(len(PARAMETERS), len(PARAMETERS)))
    for name, sigma in told.sigmas.items():
        if name not in SIGMA_NAMES:
            raise InputError(f"sigmas.{name}: no such parameter, choose from {', '.join(SIGMA_NAMES)}")
        if not sigma >= 0:
            raise InputError(f"sigmas.{name} = {sigma} must not be negative")
    return np.diag([told.sigmas.get(name, 0.0) ** 2 for name in SIGMA_NAMES])
