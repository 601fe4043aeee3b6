from math import hypot

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from plant_specs import built, fork

from contracts import InputError, SwitchState
from rail.curves import wrapped
from rail.graph import (
    BlockedBy,
    Location,
    advance,
    next_switch_ahead,
    pose_at,
)
from rail.plant import Balise, Plant, Switch
from rail.routes import distance, distance_ahead, sections_reachable
from scenarios.plant_file import load_plant, plant_names

PLANTS = {name: load_plant(name) for name in plant_names()}
FORK = built(fork())
STRAIGHT, DIVERGING, MOVING = SwitchState.STRAIGHT, SwitchState.DIVERGING, SwitchState.MOVING
runs = st.floats(-20.0, 20.0)
plants = st.sampled_from(list(PLANTS.values()))


@st.composite
def journeys(draw):
    plant: Plant = draw(plants)
    section = plant.sections[draw(st.sampled_from(list(plant.sections)))]
    location = Location(section.id, draw(st.floats(0.0, section.length_m)), draw(st.sampled_from([1, -1])))
    states = {id_: draw(st.sampled_from([STRAIGHT, DIVERGING])) for id_ in plant.switches}
    return plant, location, states


def apart_m(plant: Plant, a: Location, b: Location) -> float:
    p, q = pose_at(plant, a), pose_at(plant, b)
    return hypot(p.x_m - q.x_m, p.y_m - q.y_m) + abs(wrapped(p.heading_rad - q.heading_rad))


def subjects(*advances):
    return [passage.subject for one in advances for passage in one.passages]


@given(journeys(), st.floats(0.0, 20.0), st.floats(0.0, 20.0), st.booleans())
def test_two_advances_make_one(journey, a_m, b_m, backwards):
    plant, start, states = journey
    sign = -1 if backwards else 1
    first = advance(plant, start, sign * a_m, states)
    assume(first.blocked is None)
    assume(all(a_m - passage.distance_m > 1e-9 for passage in first.passages))  # else rounding decides who passes it
    second = advance(plant, first.location, sign * b_m, states)
    whole = advance(plant, start, sign * (a_m + b_m), states)
    assert apart_m(plant, second.location, whole.location) < 1e-9
    if a_m + b_m - abs(whole.travelled_m) > 1e-9:  # else rounding decides whether the end was reached or hit
        assert whole.blocked == second.blocked
    assert abs(first.travelled_m + second.travelled_m - whole.travelled_m) < 1e-9
    if second.passages and abs(a_m + b_m - a_m - second.passages[-1].distance_m) > 1e-9:
        assert subjects(first, second) == subjects(whole)


@given(journeys(), runs)
def test_there_and_back_again(journey, run_m):
    plant, start, states = journey
    there = advance(plant, start, run_m, states)
    back = advance(plant, there.location, -there.travelled_m, states)
    assert abs(back.travelled_m + there.travelled_m) < 1e-9
    assert apart_m(plant, back.location, start) < 1e-9


@given(journeys(), runs)
def test_backwards_is_forwards_looking_back(journey, run_m):
    plant, start, states = journey
    a = advance(plant, start, run_m, states)
    b = advance(plant, start.reversed(), -run_m, states)
    assert a.location == b.location.reversed()
    assert a.passages == b.passages
    assert a.travelled_m == -b.travelled_m


@given(journeys(), runs)
def test_the_pose_moves_no_faster_than_the_way(journey, run_m):
    plant, start, states = journey
    end = advance(plant, start, run_m, states)
    a, b = pose_at(plant, start), pose_at(plant, end.location)
    assert hypot(a.x_m - b.x_m, a.y_m - b.y_m) <= abs(end.travelled_m) + 1e-9


@given(journeys(), st.floats(0.0, 5.0), st.floats(1e-9, 1e-6))
def test_the_pose_is_continuous_along_the_way(journey, run_m, step_m):
    plant, start, states = journey
    a = advance(plant, start, run_m, states)
    b = advance(plant, a.location, step_m, states)
    assert abs(apart_m(plant, a.location, b.location)) < 5 * step_m + 1e-9


@given(journeys(), runs)
def test_passages_come_in_order_and_within_the_way(journey, run_m):
    plant, start, states = journey
    end = advance(plant, start, run_m, states)
    distances = [passage.distance_m for passage in end.passages]
    assert distances == sorted(distances)
    assert all(0 <= d <= abs(end.travelled_m) + 1e-9 for d in distances)


@given(journeys(), st.floats(0.0, 20.0))
def test_the_next_switch_is_the_first_one_passed(journey, run_m):
    plant, start, states = journey
    end = advance(plant, start, run_m, states)
    passed = [p for p in end.passages if isinstance(p.subject, Switch)]
    ahead = next_switch_ahead(plant, start, within_m=1e3)
    if passed:
        assert ahead is not None
        assert ahead.switch == passed[0].subject
        assert abs(ahead.distance_m - passed[0].distance_m) < 1e-9
        assert next_switch_ahead(plant, start, within_m=ahead.distance_m - 1e-6) is None


@given(journeys(), st.floats(0.0, 20.0))
def test_the_distance_ahead_is_no_longer_than_the_way_driven(journey, run_m):
    plant, start, states = journey
    end = advance(plant, start, run_m, states)
    least = distance_ahead(plant, start, end.location, states)
    assert least is not None
    assert least <= end.travelled_m + 1e-9
    assert advance(plant, start, max(0.0, least - 1e-9), states).blocked is None
    anyhow = distance_ahead(plant, start, end.location)
    assert anyhow is not None
    assert anyhow <= least + 1e-9
    assert end.location.section in sections_reachable(plant, start, states)


