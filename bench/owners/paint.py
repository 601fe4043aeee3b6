"""``gantry calibrate frames``: a camera from images of the road and the map of its paint."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.owners.calibrations import Calibration, read_images
from contracts import InputError
from georef.camera_file import read_camera, write_stored
from georef.camera_forms import CameraForm, StoredCamera
from georef.hd_map_file import read_map
from perception.frame_calibration import calibrate_from_frames


def calibrate_from_images(
    images: Sequence[Path], its_map: tuple[Path, float], near: Path, out: Path, *, name: str, form: str
) -> Calibration:
    """The whole camera from images of the road and its map; writes its file, under the name ``name``.

    its_map: file, and standard deviation of its places, metres per axis. near: file of a camera about where this one
    hangs, with its focal length. Raises InputError and CalibrationError.
    """
    map_path, map_sigma_m = its_map
    if not (np.isfinite(map_sigma_m) and map_sigma_m >= 0):
        raise InputError(f"--map-sigma-m {map_sigma_m} must not be negative")
    hd_map, nominal = read_map(map_path), replace(read_camera(near).camera, name=name)
    frames = read_images(images, name)
    size = nominal.intrinsics.height_px, nominal.intrinsics.width_px
    for path, frame in zip(images, frames, strict=True):
        if frame.image.shape[:2] != size:
            height, width = frame.image.shape[:2]
            raise InputError(f"{path} is {width}x{height}, but the camera in {near} {size[1]}x{size[0]}")
    whole = calibrate_from_frames(frames, nominal, hd_map, map_sigma_m=map_sigma_m)
    write_stored(out, StoredCamera.of(whole.calibrated, hd_map.geo), CameraForm(form))
    return Calibration.of(whole.calibrated, whole.picks)
