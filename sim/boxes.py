"""Upright boxes seen from above: rectangles on the ground that may be turned."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from contracts import FloatArray


@dataclass(frozen=True)
class Box:
    """A footprint: centre in world metres, heading in radians from east, length along the heading, width across."""

    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    width_m: float

    @property
    def corners_m(self) -> FloatArray:
        """(4, 2) corners, counter-clockwise from the front right one."""
        c, s = cos(self.heading_rad), sin(self.heading_rad)
        ahead, left = self.length_m / 2.0, self.width_m / 2.0
        local = np.array([(ahead, -left), (ahead, left), (-ahead, left), (-ahead, -left)])
        corners: FloatArray = local @ np.array([[c, s], [-s, c]]) + (self.x_m, self.y_m)
        return corners


def separation_m(a: Box, b: Box) -> float:
    """Widest gap between ``a`` and ``b`` along any of their four axes; negative: depth of their overlap.

    Positive exactly if the boxes are apart (separating axis theorem; Gottschalk, Lin & Manocha 1996), and never more
    than the distance between them.
    """
    return max(_gap_along_axes_of(a, b), _gap_along_axes_of(b, a))


def _gap_along_axes_of(own: Box, other: Box) -> float:
    """Widest gap along the two axes of ``own``."""
    dx, dy = other.x_m - own.x_m, other.y_m - own.y_m
    c, s = cos(own.heading_rad), sin(own.heading_rad)
    turn = other.heading_rad - own.heading_rad
    c_turn, s_turn = abs(cos(turn)), abs(sin(turn))
    along = abs(dx * c + dy * s) - (own.length_m + other.length_m * c_turn + other.width_m * s_turn) / 2.0
    across = abs(dy * c - dx * s) - (own.width_m + other.length_m * s_turn + other.width_m * c_turn) / 2.0
    return max(along, across)
