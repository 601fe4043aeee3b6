"""A camera as files know it, and the two forms that other programs read: OpenCV's YAML and ROS's camera_info.

Both hold the lens in their own keys; pose, covariance and geo-reference stand beside them in keys that those programs
pass over. All three count the centre of the first pixel as (0, 0).
"""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import cv2
import msgspec
import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from contracts import Camera, FloatArray, InputError, Intrinsics, Pose
from contracts.arrays import freeze
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.geo_reference import GeoReference

_OPENCV_HEAD, _OPENCV_TAG = "%YAML:1.0", "!!opencv-matrix"  # from OpenCV 5 on the head is YAML's own
_PLUMB_BOB = "plumb_bob"
_SIZE = len(PARAMETERS)


class CameraForm(StrEnum):
    """Whose form a camera file has."""

    GANTRY = "gantry"
    OPENCV = "opencv"
    ROS = "ros"


@dataclass(frozen=True, eq=False)
class StoredCamera:
    """What a file says of a camera.

    pose: None in a file of the lens alone. covariance: (15, 15) of ``georef.calibrated.PARAMETERS``.
    geo: where on the Earth the world's origin lies, or None.
    """

    name: str
    intrinsics: Intrinsics
    pose: Pose | None
    covariance: FloatArray
    geo: GeoReference | None = None

    def __post_init__(self) -> None:
        freeze(self, "covariance", shape=(_SIZE, _SIZE))

    @classmethod
    def of(cls, calibrated: CalibratedCamera, geo: GeoReference | None = None) -> "StoredCamera":
        """A calibrated camera."""
        camera = calibrated.camera
        return cls(camera.name, camera.intrinsics, camera.pose, calibrated.covariance, geo)

    @property
    def calibrated(self) -> CalibratedCamera:
        """As a calibrated camera. Raises InputError without a pose."""
        if self.pose is None:
            raise InputError(f'camera "{self.name}" has a lens but no pose: calibrate it from picks on the map first')
        return CalibratedCamera(Camera(self.name, self.intrinsics, self.pose), self.covariance)


def is_opencv(text: str) -> bool:
    """Whether ``text`` was written by OpenCV's FileStorage."""
    return text.startswith(_OPENCV_HEAD) or _OPENCV_TAG in text


