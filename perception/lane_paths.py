"""Lanes found in an image: the strokes to the left and right of a lane, and the path between them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import Camera, FloatArray
from contracts.arrays import freeze
from georef.hd_map import LaneCentreline
from georef.projection import project
from perception.paint_map import Looks, PaintLine, looks_along
from perception.road_paint import strokes_across

_EVERY_PX, _FARTHEST_M = 4.0, 62.0
_STROKE_M = 0.15
_GATE_PX, _LEAST_FOUND = 4.0, 8
_UNEVEN = 0.25  # how unlike the grounds beside a stroke may be: grass and asphalt draw its middle to one side
_GAP = 24  # places that a dashed stroke may leave open


@dataclass(frozen=True, eq=False)
class LanePath:
    """The main path of one lane in the image, from near to far. lane: its id; pixels: (N, 2)."""

    lane: str
    pixels: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "pixels", shape=(None, 2))


def lane_path(light: NDArray[np.float32], camera: Camera, lane: LaneCentreline) -> LanePath | None:
    """The path between the strokes that bound a lane; None where they are not both found.

    light: (H, W) levels, see ``perception.road_paint.brightness``. camera: says where to look, 4 px to either side;
    where the strokes are is measured, but for a lane's first and last decimetres. Over the gaps of a dashed stroke the
    departure is interpolated.
    """
    looks = looks_along(
        camera, PaintLine(lane.id, lane.points_m, _STROKE_M, lane.points_m), every_px=_EVERY_PX, farthest_m=_FARTHEST_M
    )
    if not len(looks.pixels):
        return None
    sides = [_side(light, camera, looks, side * lane.width_m / 2) for side in (-1.0, 1.0)]
    known = [side for side in sides if side is not None]
    if len(known) < 2:
        return None
    middle = (known[0] + known[1]) / 2
    path = middle[np.isfinite(middle[:, 0])]
    if len(path) < _LEAST_FOUND:
        return None
    return LanePath(lane.id, path[np.argsort(-path[:, 1], kind="stable")])


def _side(light: NDArray[np.float32], camera: Camera, looks: Looks, right_m: float) -> FloatArray | None:
    """Pixels (N, 2) of the stroke beside each place, NaN where it is neither found nor near to where it is."""
    expected, valid = project(camera, looks.places_m + right_m * looks.right)
    rows = np.flatnonzero(valid)
    scale = looks.across_px_per_m[rows]
    width, reach = _STROKE_M * scale, np.minimum(_GATE_PX, 0.5 * scale)
    found = strokes_across(light, expected[rows], looks.normals[rows], width, reach, uneven=_UNEVEN)
    hits = rows[found.seen]
    if len(hits) < _LEAST_FOUND:
        return None
    departures = found.pixels[found.seen] - expected[hits]
    numbers = np.arange(len(expected))
    pixels = expected + np.column_stack([np.interp(numbers, hits, departures[:, axis]) for axis in range(2)])
    gap = np.abs(numbers[:, None] - hits).min(axis=1)
    pixels[gap > _GAP] = np.nan
    return np.asarray(pixels)
