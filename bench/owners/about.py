"""``gantry calibrate about``: the file of a camera as its owner knows it before it is calibrated on its map."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from contracts import FloatArray, InputError, Intrinsics, Pose
from georef.calibrated import PARAMETERS
from georef.camera_file import read_stored, write_stored
from georef.camera_forms import StoredCamera
from georef.geo_reference import GeoReference
from georef.hd_map_file import read_map
from perception.frame_calibration import Mounting


@dataclass(frozen=True)
class Hanging:
    """Where a camera hangs and looks, upright.

    at_m, at_deg: its foot as the map's east and north, metres, or as latitude and longitude; one of the two.
    height_m: above z = 0. heading_deg: where it looks, counter-clockwise from east. down_deg: below the horizon.
    Raises InputError for what cannot be.
    """

    at_m: tuple[float, float] | None
    at_deg: tuple[float, float] | None
    height_m: float
    heading_deg: float
    down_deg: float

    def __post_init__(self) -> None:
        if (self.at_m is None) == (self.at_deg is None):
            raise InputError("give its place either as --at-m or as --at-deg")
        if not (np.isfinite(self.height_m) and self.height_m > 0):
            raise InputError(f"--height-m {self.height_m:g} must be positive")
        if not np.isfinite(self.heading_deg):
            raise InputError(f"--heading-deg {self.heading_deg:g} must be finite")
        if not abs(self.down_deg) <= 90:
            raise InputError(f"--down-deg {self.down_deg:g} must lie within -90 and 90")

    def pose(self, geo: GeoReference) -> Pose:
        """In the local metres of ``geo``."""
        east_m, north_m = self.at_m or geo.to_local(np.array(self.at_deg)).tolist()
        looking = _looking(np.radians(self.heading_deg), np.radians(self.down_deg))
        return Pose(looking, np.array([east_m, north_m, self.height_m]))


def known_lens(name: str, lens: Path | None, size_px: tuple[int, int] | None, focal_px: float | None) -> StoredCamera:
    """The lens of a file that ``gantry calibrate intrinsics`` wrote, or a plain one of the focal length.

    name: of the camera. Raises InputError for neither or both.
    """
    if lens is not None and size_px is None and focal_px is None:
        return replace(read_stored(lens), name=name)
    if lens is None and size_px is not None and focal_px is not None:
        return _plain_lens(name, size_px, focal_px)
    raise InputError("give either --lens, or --focal-px together with --size")


def write_about(lens: StoredCamera, hanging: Hanging, map_path: Path, out: Path) -> None:
    """Write the camera's file. Place, direction and focal length are where ``gantry calibrate frames`` begins."""
    geo = read_map(map_path).geo
    mounting, covariance = Mounting(), np.array(lens.covariance)
    pose_sigmas = [*3 * [mounting.turn_rad / 2], *3 * [mounting.position_sigma_m]]
    covariance[9:, :9] = covariance[:9, 9:] = 0.0  # of another pose
    covariance[9:, 9:] = np.diag(np.square(pose_sigmas))
    write_stored(out, replace(lens, pose=hanging.pose(geo), covariance=covariance, geo=geo))


def _looking(heading_rad: float, down_rad: float) -> FloatArray:
    """``world_from_camera`` (3, 3) of a camera that stands upright."""
    level = np.array([np.cos(heading_rad), np.sin(heading_rad), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    ahead = np.cos(down_rad) * level - np.sin(down_rad) * up
    right = np.cross(level, up)
    return np.column_stack([right, np.cross(ahead, right), ahead])


def _plain_lens(name: str, size_px: tuple[int, int], focal_px: float) -> StoredCamera:
    """A lens that bends nothing, its axis in the middle of the image."""
    width, height = size_px
    lens = Intrinsics(width, height, focal_px, focal_px, (width - 1) / 2, (height - 1) / 2, np.zeros(5))
    mounting, sigmas = Mounting(), np.zeros(len(PARAMETERS))
    sigmas[:2] = mounting.focal_share * focal_px
    sigmas[2:4] = mounting.principal_point_share * width
    sigmas[4:6] = mounting.k1, mounting.k2
    return StoredCamera(name, lens, None, np.diag(sigmas**2))
