"""Which places along the map's paint are looked at."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from perception.paint_map import looks_along, paint_of
from tests.perception.drawn_road import CROSSROADS, nominal_camera

PAINT = paint_of(CROSSROADS)
STROKES = [line for line in PAINT.lines if line.width_m > 0]


def looked_at(line, every_px=4.0):
    return looks_along(nominal_camera(), line, every_px=every_px, farthest_m=70.0)


def test_no_place_of_a_stroke_lies_where_it_is_cut_or_meets_another():
    seen = 0
    for line in STROKES:
        places = looked_at(line).places_m
        seen += len(places)
        for end in line.points_m[[0, -1]]:
            assert (np.linalg.norm(places - end, axis=1) > 0.25).all()
        for meeting in line.meets_m:
            assert (np.linalg.norm(places[:, :2] - meeting, axis=1) > 0.5).all()
    assert seen > 100


def test_stop_lines_know_the_lines_that_run_into_them():
    stops = [line for line in PAINT.lines if line.name.startswith("stop/")]
    assert stops
    assert all(len(stop.meets_m) > 0 for stop in stops)


def test_the_dashes_of_a_marking_do_not_meet_each_other():
    by_marking = {}
    for line in STROKES:
        if "/dash " in line.name:
            by_marking.setdefault(line.name.split("/dash ")[0], []).append(line)
    for dashes in by_marking.values():
        inner = dashes[2:-2]
        assert all(len(dash.meets_m) == 0 for dash in inner)


@settings(max_examples=20)
@given(st.integers(0, len(STROKES) - 1), st.floats(3.0, 30.0))
def test_places_are_as_far_apart_as_asked(number, every_px):
    pixels = looked_at(STROKES[number], every_px).pixels
    assert (np.linalg.norm(np.diff(pixels, axis=0), axis=1) >= every_px - 1e-9).all()
