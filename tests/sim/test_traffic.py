"""Laws of the road's truth: nothing jumps, bodies go where they face, contacts are exact, the same seed is the same."""

from itertools import pairwise

import libsumo
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from road_cases import NAMES, network, path_of

from contracts import EventKind, InputError
from georef.lanes import LaneIndex
from sim.boxes import Box, separation_m
from sim.road_map import map_of_network
from sim.road_users import KINDS
from sim.smooth_motion import CRASH_MPS2, Node, Stretch
from sim.sumo_run import SumoRun
from sim.traffic import TrafficMotion
from sim.traffic_check import TrafficFaultError
from sim.traffic_spec import DriverSpec, RoadEvent, TrafficSpec, WalkerSpec
from sim.user_sizes import Sizes

PERIOD_NS = 40_000_000
PERIOD_S = PERIOD_NS * 1e-9
MOST_MPS2 = 12.0  # an emergency stop of 9 m/s2 in a bend
SMALL_M = 1.0  # shorter bodies, people, may turn on the spot
CLEAN = TrafficSpec(density=0.6)


def run(name, spec=CLEAN, seed=1, seconds=4.0, period_ns=PERIOD_NS):
    routes = path_of(name).with_name(f"{name}.rou.xml")
    times = [k * period_ns for k in range(round(seconds * 1e9 / period_ns))]
    return list(TrafficMotion(network(name), routes, spec, seed).run(times))


def contacts(truths):
    return [event for truth in truths for event in truth.events if event.kind is EventKind.CONTACT]


def moves(truths):
    """Rows (before, after) of everybody who is there in two frames running."""
    for a, b in pairwise(truths):
        for row, id_ in enumerate(b.ids):
            if id_ in a.ids:
                yield a, a.ids.index(id_), b, row


def boxes_of(truth):
    return {
        id_: Box(*truth.positions_m[k, :2], truth.headings_rad[k], *truth.sizes_m[k, :2])
        for k, id_ in enumerate(truth.ids)
    }


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=2, deadline=None)
@given(seed=st.integers(0, 2**31 - 1))
def test_nothing_jumps_and_everybody_goes_where_they_face(name, seed):
    truths = run(name, seed=seed)
    most = CRASH_MPS2 if contacts(truths) else MOST_MPS2
    for a, i, b, k in moves(truths):
        assert np.linalg.norm(b.velocities_mps[k] - a.velocities_mps[i]) <= most * PERIOD_S + 1e-9
        way = b.positions_m[k, :2] - a.positions_m[i, :2]
        mean = (a.velocities_mps[i] + b.velocities_mps[k]) / 2
        assert np.linalg.norm(way - mean * PERIOD_S) <= most * PERIOD_S**2 / 4 + 1e-9
        turn = np.angle(np.exp(1j * (b.headings_rad[k] - a.headings_rad[i])))
        rear_axle = KINDS[b.kinds[k]].rear_axle
        axle_m = rear_axle * b.sizes_m[k, 0]
        speed = max(np.linalg.norm(a.velocities_mps[i]), np.linalg.norm(b.velocities_mps[k])) + 0.5
        assert abs(turn) <= 1.05 * PERIOD_S * speed / axle_m
        if b.sizes_m[k, 0] > SMALL_M:
            assert abs(turn) <= 1.6 * PERIOD_S  # rad/s
            # the rear axle cannot slip: its velocity points where the body faces
            heading = (b.headings_rad[k] + a.headings_rad[i]) / 2 if abs(turn) < 1 else b.headings_rad[k]
            back = (rear_axle - 0.5) * b.sizes_m[k, 0]
            axles = [
                t.positions_m[n, :2] - back * np.array([np.cos(t.headings_rad[n]), np.sin(t.headings_rad[n])])
                for t, n in ((a, i), (b, k))
            ]
            dx, dy = axles[1] - axles[0]
            assert abs(dy * np.cos(heading) - dx * np.sin(heading)) < 2e-3


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_is_the_same_truth_and_another_is_another(name):
    first, again, other = run(name, seed=5, seconds=2), run(name, seed=5, seconds=2), run(name, seed=6, seconds=2)
    for a, b in zip(first, again, strict=True):
        assert a.ids == b.ids
        assert (a.positions_m == b.positions_m).all()
        assert (a.headings_rad == b.headings_rad).all()
    assert any(a.ids != b.ids or (a.positions_m != b.positions_m).any() for a, b in zip(first, other, strict=True))


