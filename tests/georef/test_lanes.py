import numpy as np
import pytest
from hd_map_cases import PANGYO, centrelines, full_map
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts import InputError
from georef.hd_map import HdMap, LaneCentreline, RoadClass
from georef.lanes import LaneIndex

positions = st.lists(st.tuples(st.floats(-200, 200), st.floats(-200, 200)), min_size=1, max_size=20)


def brute_force(lane: LaneCentreline, points) -> tuple[np.ndarray, np.ndarray]:
    """Nearest point of each side by hand: (N, 2) and its distance."""
    a, b = lane.points_m[:-1, :2], lane.points_m[1:, :2]
    d = b - a
    share = ((points[:, None] - a) * d).sum(-1) / (d**2).sum(-1)
    feet = a + np.clip(share, 0, 1)[..., None] * d
    distances = np.linalg.norm(points[:, None] - feet, axis=-1)
    best = distances.argmin(axis=1)
    rows = np.arange(len(points))
    return feet[rows, best], distances[rows, best]


@settings(max_examples=60, deadline=None)
@given(st.lists(centrelines(), min_size=1, max_size=5), positions)
def test_the_nearest_lane_and_foot_are_those_of_brute_force(lanes, points):
    points = np.array(points)
    places = LaneIndex(lanes).locate(points)
    by_hand = np.array([brute_force(lane, points)[1] for lane in lanes])
    np.testing.assert_allclose(places.distances_m, by_hand.min(axis=0), rtol=0, atol=1e-9)
    for k, lane in enumerate(places.lanes):
        assert np.linalg.norm(places.feet_m[k] - points[k]) - by_hand[:, k].min() < 1e-9
        assert abs(by_hand[lane, k] - by_hand[:, k].min()) < 1e-9


@settings(max_examples=60, deadline=None)
@given(centrelines(), st.floats(0.02, 0.98), st.floats(-0.9, 0.9))
def test_a_place_beside_a_lane_is_found_again(lane, share, across_m):
    a, b = lane.points_m[0, :2], lane.points_m[1, :2]
    heading = np.arctan2(*(b - a)[::-1])
    left = np.array([-np.sin(heading), np.cos(heading)])
    length = np.linalg.norm(b - a)
    along = 0.6 + share * (length - 1.2)  # so that the next side, turned by 60 degrees at most, is no nearer
    place = a + along * (b - a) / length + across_m * left
    found = LaneIndex([lane]).locate(place[None])
    assert abs(found.along_m[0] - along) < 1e-9 or abs(across_m) > 0.5
    if abs(found.along_m[0] - along) < 1e-9:
        assert abs(found.across_m[0] - across_m) < 1e-9
        assert abs(np.angle(np.exp(1j * (found.headings_rad[0] - heading)))) < 1e-9


def test_far_and_unknown_positions_are_not_valid():
    places = LaneIndex.of(full_map()).locate([(0, 2), (0, 900), (np.nan, 0)], within_m=5)
    assert places.valid.tolist() == [True, False, False]
    assert places.lanes.tolist() == [0, -1, -1]
    assert np.isnan(places.feet_m[1:]).all()
    np.testing.assert_allclose(places.across_m[0], 0.5, rtol=0, atol=1e-12)


def test_a_lane_may_be_named_instead_of_found():
    index = LaneIndex.of(full_map())
    places = index.places_on([1, -1], [(0, 2), (0, 2)])
    np.testing.assert_allclose(places.across_m[0], 3.5, rtol=0, atol=1e-12)
    assert not places.valid[1]


def test_repeated_points_of_a_lane_do_no_harm():
    lane = LaneCentreline("x", [(0, 0, 0), (5, 0, 0), (5, 0, 0), (5, 5, 0), (5, 5, 0)], RoadClass.CITY, 3.0)
    places = LaneIndex([lane]).locate([(6, 9), (5, 3), (2, 1)])
    np.testing.assert_allclose(places.along_m, (10, 8, 2), rtol=0, atol=1e-12)
    np.testing.assert_allclose(places.headings_rad, (np.pi / 2, np.pi / 2, 0), rtol=0, atol=1e-12)
    np.testing.assert_allclose(places.across_m, (-1, 0, 1), rtol=0, atol=1e-12)


def test_wrong_input_is_refused():
    index = LaneIndex.of(full_map())
    for ask in (
        lambda: LaneIndex.of(HdMap(PANGYO)),
        lambda: index.locate([(1, 2, 3)]),
        lambda: index.places_on([7], [(0, 0)]),
        lambda: index.places_on([0], [(0, 0), (1, 1)]),
    ):
        with pytest.raises(InputError):
            ask()


def test_no_positions_are_no_places():
    assert len(LaneIndex.of(full_map()).locate(np.empty((0, 2))).lanes) == 0