def to_opencv(stored: StoredCamera) -> str:
    """As OpenCV's own calibration programs write it, with rvec and tvec of the pose."""
    storage = cv2.FileStorage("camera.yml", cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    lens = stored.intrinsics
    storage.write("camera_name", stored.name)
    storage.write("image_width", lens.width_px)
    storage.write("image_height", lens.height_px)
    storage.write("camera_matrix", lens.matrix)
    storage.write("distortion_coefficients", lens.distortion.reshape(1, 5))
    if stored.pose is not None:
        camera_from_world = stored.pose.world_from_camera.T
        storage.write("rvec", Rotation.from_matrix(camera_from_world).as_rotvec().reshape(3, 1))
        storage.write("tvec", (-camera_from_world @ stored.pose.position_m).reshape(3, 1))
    storage.write("covariance", np.array(stored.covariance))
    if stored.geo is not None:
        storage.write("geo_reference", np.array([[stored.geo.latitude_deg, stored.geo.longitude_deg]]))
    return storage.releaseAndGetString()


def from_opencv(text: str) -> StoredCamera:
    """The inverse of ``to_opencv``, and of what OpenCV's calibration programs write. Raises InputError."""
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        names = set(storage.root().keys())
        content = {name: _opencv_value(storage.getNode(name)) for name in names}
    except (cv2.error, SystemError) as error:
        raise InputError("is not what OpenCV's FileStorage writes") from error
    for key in ("image_width", "image_height", "camera_matrix", "distortion_coefficients"):
        if content.get(key) is None:
            raise InputError(f"lacks {key}")
    pose = None
    if content.get("rvec") is not None and content.get("tvec") is not None:
        rvec, shift = (_numbers(content[key], (3,), key) for key in ("rvec", "tvec"))
        camera_from_world = Rotation.from_rotvec(rvec).as_matrix()
        pose = Pose(camera_from_world.T, -camera_from_world.T @ shift)
    geo = content.get("geo_reference")
    covariance = content.get("covariance")
    return StoredCamera(
        str(content.get("camera_name") or "camera"),
        _intrinsics(
            (content["image_width"], content["image_height"]),
            content["camera_matrix"],
            content["distortion_coefficients"],
        ),
        pose,
        np.zeros((_SIZE, _SIZE)) if covariance is None else _numbers(covariance, (_SIZE, _SIZE), "covariance"),
        None if geo is None else GeoReference(*(float(n) for n in _numbers(geo, (2,), "geo_reference"))),
    )


def _opencv_value(node: Any) -> Any:
    """A node of OpenCV's file: a number, a text or a matrix; None for anything else."""
    if node.isInt() or node.isReal():
        return node.real()
    if node.isString():
        return node.string()
    return node.mat() if node.isMap() else None


class _Matrix(msgspec.Struct):
    rows: int
    cols: int
    data: list[float]


class _Extra(msgspec.Struct, forbid_unknown_fields=True):
    """What camera_info has no key for."""

    covariance: list[list[float]]
    position_m: tuple[float, float, float] | None = None
    world_from_camera: list[list[float]] | None = None
    geo_reference: GeoReference | None = None


class _CameraInfo(msgspec.Struct):
    image_width: int
    image_height: int
    camera_matrix: _Matrix
    distortion_coefficients: _Matrix
    camera_name: str = "camera"
    distortion_model: str = _PLUMB_BOB
    gantry: _Extra | None = None


def is_ros(content: object) -> bool:
    """Whether parsed YAML has the keys of ROS's camera_info."""
    return isinstance(content, dict) and "camera_matrix" in content and "image_width" in content


def to_ros(stored: StoredCamera) -> str:
    """As ROS's camera_calibration_parsers write it, with our own numbers under the key ``gantry``."""
    lens = stored.intrinsics
    extra: dict[str, object] = {"covariance": stored.covariance.tolist()}
    if stored.pose is not None:
        extra["position_m"] = stored.pose.position_m.tolist()
        extra["world_from_camera"] = stored.pose.world_from_camera.tolist()
    if stored.geo is not None:
        extra["geo_reference"] = asdict(stored.geo)
    projection = np.column_stack([lens.matrix, np.zeros(3)])
    content = {
        "image_width": lens.width_px,
        "image_height": lens.height_px,
        "camera_name": stored.name,
        "camera_matrix": _ros_matrix(lens.matrix),
        "distortion_model": _PLUMB_BOB,
        "distortion_coefficients": _ros_matrix(lens.distortion.reshape(1, 5)),
        "rectification_matrix": _ros_matrix(np.eye(3)),
        "projection_matrix": _ros_matrix(projection),
        "gantry": extra,
    }
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None)


def from_ros(content: object) -> StoredCamera:
    """The inverse of ``to_ros``, and of what ROS writes. Raises InputError or msgspec's ValidationError."""
    told = msgspec.convert(content, _CameraInfo, strict=False)
    if told.distortion_model != _PLUMB_BOB:
        raise InputError(f"distortion_model {told.distortion_model} is not known; only {_PLUMB_BOB} is")
    extra, pose = told.gantry, None
    if extra and extra.position_m is not None and extra.world_from_camera is not None:
        pose = Pose(np.array(extra.world_from_camera), np.array(extra.position_m))
    return StoredCamera(
        told.camera_name,
        _intrinsics((told.image_width, told.image_height), told.camera_matrix.data, told.distortion_coefficients.data),
        pose,
        _numbers(extra.covariance, (_SIZE, _SIZE), "covariance") if extra else np.zeros((_SIZE, _SIZE)),
        extra.geo_reference if extra else None,
    )


def _ros_matrix(matrix: FloatArray) -> dict[str, object]:
    rows, columns = matrix.shape
    return {"rows": rows, "cols": columns, "data": matrix.ravel().tolist()}


def _intrinsics(size: tuple[float, float], matrix: Any, distortion: Any) -> Intrinsics:
    """Raises InputError for a skewed matrix and for a lens that Brown's five numbers cannot say."""
    k = _numbers(matrix, (3, 3), "camera_matrix")
    if k[0, 1] or k[1, 0] or k[2].tolist() != [0, 0, 1]:
        raise InputError("camera_matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
    told = np.asarray(distortion, dtype=np.float64).ravel()
    if len(told) < 4 or told[5:].any():
        raise InputError(f"distortion_coefficients must be k1, k2, p1, p2 and perhaps k3, got {told.tolist()}")
    numbers = float(k[0, 0]), float(k[1, 1]), float(k[0, 2]), float(k[1, 2])
    return Intrinsics(int(size[0]), int(size[1]), *numbers, np.append(told, 0.0)[:5])


def _numbers(values: Any, shape: tuple[int, ...], name: str) -> FloatArray:
    try:
        array = np.asarray(values, dtype=np.float64)
        return array.reshape(shape)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must hold {' x '.join(map(str, shape))} numbers") from error