def test_the_truth_of_a_moment_does_not_depend_on_which_moments_are_asked_for():
    often, seldom = run("merge", seed=3, seconds=2), run("merge", seed=3, seconds=2, period_ns=5 * PERIOD_NS)
    for a, b in zip(often[::5], seldom, strict=True):
        assert a.ids == b.ids
        assert (a.positions_m == b.positions_m).all()
        assert (a.velocities_mps == b.velocities_mps).all()


def test_bodies_keep_to_their_lanes_and_to_the_slope():
    index = LaneIndex.of(map_of_network(network("avenue_grade")))
    for truth in run("avenue_grade", seed=2)[::10]:
        for k, label in enumerate(truth.labels):
            if label in ("car", "van"):
                place = index.locate(truth.positions_m[k : k + 1, :2])
                assert place.distances_m[0] < 1.9  # half a lane and a bit: it may be changing lanes
                assert abs(np.angle(np.exp(1j * (place.headings_rad[0] - truth.headings_rad[k])))) < 0.2
                lane = index.centrelines[place.lanes[0]].points_m
                reached = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(lane[:, :2], axis=0).T))])
                assert abs(np.interp(place.along_m[0], reached, lane[:, 2]) - truth.positions_m[k, 2]) < 0.03


@pytest.mark.parametrize("name", NAMES)
def test_nobody_touches_anybody_whom_no_author_sent(name):
    assert contacts(run(name, TrafficSpec(), seed=1, seconds=20.0, period_ns=5 * PERIOD_NS)) == []


def test_a_bus_keeps_its_front_axle_on_the_lane_where_it_turns():
    bus = DriverSpec("bus", "city_bus", ("south_in", "west_out"), -10.0, speed_mps=10.0)
    lanes = LaneIndex.of(map_of_network(network("crossroads")))
    front_axle = KINDS["city_bus"].front_axle
    off_m = []
    for truth in run("crossroads", TrafficSpec((bus,), density=0.0), seconds=20.0, period_ns=5 * PERIOD_NS):
        for place, heading, size in zip(truth.positions_m[:, :2], truth.headings_rad, truth.sizes_m, strict=True):
            ahead_m = (0.5 - front_axle) * size[0]
            axle = place + ahead_m * np.array([np.cos(heading), np.sin(heading)])
            off_m.append(lanes.locate(axle[None]).distances_m[0])
    assert len(off_m) > 50
    assert max(off_m) < 0.25


DRIVER = DriverSpec("car", "saloon", ("eastward",), -4.0, lane=1, offset_m=10.0, speed_mps=13.0)
WALKER = WalkerSpec("walker", "adult", ((-28.0, -39.0, 0.0), (-28.0, -21.0, 0.0)), start_s=0.5)
ALONE = TrafficSpec((DRIVER,), (WALKER,), density=0.0)


@settings(max_examples=8, deadline=None)
@given(start_s=st.floats(-1.0, 4.0))
def test_a_contact_is_told_when_the_boxes_touch_and_only_then(start_s):
    spec = TrafficSpec((DRIVER,), (WalkerSpec("walker", "adult", WALKER.path_m, start_s),), density=0.0)
    truths = run("avenue", spec, seconds=5, period_ns=10_000_000)
    told = contacts(truths)
    gaps = [separation_m(boxes_of(t)["car"], boxes_of(t)["walker"]) for t in truths if len(t.ids) == 2]
    if not told:
        assert min(gaps) > 0
        return
    (event,) = told
    assert event.subjects == ("car", "walker")
    times = np.array([t.time_ns for t in truths])
    (at_contact,) = TrafficMotion(network("avenue"), None, spec, 1).run([event.time_ns])
    assert abs(separation_m(boxes_of(at_contact)["car"], boxes_of(at_contact)["walker"])) < 1e-3
    assert all(gap > 0 for gap, time in zip(gaps, times, strict=False) if time < event.time_ns)
    late = truths[-1]
    if late.time_ns > event.time_ns + 5e8:
        assert np.linalg.norm(late.velocities_mps) < 1e-9


def test_a_driver_told_to_brake_stands_until_told_to_go():
    events = (RoadEvent(1.0, "car", "brake", 7.0), RoadEvent(6.0, "car", "go"))
    truths = run("avenue", TrafficSpec((DRIVER,), (), events, 0.0), seconds=8)
    speeds = np.array([np.linalg.norm(truth.velocities_mps[0]) for truth in truths])
    times = np.array([truth.time_ns * 1e-9 for truth in truths])
    assert speeds[times < 0.3].min() > 15
    assert speeds[(times > 4.5) & (times < 5.3)].max() < 1e-9
    assert speeds[-1] > 1
    assert np.diff(speeds).min() / PERIOD_S > -7.5


