"""From image points to places on the ground: the ray through the anchor meets the plane on which the anchor lies."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, Camera, FloatArray, GroundTracks, InputError, Tracks
from georef.calibrated import CalibratedCamera
from georef.projection import project_with_derivatives, rays


@dataclass(frozen=True, eq=False)
class Placement:
    """Places on a horizontal plane and how they move with what they were computed from.

    positions_m: (..., 2) east, north; NaN where not valid.
    valid: (...) the ray meets the plane in front of the camera.
    by_pixel: (..., 2, 2) metres per pixel.
    by_parameters: (..., 2, 15) with respect to the camera's ``georef.calibrated.PARAMETERS``.
    """

    positions_m: FloatArray
    valid: BoolArray
    by_pixel: FloatArray
    by_parameters: FloatArray


def on_plane(camera: Camera, pixels: FloatArray, height_m: FloatArray | float) -> tuple[FloatArray, BoolArray]:
    """Intersect the rays through ``pixels`` with horizontal planes.

    pixels: (..., 2). height_m: (...) or one number, metres above the ground.
    Returns positions (..., 3) in the world and valid (...): False, with NaN, for rays at or above the horizon, planes
    behind the camera and pixels beyond the lens's fold.
    """
    directions, valid = rays(camera, pixels)
    climb = directions[..., 2]
    to_plane = np.asarray(height_m, dtype=np.float64) - camera.pose.position_m[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = to_plane / climb
    valid = valid & (distance > 0) & np.isfinite(distance)
    positions = camera.pose.position_m + np.where(valid, distance, np.nan)[..., None] * directions
    return positions, valid


def place(camera: Camera, pixels: FloatArray, height_m: FloatArray | float) -> Placement:
    """``on_plane`` with derivatives, from the implicit function project(camera, position) = pixel.

    With A = d pixel / d position (east, north), a change of the pixel moves the position by A^-1, a change of the
    camera's parameters p by -A^-1 (d pixel / d p).
    """
    positions, valid = on_plane(camera, pixels, height_m)
    projection = project_with_derivatives(camera, positions)
    by_position = np.where(valid[..., None, None], projection.by_point[..., :2], np.eye(2))
    by_pixel = np.linalg.inv(by_position)
    by_parameters = -by_pixel @ projection.by_parameters
    return Placement(
        positions[..., :2],
        valid,
        np.where(valid[..., None, None], by_pixel, np.nan),
        np.where(valid[..., None, None], by_parameters, np.nan),
    )


class RayPlaneLocator:
    """Places tracks by ray and plane at each anchor's own height; implements ``contracts.Locator``.

    cameras: calibrated cameras by name.
    """

    def __init__(self, cameras: Mapping[str, CalibratedCamera]) -> None:
        self._cameras = dict(cameras)

    def locate(self, tracks: Tracks) -> GroundTracks:
        """Positions and their covariance: the anchor's share and the calibration's share added.

        Raises InputError for a camera that was not calibrated.
        """
        return self._locate(tracks, tracks.objects.anchor_heights_m)

    def _locate(self, tracks: Tracks, heights_m: FloatArray) -> GroundTracks:
        calibrated = self._camera(tracks.objects.camera)
        return self._placed(tracks, calibrated, place(calibrated.camera, tracks.objects.anchors_px, heights_m))

    @staticmethod
    def _placed(tracks: Tracks, calibrated: CalibratedCamera, placement: Placement) -> GroundTracks:
        objects = tracks.objects
        return GroundTracks(
            source=objects.camera,
            time_ns=objects.time_ns,
            ids=tracks.ids,
            labels=objects.labels,
            positions_m=placement.positions_m,
            covs_m2=_propagate(placement.by_pixel, objects.anchor_covs_px2)
            + _propagate(placement.by_parameters, calibrated.covariance),
            valid=placement.valid,
        )

    def _camera(self, name: str) -> CalibratedCamera:
        if name not in self._cameras:
            raise InputError(f'no calibration for camera "{name}"; calibrated are: {", ".join(sorted(self._cameras))}')
        return self._cameras[name]


class GroundPlaneLocator(RayPlaneLocator):
    """Places every anchor at z = 0, whatever its height: the homography of the rail paper, kept for comparison.

    With the lens removed first, ray and plane at z = 0 is the plane homography W = H^-1 C (``georef.homography``).
    """

    def locate(self, tracks: Tracks) -> GroundTracks:
        """Positions as if every anchor lay on the ground; the covariance does not know of that error."""
        return self._locate(tracks, np.zeros(len(tracks)))


def _propagate(jacobian: FloatArray, covariance: FloatArray) -> FloatArray:
    """J Sigma J^T, made exactly symmetric."""
    spread = jacobian @ covariance @ np.swapaxes(jacobian, -1, -2)
    return 0.5 * (spread + np.swapaxes(spread, -1, -2))
