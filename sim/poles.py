"""What stands on poles beside the road is put together from poles, and arms that reach towards it."""

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from contracts import FloatArray
from sim.lights import Rgb
from sim.meshes import Mesh, boxes, prism
from sim.road_scene import PartKind, StillPart

STEEL: Rgb = (0.44, 0.45, 0.46)
_SIDES = 6


def pole(name: str, foot_m: FloatArray, height_m: float, radius_m: float) -> StillPart:
    """An upright pole of steel."""
    ring = np.array([foot_m[:2] + radius_m * np.array([np.cos(t), np.sin(t)]) for t in turns(_SIDES)])
    return StillPart(name, PartKind.POLE, prism(ring, bottom_m=foot_m[2] - 0.2, top_m=foot_m[2] + height_m), STEEL)


def bar(a_m: FloatArray, b_m: FloatArray, width_m: float, thick_m: float | None = None) -> Mesh:
    """A level box, the middle of whose underside goes from ``a_m`` to ``b_m`` (3,)."""
    along = b_m[:2] - a_m[:2]
    size = np.array([float(np.linalg.norm(along)), width_m, width_m if thick_m is None else thick_m])
    heading = np.array([np.arctan2(along[1], along[0])])
    return boxes(((a_m + b_m) / 2)[None, :2], heading, size, bottom_m=float(a_m[2]))


def towards(area: BaseGeometry, position_m: FloatArray) -> FloatArray:
    """Unit vector (3,), level, from a place beside ``area`` straight towards it; to its middle from within."""
    ends = shapely.get_coordinates(shapely.shortest_line(shapely.Point(position_m[:2]), area))
    way = ends[1] - ends[0]
    if not way.any():
        way = shapely.get_coordinates(area.centroid)[0] - position_m[:2]
    return np.array([*(way / max(float(np.linalg.norm(way)), 1e-9)), 0.0])


def turns(count: int) -> FloatArray:
    """Angles of a regular polygon's corners, (count,)."""
    return np.asarray(2 * np.pi * np.arange(count) / count)