def test_who_stops_at_a_wreck_does_not_run_into_it():
    first, second = (
        DriverSpec(id_, "saloon", ("eastward",), depart, lane=1, offset_m=offset, speed_mps=13.0)
        for id_, depart, offset in (("car", -4.0, 10.0), ("next", -1.0, 0.0))
    )
    still = WalkerSpec("walker", "adult", ((-28.0, -34.9, 0.0), (-28.0, -34.8, 0.0)))
    truths = run("avenue", TrafficSpec((first, second), (still,), density=0.0), seconds=12)
    assert [event.subjects for event in contacts(truths)] == [("car", "walker")]


def test_walkers_go_their_way_at_their_speed():
    truths = run("avenue", ALONE, seconds=6)
    row = truths[-1].ids.index("walker")
    speeds = [np.linalg.norm(t.velocities_mps[t.ids.index("walker")]) for t in truths]
    assert abs(max(speeds) - WALKER.speed_mps) < 1e-3
    assert truths[-1].labels[row] == "pedestrian"
    assert tuple(truths[-1].sizes_m[row]) == Sizes(1).of("adult", "walker")


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(-3, 3), min_size=6, max_size=6), st.floats(-3, 3), st.floats(0.3, 11), st.floats(0.01, 0.99))
def test_the_velocity_is_the_derivative_of_the_position(numbers, heading, length_m, share):
    x, y, vx, vy, wx, wy = numbers
    begin, end = Node(0, 0, 0, 0, vx, vy), Node(0.1 * x, 0.1 * y, 0, 0, wx, wy)
    stretch = Stretch.following(
        begin, end, heading, step_s=0.05, length_m=length_m, guide_m=0.2 * length_m, wheelbase_m=0.6 * length_m
    )
    before, here, after = (stretch.pose(0.05 * share + d) for d in (-1e-6, 0.0, 1e-6))
    for axis in ("x", "y"):
        slope = (getattr(after, f"{axis}_m") - getattr(before, f"{axis}_m")) / 2e-6
        assert abs(slope - getattr(here, f"v{axis}_mps")) < 1e-4
    for p in (before, here, after):
        corner = np.hypot(p.vx_mps, p.vy_mps) + abs(p.yaw_radps) * length_m / 2
        assert corner <= stretch.fastest_mps + 1e-9


def test_two_runs_at_once_are_refused_and_the_next_one_is_not():
    with (
        SumoRun(network("merge"), None, TrafficSpec(), 1),
        pytest.raises(InputError, match="only once"),
        SumoRun(network("merge"), None, TrafficSpec(), 1),
    ):
        pass
    assert not libsumo.isLoaded()
    assert len(run("merge", seconds=0.2)) == 5


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        (TrafficSpec((DriverSpec("a", "suv", ("northward",)),)), "northward"),
        (TrafficSpec((DriverSpec("a", "suv", ("eastward", "westward")),)), "no lane leads"),
        (TrafficSpec((DriverSpec("a", "suv", ("eastward",), lane=7),)), "lane 7"),
        (TrafficSpec((DRIVER,), (), (RoadEvent(1.0, "b", "brake"),)), "'b' is unknown"),
    ],
)
def test_traffic_that_the_network_cannot_serve_is_refused(spec, says):
    with pytest.raises(TrafficFaultError, match=says):
        TrafficMotion(network("avenue"), None, spec, 1)


@pytest.mark.parametrize(
    "make",
    [
        lambda: DriverSpec("a", "adult", ("x",)),
        lambda: DriverSpec("", "suv", ("x",)),
        lambda: DriverSpec("a", "suv", ()),
        lambda: DriverSpec("a", "suv", ("x",), -31.0),
        lambda: DriverSpec("a", "suv", ("x",), speed_mps=-1.0),
        lambda: DriverSpec("a", "suv", ("x",), lane=-1),
        lambda: DriverSpec("a", "suv", ("x",), top_speed_mps=0.0),
        lambda: WalkerSpec("a", "suv", WALKER.path_m),
        lambda: WalkerSpec("a", "adult", WALKER.path_m[:1]),
        lambda: WalkerSpec("a", "adult", WALKER.path_m, speed_mps=0.0),
        lambda: RoadEvent(-1.0, "a", "brake"),
        lambda: RoadEvent(1.0, "a", "brake", 20.0),
        lambda: TrafficSpec((DRIVER, DRIVER)),
        lambda: TrafficSpec(density=-1.0),
    ],
)
def test_impossible_specifications_are_refused(make):
    with pytest.raises(InputError):
        make()


def test_times_must_rise():
    with pytest.raises(InputError, match="rise"):
        TrafficMotion(network("merge"), None, TrafficSpec(), 1).run([0, 0])
    assert not libsumo.isLoaded()
