from math import cos, pi, sin

import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from scenarios.strategies import boxes, headings
from sim.boxes import Box, separation_m

metres = st.floats(-2.0, 2.0)


def polygon(box: Box) -> shapely.Polygon:
    return shapely.Polygon(box.corners_m)


def moved(box: Box, turn_rad: float, east_m: float, north_m: float) -> Box:
    c, s = cos(turn_rad), sin(turn_rad)
    x, y = c * box.x_m - s * box.y_m + east_m, s * box.x_m + c * box.y_m + north_m
    return Box(x, y, box.heading_rad + turn_rad, box.length_m, box.width_m)


@given(boxes(), boxes())
def test_boxes_are_apart_exactly_where_shapely_says_so(a, b):
    separation, distance = separation_m(a, b), polygon(a).distance(polygon(b))
    if abs(separation) > 1e-9:  # nearer than that, shapely's own rounding decides
        assert (separation > 0) == (distance > 0)


@given(boxes(), boxes())
def test_the_separation_never_exceeds_the_distance(a, b):
    assert separation_m(a, b) <= polygon(a).distance(polygon(b)) + 1e-12


@given(boxes(), boxes(), headings(), metres, metres)
def test_the_separation_does_not_depend_on_order_or_on_where_the_world_begins(a, b, turn, east, north):
    separation = separation_m(a, b)
    assert abs(separation_m(b, a) - separation) < 1e-12
    assert abs(separation_m(moved(a, turn, east, north), moved(b, turn, east, north)) - separation) < 1e-9


@given(boxes())
def test_the_corners_enclose_the_area_and_the_centre(box):
    assert abs(polygon(box).area - box.length_m * box.width_m) < 1e-12
    assert np.abs(box.corners_m.mean(axis=0) - (box.x_m, box.y_m)).max() < 1e-12
    assert polygon(box).exterior.is_ccw


def test_the_separation_of_parallel_boxes_is_the_air_between_them_or_the_depth_of_their_overlap():
    a = Box(0.0, 0.0, 0.0, 0.12, 0.06)
    assert abs(separation_m(a, Box(0.15, 0.01, pi, 0.12, 0.06)) - 0.03) < 1e-12
    assert abs(separation_m(a, Box(0.0, 0.05, 0.0, 0.12, 0.06)) + 0.01) < 1e-12
