"""How far the calibrated cameras are from the true ones: their parameters, and what that does to pixels and places."""

import numpy as np

from bench.recording import Manifest
from bench.scores import Score
from bench.scoring.ground import rms
from bench.scoring.rays import to_pixels, to_plane
from contracts import Camera, FloatArray

GRID = 11  # points per side of the raster that stands for the whole image
UNITS = {
    "position_error_m": "m",
    "rotation_error_rad": "rad",
    "focal_error_px": "px",
    "principal_point_error_px": "px",
    "reprojection_rms_px": "px",
    "ground_rms_m": "m",
}


def calibration_scores(manifest: Manifest, cameras: tuple[str, ...]) -> list[Score]:
    """The ``camera_errors`` of every camera; not valid where the true or the calibrated one is not known."""
    true_cameras = {camera.name: camera for camera in manifest.true_cameras}
    estimates = {one.camera.name: one.camera for one in manifest.calibrated_cameras}
    scores = []
    for name in cameras:
        known = name in true_cameras and name in estimates
        errors = camera_errors(true_cameras[name], estimates[name]) if known else {}
        for key, unit in UNITS.items():
            n = 0 if key not in errors else GRID**2 if "rms" in key else 1
            scores.append(Score.of(f"calibration.{name}.{key}", errors.get(key, np.nan), unit, n))
    return scores


def camera_errors(truth: Camera, estimate: Camera) -> dict[str, float]:
    """The keys of ``UNITS``.

    Distance of the optical centres; angle of the rotation between the two; root mean square of the errors of fx and
    fy; distance of the principal points. Then over a raster of the image: how far apart the two cameras image the same
    point of the floor, and how far apart they place the same pixel on it. The parameters of a camera that looks
    straight down trade against each other (height against focal length): the last two say what is left of that.
    """
    a, b = truth.intrinsics, estimate.intrinsics
    pixels = raster(truth)
    true_floor_m, floor_m = (to_plane(camera, pixels, np.zeros(len(pixels))) for camera in (truth, estimate))
    points_m = np.column_stack([true_floor_m, np.zeros(len(pixels))])  # (GRID^2, 3)
    return {
        "position_error_m": float(np.linalg.norm(estimate.pose.position_m - truth.pose.position_m)),
        "rotation_error_rad": rotation_angle(estimate.pose.world_from_camera @ truth.pose.world_from_camera.T),
        "focal_error_px": rms(np.array([b.fx_px - a.fx_px, b.fy_px - a.fy_px])),
        "principal_point_error_px": float(np.hypot(b.cx_px - a.cx_px, b.cy_px - a.cy_px)),
        "reprojection_rms_px": rms(np.linalg.norm(to_pixels(estimate, points_m) - pixels, axis=1)),
        "ground_rms_m": rms(np.linalg.norm(floor_m - true_floor_m, axis=1)),
    }


def raster(camera: Camera) -> FloatArray:
    """``GRID`` x ``GRID`` pixels spread over the image from corner to corner, (GRID^2, 2)."""
    lens = camera.intrinsics
    u, v = np.meshgrid(np.linspace(0, lens.width_px - 1, GRID), np.linspace(0, lens.height_px - 1, GRID))
    return np.column_stack([u.ravel(), v.ravel()])


def rotation_angle(rotation: FloatArray) -> float:
    """Angle of a rotation matrix in [0, pi], radians; exact for small angles, where the arc cosine is not."""
    skew = rotation - rotation.T
    sine = 0.5 * np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]])
    cosine = 0.5 * (np.trace(rotation) - 1)
    return float(np.arctan2(sine, cosine))
