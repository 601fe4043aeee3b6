"""Which point of the map to pick next: the one that makes places on the road most certain.

The covariance P of a calibration shrinks by one more pick with derivatives J and noise R to P - P J^T (J P J^T + R)^-1
J P, whatever the pick turns out to be; what counts is the trace of the places' covariance G P G^T over the road
(V-optimal design: Atkinson & Donev 1992, section 10.6).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, FloatArray
from contracts.arrays import frozen_array
from georef.calibrated import CalibratedCamera
from georef.ground_homography import GroundHomography, image_of_ground, place_by_homography
from georef.location import place
from georef.projection import project, project_with_derivatives

_ON_GROUND_M = 1e-6


@dataclass(frozen=True, eq=False)
class Gain:
    """What each candidate would bring.

    drops_m2: (K,) by which the mean over the road of the position's variance (east and north together) falls; NaN for
        candidates that the camera does not see.
    now_m2: that mean before.
    """

    drops_m2: FloatArray
    now_m2: float

    @property
    def best(self) -> int | None:
        """The candidate to pick next, or None if the camera sees none."""
        return int(np.nanargmax(self.drops_m2)) if np.isfinite(self.drops_m2).any() else None


def gains(
    calibrated: CalibratedCamera | GroundHomography,
    candidates_m: FloatArray,
    road_m: FloatArray,
    *,
    sigma_px: float = 1.0,
    sigma_m: float = 0.0,
) -> Gain:
    """What picking each of ``candidates_m`` (K, 3) would bring to places ``road_m`` (T, 2) on the ground.

    sigma_px: of a pick. sigma_m: of the map. Places that the camera does not see are left out.
    """
    candidates = frozen_array(candidates_m, name="candidates_m", shape=(None, 3))
    covariance, rows, noise, seen, to_road = _derivatives(calibrated, candidates, road_m, sigma_px, sigma_m)
    drops = _drops(covariance, rows, noise, to_road)
    now = float(np.einsum("tip,pq,tiq->", to_road, covariance, to_road)) / max(len(to_road), 1)
    return Gain(np.where(seen, drops, np.nan), now)


def choose(
    calibrated: CalibratedCamera | GroundHomography,
    candidates_m: FloatArray,
    road_m: FloatArray,
    count: int,
    *,
    sigma_px: float = 1.0,
    sigma_m: float = 0.0,
) -> list[int]:
    """``count`` candidates, or as many as are seen, each the best after those before it."""
    candidates = frozen_array(candidates_m, name="candidates_m", shape=(None, 3))
    covariance, rows, noise, seen, to_road = _derivatives(calibrated, candidates, road_m, sigma_px, sigma_m)
    left = seen.copy()
    chosen: list[int] = []
    while len(chosen) < count and left.any():
        best = int(np.where(left, _drops(covariance, rows, noise, to_road), -np.inf).argmax())
        across = rows[best] @ covariance
        covariance = covariance - across.T @ np.linalg.solve(across @ rows[best].T + noise[best], across)
        left[best] = False
        chosen.append(best)
    return chosen


def _drops(covariance: FloatArray, rows: FloatArray, noise: FloatArray, to_road: FloatArray) -> FloatArray:
    across = rows @ covariance  # (K, 2, p)
    told = across @ np.swapaxes(rows, 1, 2) + noise
    road = np.einsum("tip,tiq->pq", to_road, to_road) / max(len(to_road), 1)
    drops: FloatArray = np.einsum("kij,kji->k", np.linalg.inv(told), across @ road @ np.swapaxes(across, 1, 2))
    return drops


def _derivatives(
    calibrated: CalibratedCamera | GroundHomography,
    candidates: FloatArray,
    road_m: FloatArray,
    sigma_px: float,
    sigma_m: float,
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray, FloatArray]:
    """Covariance (p, p); rows (K, 2, p), noise (K, 2, 2), seen (K,) of each pick; places by parameters (T, 2, p)."""
    road = np.asarray(road_m, dtype=np.float64).reshape(-1, 2)
    if isinstance(calibrated, GroundHomography):
        image = image_of_ground(calibrated.image_from_ground, candidates[:, :2])
        pixels, rows, by_point = image.pixels, image.by_entries, image.by_place
        valid = image.valid & (np.abs(candidates[:, 2]) < _ON_GROUND_M)
        size = calibrated.width_px, calibrated.height_px
        on_road = image_of_ground(calibrated.image_from_ground, road)
        kept = on_road.pixels[on_road.valid & _inside(on_road.pixels, size)]
        to_road = place_by_homography(calibrated, kept).by_entries
    else:
        projection = project_with_derivatives(calibrated.camera, candidates)
        pixels, rows, by_point = projection.pixels, projection.by_parameters, projection.by_point
        valid = projection.valid
        size = calibrated.camera.intrinsics.width_px, calibrated.camera.intrinsics.height_px
        road_px, road_valid = project(calibrated.camera, np.column_stack([road, np.zeros(len(road))]))
        kept = road_px[road_valid & _inside(road_px, size)]
        to_road = place(calibrated.camera, kept, 0.0).by_parameters
    seen = valid & _inside(pixels, size)
    rows = np.where(seen[:, None, None], rows, 0.0)
    by_point = np.where(seen[:, None, None], by_point, 0.0)
    noise = sigma_px**2 * np.eye(2) + sigma_m**2 * by_point @ np.swapaxes(by_point, 1, 2)
    return calibrated.covariance, rows, noise, seen, to_road


def _inside(pixels: FloatArray, size: Sequence[int]) -> BoolArray:
    return np.asarray(((pixels > -0.5) & (pixels < np.array(size) - 0.5)).all(axis=1))
