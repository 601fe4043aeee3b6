"""A real camera's file (YAML): what calibration found, in plain numbers.

Three forms are read: our own, OpenCV's (``cv2.FileStorage``) and ROS's camera_info (``georef.camera_forms`` has those
two). Our own, for example::

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
    geo_reference: {latitude_deg: 37.398, longitude_deg: 127.112}    # of the world's origin, if it is known

Instead of ``position_m`` and ``world_from_camera`` the file may give OpenCV's ``rvec`` and ``tvec``. ``sigmas`` are
standard deviations, taken as independent; what is not named is exact. Instead of them there may be the whole
``covariance``, row by row in the order of ``georef.calibrated.PARAMETERS``. A file of the lens alone has no pose.
"""

from dataclasses import asdict
from pathlib import Path

import cv2
import msgspec
import numpy as np
import yaml

from contracts import FloatArray, InputError, Intrinsics, Pose
from contracts.arrays import frozen_array
from contracts.files import write_whole
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.camera_forms import CameraForm, StoredCamera, from_opencv, from_ros, is_opencv, is_ros, to_opencv, to_ros
from georef.geo_reference import GeoReference

Row = tuple[float, float, float]
_UNITS = {"px": ("fx", "fy", "cx", "cy"), "rad": ("rx", "ry", "rz"), "m": ("x", "y", "z")}
SIGMA_NAMES = tuple(
    next((f"{name}_{unit}" for unit, names in _UNITS.items() if name in names), name) for name in PARAMETERS
)
"""The parameters as the file names them, unit included, in the order of ``PARAMETERS``."""
_POSE_MISSING = "give the pose either as position_m and world_from_camera, or as rvec and tvec"


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
    geo_reference: GeoReference | None = None


def read_camera(path: Path | str) -> CalibratedCamera:
    """The camera in the YAML file at ``path``, in any of the three forms.

    Raises InputError naming file and key if it cannot be read, lacks something or says something impossible.
    """
    stored = read_stored(path)
    if stored.pose is None:
        raise InputError(f"{path}: {_POSE_MISSING}")
    return stored.calibrated


def read_stored(path: Path | str) -> StoredCamera:
    """What the YAML file at ``path`` says of a camera; its pose may be missing. Errors as ``read_camera``."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        stored = from_opencv(text) if is_opencv(text) else _from_yaml(yaml.safe_load(text))
        if stored.pose is not None and stored.pose.position_m[2] <= 0:
            raise InputError(f"the camera's height {stored.pose.position_m[2]:g} m lies below the ground, z = 0")
        return stored
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text, so no YAML") from error
    except yaml.YAMLError as error:
        raise InputError(f"{path}: is not YAML: {' '.join(str(error).split())}") from error
    except (msgspec.ValidationError, InputError) as error:
        raise InputError(f"{path}: {error}") from error


def write_camera(path: Path | str, calibrated: CalibratedCamera) -> None:
    """Write ``calibrated`` in our own form, which ``read_camera`` reads back to the bit.

    Raises InputError if the file cannot be written.
    """
    write_stored(path, StoredCamera.of(calibrated))


def write_stored(path: Path | str, stored: StoredCamera, form: CameraForm = CameraForm.GANTRY) -> None:
    """Write ``stored``; the pose goes through a rotation vector in OpenCV's form, else all is read back to the bit.

    Raises InputError if the file cannot be written.
    """
    text = {CameraForm.GANTRY: _to_text, CameraForm.OPENCV: to_opencv, CameraForm.ROS: to_ros}[form](stored)
    write_whole(path, text)


def _to_text(stored: StoredCamera) -> str:
    numbers = stored.intrinsics
    content = {
        "name": stored.name,
        "width_px": numbers.width_px,
        "height_px": numbers.height_px,
        "fx_px": numbers.fx_px,
        "fy_px": numbers.fy_px,
        "cx_px": numbers.cx_px,
        "cy_px": numbers.cy_px,
        "distortion": numbers.distortion.tolist(),
    }
    if stored.pose is not None:
        content["position_m"] = stored.pose.position_m.tolist()
        content["world_from_camera"] = stored.pose.world_from_camera.tolist()
    content["covariance"] = stored.covariance.tolist()
    if stored.geo is not None:
        content["geo_reference"] = asdict(stored.geo)
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None)


def _from_yaml(content: object) -> StoredCamera:
    if is_ros(content):
        return from_ros(content)
    told = msgspec.convert(content, _CameraFile, strict=False)  # to YAML 1.1, 1e-3 is a string
    return StoredCamera(told.name, _intrinsics(told), _pose(told), _covariance(told), told.geo_reference)


def _intrinsics(told: _CameraFile) -> Intrinsics:
    numbers = told.fx_px, told.fy_px, told.cx_px, told.cy_px
    return Intrinsics(told.width_px, told.height_px, *numbers, np.array(told.distortion))


def _pose(told: _CameraFile) -> Pose | None:
    ours, opencv = (told.position_m, told.world_from_camera), (told.rvec, told.tvec)
    if None not in ours and opencv == (None, None):
        return Pose(np.array(told.world_from_camera, float), np.array(told.position_m, float))
    if None not in opencv and ours == (None, None):
        rvec, tvec = np.array(told.rvec, float), np.array(told.tvec, float)
        camera_from_world = np.asarray(cv2.Rodrigues(rvec)[0], dtype=float)
        return Pose(camera_from_world.T, -camera_from_world.T @ tvec)
    if ours == opencv == (None, None):
        return None
    raise InputError(_POSE_MISSING)


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
