"""What holds for every motion on every plant."""

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from motion_cases import FORK, footprints, happened, speeds, times

from contracts import EventKind
from rail.plant import Plant
from scenarios.plant_file import load_plant
from scenarios.strategies import motions
from sim.boxes import separation_m
from sim.motion_spec import Manner, MotionSpec
from sim.rail_motion import RailMotion

OVAL = load_plant("oval")
UNTIL_S = 1.5
STOPPERS = (EventKind.CONTACT, EventKind.DERAIL)

few = settings(max_examples=8)


def centre_lines(plant: Plant) -> shapely.MultiLineString:
    return shapely.MultiLineString([section.curve.points(5e-4) for section in plant.sections.values()])


LINES = centre_lines(OVAL)


def truths_of(spec: MotionSpec, step_s: float = 0.02):
    return list(RailMotion(OVAL, spec, seed=3).run(times(UNTIL_S, step_s)))


@few
@given(motions(OVAL, max_vehicles=3, duration_s=UNTIL_S))
def test_both_axles_stay_on_the_centre_line(spec):
    for truth in truths_of(spec, 0.05):
        ahead = np.stack([np.cos(truth.headings_rad), np.sin(truth.headings_rad)], axis=-1)  # (N, 2)
        for side in (-0.5, 0.5):
            axles = truth.positions_m[:, :2] + side * 0.07 * ahead
            assert shapely.distance(LINES, shapely.points(axles)).max(initial=0.0) < 1e-6


@few
@given(motions(OVAL, max_vehicles=3, duration_s=UNTIL_S), st.lists(st.integers(0, 1_500_000_000), unique=True))
def test_the_truth_at_a_moment_does_not_depend_on_the_moments_asked_for(spec, extra):
    sparse = sorted(extra)
    dense = sorted({*extra, *times(UNTIL_S, 0.1)})
    motion = RailMotion(OVAL, spec, seed=3)
    at = {truth.time_ns: truth for truth in motion.run(dense)}
    heard = []
    for truth in motion.run(sparse):
        heard += truth.events
        twin = at[truth.time_ns]
        assert (truth.positions_m == twin.positions_m).all()
        assert (truth.headings_rad == twin.headings_rad).all()
        assert (truth.velocities_mps == twin.velocities_mps).all()
        assert (truth.places, truth.switches) == (twin.places, twin.switches)
    last_ns = sparse[-1] if sparse else -1
    assert heard == [event for event in happened(list(at.values())) if event.time_ns <= last_ns]


def reckless(spec: MotionSpec) -> MotionSpec:
    return replace(spec, vehicles=tuple(replace(v, manner=Manner.BLIND) for v in spec.vehicles))


@settings(max_examples=20)
@given(motions(FORK, min_vehicles=3, max_vehicles=6, duration_s=UNTIL_S).map(reckless))  # they meet often
def test_bodies_never_overlap_and_touch_only_where_an_event_says_so(spec):
    truths = list(RailMotion(FORK, spec, seed=3).run(times(UNTIL_S, 0.01)))
    told: set[tuple[str, ...]] = set()
    for truth in truths:
        told |= {event.subjects for event in truth.events if event.kind is EventKind.CONTACT}
        boxes = footprints(truth)
        for a, b in combinations(range(len(boxes)), 2):
            gap_m = separation_m(boxes[a], boxes[b])
            assert gap_m > -1e-6
            assert gap_m > 2e-6 or tuple(sorted((truth.ids[a], truth.ids[b]))) in told


@few
@given(motions(OVAL, max_vehicles=3, duration_s=UNTIL_S))
def test_speed_changes_within_the_limits_of_motor_and_brakes_except_by_an_impact(spec):
    step_s = 0.02
    truths = truths_of(spec, step_s)
    limits = np.array([max(v.acceleration_mps2, v.braking_mps2) for v in spec.vehicles])
    along = speeds(truths) * np.array([[_sense(truth, k) for k in range(len(truth.ids))] for truth in truths])
    change = np.abs(np.diff(along, axis=0))  # (T - 1, N)
    for row, truth in enumerate(truths[1:]):
        hit = {id_ for event in truth.events if event.kind in STOPPERS for id_ in event.subjects}
        free = np.array([id_ not in hit for id_ in truth.ids], dtype=bool)
        assert (change[row][free] <= limits[free] * step_s + _chord_effect(truths[row])).all()


def _sense(truth, row: int) -> float:
    """+1 where the vehicle runs the way it faces, else -1."""
    ahead = np.cos(truth.headings_rad[row]), np.sin(truth.headings_rad[row])
    return 1.0 if truth.velocities_mps[row] @ ahead >= 0 else -1.0


def _chord_effect(truth) -> float:
    """On curves the body's centre is slower than its axles: where curvature jumps, by w^2 / (8 R^2) of its speed."""
    return 0.07**2 / (8 * 0.4**2) * float(np.hypot(*truth.velocities_mps.T).max(initial=0.0)) + 1e-9


@few
@given(motions(OVAL, max_vehicles=3, duration_s=UNTIL_S))
def test_the_velocity_is_the_derivative_of_the_position(spec):
    h_ns = 1_000
    middles = [t + 2_500_000 for t in times(UNTIL_S, 0.1)]  # in the middle of internal steps
    asked = sorted({t + d for t in middles for d in (-h_ns, 0, h_ns)})
    at = {truth.time_ns: truth for truth in RailMotion(OVAL, spec, seed=3).run(asked)}
    for t in middles:
        before, now, after = at[t - h_ns], at[t], at[t + h_ns]
        numeric = (after.positions_m - before.positions_m)[:, :2] / (2 * h_ns * 1e-9)
        if not any(event.kind in STOPPERS for event in (*now.events, *after.events)):
            assert np.abs(numeric - now.velocities_mps).max(initial=0.0) < 1e-5


@pytest.mark.parametrize("name", ["line30", "atlas100"])
def test_vehicles_run_on_the_other_plants_too(name):
    plant = load_plant(name)
    lines = centre_lines(plant)

    @settings(max_examples=4)
    @given(motions(plant, max_vehicles=3, duration_s=1.0))
    def law(spec: MotionSpec) -> None:
        for truth in RailMotion(plant, spec, seed=3).run(times(1.0, 0.1)):
            ahead = np.stack([np.cos(truth.headings_rad), np.sin(truth.headings_rad)], axis=-1)
            axles = np.concatenate([truth.positions_m[:, :2] + side * 0.07 * ahead for side in (-0.5, 0.5)])
            assert shapely.distance(lines, shapely.points(axles)).max(initial=0.0) < 1e-6

    run_law: Callable[[], None] = law
    run_law()
