"""Location on a road that climbs: the ground's height from the map, and rays that meet it.

A ray is followed from the camera until it first dips beneath the ground, and the last step is halved until the place is
exact: what is seen is what the ray meets first, however flat it meets it.
"""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator

from contracts import Camera, FloatArray, GroundTracks, InputError, IntArray, Tracks
from georef.calibrated import CalibratedCamera
from georef.hd_map import HdMap, Line
from georef.location import Placement, RayPlaneLocator, place
from georef.projection import rays

_STEP_M, _SLOPE_OVER_M = 2.0, 0.5
_FARTHEST_M, _STRIDE_M, _HALVINGS = 500.0, 2.0, 40  # the last is exact to a nanometre


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

    A ray that meets nothing within 500 m is not valid. With p(h) the place on the plane of height h and g the ground's
    slope, dp = (I - dp/dh g^T)^-1 of what it is on that plane.
    """
    here = camera.pose.position_m
    met = _met(camera, pixels, above_m, ground)
    heights = ground.heights_m(met) + above_m
    placed = place(camera, pixels, np.where(np.isfinite(heights), heights, here[2]))
    valid = placed.valid & np.isfinite(heights)
    by_height = (met - here[:2]) / (heights - here[2])[:, None]
    turn = np.eye(2) - by_height[:, :, None] * ground.slopes(met)[:, None, :]
    turn = np.linalg.inv(np.where(valid[:, None, None], turn, np.eye(2)))
    return Placement(
        np.where(valid[:, None], met, np.nan),
        valid,
        np.where(valid[:, None, None], turn @ placed.by_pixel, np.nan),
        np.where(valid[:, None, None], turn @ placed.by_parameters, np.nan),
    )


def _met(camera: Camera, pixels: FloatArray, above_m: FloatArray, ground: MapGround) -> FloatArray:
    """Positions (N, 2) where the rays first come down to ``above_m`` over the ground; NaN where they do not."""
    here = camera.pose.position_m
    directions, known = rays(camera, pixels)
    flat = np.maximum(np.linalg.norm(directions[:, :2], axis=1), 1e-12)  # straight down counts as hardly sideways

    def over(reach_m: FloatArray, rows: IntArray) -> FloatArray:
        """How far (R, S) the rays of ``rows`` (R,) are above what they should meet, at distances (R, S) over ground."""
        along = reach_m / flat[rows, None]
        positions = here[:2] + along[..., None] * directions[rows, None, :2]
        heights = ground.heights_m(positions.reshape(-1, 2)).reshape(along.shape)
        return np.asarray(here[2] + along * directions[rows, None, 2] - heights - above_m[rows, None])

    met = np.full((len(pixels), 2), np.nan)
    rows = np.flatnonzero(known)
    strides = np.arange(0.0, _FARTHEST_M + _STRIDE_M, _STRIDE_M)
    beneath = over(np.broadcast_to(strides, (len(rows), len(strides))), rows) <= 0.0
    kept = beneath.any(axis=1) & ~beneath[:, 0]
    rows, last = rows[kept], beneath[kept].argmax(axis=1)
    near, far = strides[last - 1], strides[last]
    for _ in range(_HALVINGS):
        middle = 0.5 * (near + far)
        is_beneath = over(middle[:, None], rows)[:, 0] <= 0.0
        near, far = np.where(is_beneath, near, middle), np.where(is_beneath, middle, far)
    met[rows] = here[:2] + (far / flat[rows])[:, None] * directions[rows, :2]
    return met


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
