"""Every scenario of the library is a test of its own, at the level of truth: nothing is filmed."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from contracts import EventKind
from contracts.truth import Truth
from scenarios.loader import build_world, list_scenarios, load_scenario
from scenarios.rig_file import load_rig
from scenarios.schema import RailScenario, Scenario
from sim.colours import Colour
from sim.lights import RAIL_LIGHTS

JUMP_M = 1e-3  # more than rounding, less than any way that speed and limits do not explain


@cache
def truths_of(name: str) -> tuple[Scenario, tuple[Truth, ...]]:
    scenario = load_scenario(name)
    return scenario, tuple(step.truth for step in build_world(scenario, film=False).steps())


def subjects(truths: Sequence[Truth], kind: EventKind) -> set[tuple[str, ...]]:
    return {event.subjects for truth in truths for event in truth.events if event.kind is kind}


@pytest.mark.parametrize("name", list_scenarios())
def test_what_the_scenario_expects_happens_and_nothing_else(name):
    scenario, truths = truths_of(name)
    assert len(truths) == scenario.frame_count
    assert subjects(truths, EventKind.CONTACT) == {tuple(sorted(pair)) for pair in scenario.expect.contact}
    assert subjects(truths, EventKind.DERAIL) == {(id_,) for id_ in scenario.expect.derail}


RAIL = [name for name in list_scenarios() if isinstance(load_scenario(name), RailScenario)]


@pytest.mark.parametrize("name", RAIL)
def test_nothing_jumps_in_the_scenario(name):
    scenario, truths = truths_of(name)
    frame_s = 1.0 / scenario.fps
    limits = np.array([max(v.acceleration_mps2, v.braking_mps2) for v in scenario.vehicle])
    for before, after in pairwise(truths):
        ways = np.linalg.norm(after.positions_m - before.positions_m, axis=1)
        fastest = np.maximum(np.hypot(*before.velocities_mps.T), np.hypot(*after.velocities_mps.T)) + limits * frame_s
        assert (ways <= fastest * frame_s + JUMP_M).all()
        turns = np.abs(np.angle(np.exp(1j * (after.headings_rad - before.headings_rad))))
        assert (turns <= (ways + JUMP_M) / 0.4).all()  # no plant has a curve much tighter than that


@pytest.mark.parametrize("name", [name for name in list_scenarios() if name.startswith("train-")])
def test_a_training_scenario_shows_every_colour_of_the_palette(name):
    scenario, _ = truths_of(name)
    assert {vehicle.colour for vehicle in scenario.vehicle} == set(Colour)


def test_the_training_scenarios_share_no_seed_with_the_others():
    seeds = {name: load_scenario(name).seed for name in list_scenarios()}
    training = {seed for name, seed in seeds.items() if name.startswith("train-")}
    assert training
    assert not training & {seed for name, seed in seeds.items() if not name.startswith("train-")}


def test_every_light_occurs_in_both_splits_of_the_sequences():
    sequences = [load_scenario(name) for name in list_scenarios() if name.startswith("sequence-")]
    assert len(sequences) == 20
    for split, count in (("train", 8), ("test", 12)):
        mine = [scenario for scenario in sequences if scenario.split == split]
        lights = {scenario.light for scenario in mine} | {c.to for scenario in mine for c in scenario.light_change}
        assert len(mine) == count
        assert lights == set(RAIL_LIGHTS)
        assert all(scenario.frame_count >= 250 for scenario in mine)
        assert all(load_rig(s.rig).cameras[0].resolution_px == (1280, 720) for s in mine)


def test_the_main_job_takes_both_vehicles_through_both_loops_and_both_halves():
    _, truths = truths_of("oval-two-vehicles")
    sections = {place.section for truth in truths for place in truth.places}
    assert {"loop_a", "loop_b"} <= sections
    for row in range(2):
        x = np.array([truth.positions_m[row, 0] for truth in truths])
        assert x.min() < -0.5
        assert x.max() > 0.5