@given(journeys(), journeys())
def test_distance_is_symmetric(one, other):
    plant, a, states = one
    section = plant.sections[sorted(plant.sections)[int(other[1].offset_m * 7) % len(plant.sections)]]
    b = Location(section.id, section.length_m / 3, 1)
    there, back = distance(plant, a, b, states), distance(plant, b, a, states)
    assert (there is None) == (back is None)
    if there is not None and back is not None:
        assert abs(there - back) < 1e-9


@pytest.mark.parametrize("plant", PLANTS.values(), ids=list(PLANTS))
def test_every_joint_is_closed_to_a_nanometre(plant):
    pairs = [(a, b) for a, b in plant.joints.items()]
    pairs += [(switch.stem, branch) for switch in plant.switches.values() for branch in switch.ports[1:]]
    for a, b in pairs:
        leaving = plant.sections[a.section].pose_out_of(a.end)
        entering = plant.sections[b.section].pose_out_of(b.end).reversed()
        assert hypot(leaving.x_m - entering.x_m, leaving.y_m - entering.y_m) < 1e-9, (a, b)
        assert abs(wrapped(leaving.heading_rad - entering.heading_rad)) < 1e-9, (a, b)


def test_balises_and_switches_are_reported_where_they_lie():
    end = advance(FORK, Location("stem", 0.2, 1), 1.5, {"S1": DIVERGING})
    assert end.location.section == "side"
    assert [(type(p.subject), pytest.approx(p.distance_m, abs=1e-12)) for p in end.passages] == [
        (Balise, 0.3),
        (Switch, 0.8),
        (Balise, 1.1),
    ]


def test_a_balise_at_the_end_of_the_way_is_passed_once():
    first = advance(FORK, Location("stem", 0.2, 1), 0.3, {})
    second = advance(FORK, first.location, 0.1, {})
    assert [b.code for b in subjects(first)] == [1]
    assert subjects(second) == []


@pytest.mark.parametrize(
    ("start", "run_m", "state", "blocked", "travelled_m"),
    [
        (Location("stem", 0.4, -1), 1.0, STRAIGHT, (BlockedBy.BUFFER, "W"), 0.4),
        (Location("stem", 0.4, 1), -1.0, STRAIGHT, (BlockedBy.BUFFER, "W"), -0.4),
        (Location("side", 0.3, -1), 1.0, STRAIGHT, (BlockedBy.SWITCH_AGAINST, "S1"), 0.3),
        (Location("main", 0.3, -1), 1.0, DIVERGING, (BlockedBy.SWITCH_AGAINST, "S1"), 0.3),
        (Location("main", 0.3, -1), 1.0, MOVING, (BlockedBy.SWITCH_MOVING, "S1"), 0.3),
        (Location("stem", 0.4, 1), 1.0, MOVING, (BlockedBy.SWITCH_MOVING, "S1"), 0.6),
    ],
)
def test_what_blocks_the_way_is_named(start, run_m, state, blocked, travelled_m):
    end = advance(FORK, start, run_m, {"S1": state})
    assert end.blocked is not None
    assert (end.blocked.kind, end.blocked.subject) == blocked
    assert end.travelled_m == pytest.approx(travelled_m, abs=1e-12)
    assert end.location.direction == start.direction


def test_reaching_a_closed_end_exactly_is_not_blocked():
    assert advance(FORK, Location("stem", 0.5, 1), 0.5, {"S1": MOVING}).blocked is None


def test_distances_obey_the_switches():
    stem, side = Location("stem", 0.5, 1), Location("side", 0.25, 1)
    assert distance(FORK, stem, side) == pytest.approx(0.75, abs=1e-12)
    assert distance(FORK, stem, side, {"S1": STRAIGHT}) is None
    assert distance_ahead(FORK, stem.reversed(), side) is None
    assert distance(FORK, side, Location("main", 0.25, 1)) is None  # no way without turning back
    assert sections_reachable(FORK, stem) == {"stem", "main", "side"}
    assert sections_reachable(FORK, stem, {"S1": DIVERGING}) == {"stem", "side"}


def test_a_switch_ahead_tells_whether_it_is_faced():
    facing = next_switch_ahead(FORK, Location("stem", 0.9, 1), within_m=0.15)
    trailing = next_switch_ahead(FORK, Location("side", 0.1, -1), within_m=0.15)
    assert facing is not None
    assert facing.facing
    assert trailing is not None
    assert not trailing.facing
    assert next_switch_ahead(FORK, Location("stem", 0.8, 1), within_m=0.15) is None
    assert next_switch_ahead(FORK, Location("stem", 0.8, -1), within_m=9.0) is None


@pytest.mark.parametrize(
    ("location", "run_m", "states", "says"),
    [
        (Location("nord", 0.1, 1), 1.0, {}, "'nord' is unknown"),
        (Location("stem", 1.1, 1), 1.0, {}, "off section 'stem'"),
        (Location("stem", float("nan"), 1), 1.0, {}, "off section 'stem'"),
        (Location("stem", 0.1, 0), 1.0, {}, "direction 0"),
        (Location("stem", 0.1, 1), float("inf"), {}, "inf m cannot be travelled"),
        (Location("stem", 0.1, 1), 1.0, {"S2": STRAIGHT}, "no state given for switch 'S1'"),
    ],
)
def test_impossible_advances_are_refused(location, run_m, states, says):
    with pytest.raises(InputError, match=says):
        advance(FORK, location, run_m, states)
