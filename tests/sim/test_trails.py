import numpy as np
import shapely
from hypothesis import given
from hypothesis import strategies as st

from sim.trails import Trail

places = st.lists(st.tuples(st.floats(-20, 20), st.floats(-20, 20)), min_size=1, max_size=12)


@given(places, st.floats(-3.0, 3.0), st.floats(0.05, 30.0))
def test_the_end_lies_the_reach_behind_along_the_way(way, heading, reach_m):
    """Shapely's distance along a line is the authority; before the first place the way was straight."""
    trail = Trail((*way[0], 0.0, 0.0), heading, reach_m)
    begin = np.array(way[0]) - reach_m * np.array([np.cos(heading), np.sin(heading)])
    walked = [tuple(begin), way[0]]
    for place in way[1:]:
        trail.take((*place, 0.0, 0.0))
        trail.end()  # asking forgets only what is out of reach
        walked.append(place)
    line = shapely.LineString(walked)
    expected = line.interpolate(max(line.length - reach_m, 0.0))  # below 0 it counts from the end
    assert np.hypot(trail.end()[0] - expected.x, trail.end()[1] - expected.y) < 1e-6


def test_on_a_slope_the_end_is_lower_by_slope_times_reach():
    trail = Trail((0.0, 0.0, 5.0, 0.1), 0.0, 2.0)
    assert np.allclose(trail.end(), (-2.0, 0.0, 4.8, 0.1), rtol=0, atol=1e-12)
    trail.take((1.0, 0.0, 5.1, 0.1))
    assert np.allclose(trail.end(), (-1.0, 0.0, 4.9, 0.1), rtol=0, atol=1e-12)


def test_who_stands_keeps_the_place():
    trail = Trail((0.0, 0.0, 0.0, 0.0), 1.0, 2.0)
    before = trail.end()
    for _ in range(5):
        trail.take((0.0, 0.0, 0.0, 0.0))
    assert trail.end() == before
