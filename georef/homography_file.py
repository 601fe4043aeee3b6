"""A calibrated homography's file (YAML), and how to tell it from a camera's."""

from dataclasses import asdict
from pathlib import Path

import msgspec
import numpy as np
import yaml

from contracts import InputError
from contracts.files import write_whole
from georef.calibrated import CalibratedCamera
from georef.camera_file import read_stored
from georef.geo_reference import GeoReference
from georef.ground_homography import GroundHomography


class _HomographyFile(msgspec.Struct, forbid_unknown_fields=True):
    name: str
    width_px: int
    height_px: int
    image_from_ground: list[list[float]]
    covariance: list[list[float]]
    geo_reference: GeoReference | None = None


def write_homography(path: Path | str, homography: GroundHomography, geo: GeoReference | None = None) -> None:
    """Write ``homography`` so that ``read_found`` reads it back to the bit. Raises InputError if it cannot."""
    content = {
        "name": homography.name,
        "width_px": homography.width_px,
        "height_px": homography.height_px,
        "image_from_ground": homography.image_from_ground.tolist(),
        "covariance": homography.covariance.tolist(),
    }
    if geo is not None:
        content["geo_reference"] = asdict(geo)
    write_whole(path, yaml.safe_dump(content, sort_keys=False, default_flow_style=None))


def read_found(path: Path | str) -> tuple[CalibratedCamera | GroundHomography, GeoReference | None]:
    """The camera or the homography in the file at ``path``, and where its world lies.

    Raises InputError naming the file and what is wrong with it.
    """
    try:
        content = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        content = None  # OpenCV's form is no YAML 1.2; what is no file at all is told by the camera's reader
    try:
        if isinstance(content, dict) and "image_from_ground" in content:
            told = msgspec.convert(content, _HomographyFile, strict=False)
            numbers = np.array(told.image_from_ground), np.array(told.covariance)
            return GroundHomography(told.name, told.width_px, told.height_px, *numbers), told.geo_reference
        stored = read_stored(path)
        return stored.calibrated, stored.geo
    except (msgspec.ValidationError, ValueError) as error:
        message = str(error)
        raise InputError(message if message.startswith(f"{path}: ") else f"{path}: {message}") from error
