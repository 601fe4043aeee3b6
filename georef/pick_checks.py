"""Picks that cannot determine a camera, told by the reason."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from contracts import CalibrationError, FloatArray
from georef.picks import PointPicks

_STRAIGHT = 0.01  # width of a set over its length below which it counts as a line
_ONE_SIDE = 1 / 3  # of the image's width or height, within which all picks lie
_LEAST_AREA = 0.01  # of the image, inside the picks' convex hull


def check_enough(name: str, count: int, what: str, *, least: int, good: int | None = None) -> None:
    """Raises CalibrationError for fewer picks than leave something over to tell a wrong one by.

    good: the number to advise; None where nobody chooses how many there are.
    """
    if count < least:
        advice = f", and {good} are a good number" if good else ""
        raise CalibrationError(f'camera "{name}": {count} {what}; at least {least} are needed{advice}')


def check_spread(
    name: str, points: PointPicks, width_px: int, height_px: int, *, on_lines_px: FloatArray | None = None
) -> None:
    """Raises CalibrationError for picks on a line (of map or image), in a spot or on one side of the image.

    on_lines_px: (M, 2) pixels picked on lines, which can put picks on the side where there are no points.
    """
    for places, where in ((points.points_m, "on the map"), (points.pixels, "in the image")):
        if _width_over_length(places) < _STRAIGHT:
            raise CalibrationError(
                f'camera "{name}": the {len(points)} points lie on a line {where}; pick some beside it'
            )
    share = points.pixels / [width_px, height_px]
    every = share if on_lines_px is None else np.concatenate([share, on_lines_px / [width_px, height_px]])
    for low, high, side in (
        (every[:, 0].max() < _ONE_SIDE, every[:, 0].min() > 1 - _ONE_SIDE, ("left", "right")),
        (every[:, 1].max() < _ONE_SIDE, every[:, 1].min() > 1 - _ONE_SIDE, ("upper", "lower")),
    ):
        if low or high:
            raise CalibrationError(
                f'camera "{name}": all {len(points)} points lie in the {side[0] if low else side[1]} third of the '
                "image, all on one side; pick some on the other, or pixels on lines there"
            )
    if _hull_area(share) < _LEAST_AREA:
        raise CalibrationError(
            f'camera "{name}": the {len(points)} points cover {_hull_area(share):.2%} of the image; spread them out'
        )


def _width_over_length(places: FloatArray) -> float:
    spread = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return float(spread[1] / spread[0]) if spread[0] > 0 else 0.0


def _hull_area(places: FloatArray) -> float:
    try:
        return float(ConvexHull(places).volume)  # in the plane Qhull's volume is the area
    except QhullError:
        return 0.0
