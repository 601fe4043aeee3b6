"""What cameras see of the ground, what none of them sees, and how an image passes into another over the ground.

Buildings and vehicles are not known here: a place counts as seen when it lies in the image and near enough.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from contracts import BoolArray, Camera, FloatArray, InputError
from georef.geo_reference import GeoReference
from georef.homography import image_from_plane, plane_from_image
from georef.location import on_plane
from georef.projection import project, rays

_BORDER_STEP_PX = 8.0


def image_from_image(first: Camera, second: Camera, height_m: float = 0.0) -> FloatArray:
    """H_ij (3, 3): pixels of ``first`` to pixels of ``second`` over the plane z = ``height_m``, both without lens.

    Source: paper T, section 3 (H_ij); Hartley & Zisserman 2004, section 13.1. Raises CalibrationError for a camera in
    that plane.
    """
    homography: FloatArray = image_from_plane(second, height_m) @ plane_from_image(first, height_m)
    return homography / np.linalg.norm(homography)


def pixels_in_other(
    first: Camera, second: Camera, pixels: FloatArray, height_m: float = 0.0
) -> tuple[FloatArray, BoolArray]:
    """Where ``second`` sees what ``first`` sees at ``pixels`` (N, 2) on the plane z = ``height_m``, lenses included.

    Returns pixels (N, 2), NaN where not valid (N,): no such place, or not before the second camera.
    """
    places, met = on_plane(first, pixels, height_m)
    seen, valid = project(second, np.where(met[:, None], places, 0.0))
    valid = valid & met
    return np.where(valid[:, None], seen, np.nan), valid


_BEYOND = 4.0  # of the farthest distance: so far the border is carried before the circle cuts it
_CIRCLE = 512  # sides of a quarter of the circle


def view(camera: Camera, farthest_m: float) -> BaseGeometry:
    """The ground z = 0 in the camera's image within ``farthest_m`` of its foot, local metres; perhaps empty.

    The image's border is carried to the ground; where it looks farther or into the sky, the circle takes its place.
    """
    if not 0 < farthest_m < np.inf:
        raise InputError(f"the farthest distance {farthest_m} m must be positive and finite")
    border = _border(camera)
    directions, known = rays(camera, border)
    directions = directions[known]
    flat = np.hypot(directions[:, 0], directions[:, 1])
    foot = camera.pose.position_m[:2]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.where(directions[:, 2] < 0, camera.pose.position_m[2] * flat / -directions[:, 2], np.inf)
    if not (reach < farthest_m).any():
        return shapely.Polygon()
    reach = np.minimum(reach, _BEYOND * farthest_m)
    outline = foot + reach[:, None] * directions[:, :2] / np.maximum(flat, 1e-12)[:, None]
    disc = shapely.Point(foot).buffer(farthest_m, quad_segs=_CIRCLE)  # a chord of it stays within 0.1 mm at 50 m
    return shapely.make_valid(shapely.Polygon(outline)).buffer(0).intersection(disc)


def blind_spots(cameras: Sequence[Camera], area: BaseGeometry, farthest_m: float) -> BaseGeometry:
    """The part of ``area`` (a polygon in local metres) that no camera sees within ``farthest_m``."""
    if not (area.is_valid and area.area > 0):
        raise InputError("the area whose blind spots are wanted is no valid polygon")
    return area.difference(shapely.union_all([view(camera, farthest_m) for camera in cameras]))


def layer(parts: Mapping[str, BaseGeometry], geo: GeoReference) -> dict[str, Any]:
    """Areas by name as a GeoJSON layer in WGS84 (RFC 7946), for example of views and blind spots."""

    def to_wgs84(positions: FloatArray) -> FloatArray:
        return geo.to_wgs84(positions)[:, ::-1]

    features = [
        {
            "type": "Feature",
            "id": name,
            "properties": {"name": name, "area_m2": part.area},
            "geometry": shapely.geometry.mapping(shapely.transform(part, to_wgs84)),
        }
        for name, part in parts.items()
    ]
    return {"type": "FeatureCollection", "features": features}


def _border(camera: Camera) -> FloatArray:
    """(N, 2) pixels round the image's outer edge."""
    width, height = camera.intrinsics.width_px, camera.intrinsics.height_px
    corners = np.array([[-0.5, -0.5], [width - 0.5, -0.5], [width - 0.5, height - 0.5], [-0.5, height - 0.5]])
    sides = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        steps = int(np.ceil(np.abs(end - start).max() / _BORDER_STEP_PX))
        sides.append(start + np.arange(steps)[:, None] / steps * (end - start))
    return np.concatenate(sides)
