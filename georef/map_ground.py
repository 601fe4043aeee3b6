"""Location on a road that climbs: the ground's height from the map, and rays that meet it.

A ray meets the ground where it meets the horizontal plane of the height that the ground has there: a fixed point, which
is approached from the height under the camera. It converges where the ground climbs less than the ray falls.
"""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from contracts import Camera, FloatArray, GroundTracks, InputError, Tracks
from georef.calibrated import CalibratedCamera
from georef.hd_map import HdMap, Line
from georef.location import Placement, RayPlaneLocator, place

_STEP_M, _SLOPE_OVER_M = 2.0, 0.5
_ROUNDS, _SETTLED_M = 60, 1e-7


class MapGround:
    """The ground of a map: between its lines as triangles lie on them, beyond them as high as the nearest.

    lines: of the map, with heights. Raises InputError without any.
    """

    def __init__(self, lines: list[Line]) -> None:
        if not lines:
            raise InputError("the map has no line that tells the ground's height")
        points = np.concatenate([line.places_m(np.arange(0.0, line.length_m + _STEP_M, _STEP_M)) for line in lines])
        points = points[np.unique(np.round(points[:, :2], 3), axis=0, return_index=True)[1]]
        self._level_m = float(points[0, 2]) if np.ptp(points[:, 2]) < 1e-9 else None
        if self._level_m is None:
            self._between = LinearNDInterpolator(points[:, :2], points[:, 2])
            self._beyond = NearestNDInterpolator(points[:, :2], points[:, 2])

    @classmethod
    def of(cls, hd_map: HdMap) -> "MapGround":
        """From the lanes and what is painted along them."""
        return cls([*hd_map.centrelines, *hd_map.lane_markings, *hd_map.stop_lines])

    @property
    def is_level(self) -> bool:
        """Whether all heights are one."""
        return self._level_m is not None

    def heights_m(self, positions_m: FloatArray) -> FloatArray:
        """Heights (N,) at positions (N, 2); NaN at NaN."""
        positions = np.asarray(positions_m, dtype=np.float64)
        if self._level_m is not None:
            return np.where(np.isfinite(positions).all(axis=1), self._level_m, np.nan)
        known = np.isfinite(positions).all(axis=1)
        heights = np.full(len(positions), np.nan)
        heights[known] = self._between(positions[known])
        outside = known & ~np.isfinite(heights)
        heights[outside] = self._beyond(positions[outside])
        return heights

    def slopes(self, positions_m: FloatArray) -> FloatArray:
        """How much the ground climbs towards east and north at positions (N, 2): (N, 2), metres per metre."""
        steps = _SLOPE_OVER_M * np.eye(2)
        climbs = [self.heights_m(positions_m + step) - self.heights_m(positions_m - step) for step in steps]
        return np.column_stack(climbs) / (2 * _SLOPE_OVER_M)


def place_on_ground(camera: Camera, pixels: FloatArray, above_m: FloatArray, ground: MapGround) -> Placement:
    """Where the rays through ``pixels`` (N, 2) are ``above_m`` (N,) metres over the ground; with derivatives.

    A ray that does not settle, because the ground climbs towards it as fast as it falls, is not valid. With p(h) the
    place on the plane of height h and g the slope, dp = (I - dp/dh g^T)^-1 of what it is on that plane.
    """
    here = camera.pose.position_m
    heights = np.full(len(pixels), float(ground.heights_m(here[None, :2])[0])) + above_m
    for _ in range(_ROUNDS):
        placed = place(camera, pixels, heights)
        found = ground.heights_m(placed.positions_m) + above_m
        moved = np.abs(found - heights)
        heights = np.where(np.isfinite(found), found, heights)
        if not (moved > _SETTLED_M).any():
            break
    settled = placed.valid & (np.nan_to_num(moved, nan=np.inf) <= _SETTLED_M)
    by_height = (placed.positions_m - here[:2]) / (heights - here[2])[:, None]
    turn = np.eye(2) - by_height[:, :, None] * ground.slopes(placed.positions_m)[:, None, :]
    turn = np.linalg.inv(np.where(settled[:, None, None], turn, np.eye(2)))
    return Placement(
        np.where(settled[:, None], placed.positions_m, np.nan),
        settled,
        np.where(settled[:, None, None], turn @ placed.by_pixel, np.nan),
        np.where(settled[:, None, None], turn @ placed.by_parameters, np.nan),
    )


class MapGroundLocator(RayPlaneLocator):
    """Places tracks by ray and the map's ground, every anchor at its own height above it; a ``contracts.Locator``."""

    def __init__(self, cameras: Mapping[str, CalibratedCamera], ground: MapGround) -> None:
        super().__init__(cameras)
        self._ground = ground

    def locate(self, tracks: Tracks) -> GroundTracks:
        """As of ``RayPlaneLocator``; errors of the map's heights have no share in the covariance."""
        objects = tracks.objects
        camera = self._camera(objects.camera)
        placement = place_on_ground(camera.camera, objects.anchors_px, objects.anchor_heights_m, self._ground)
        return self._placed(tracks, camera, placement)
