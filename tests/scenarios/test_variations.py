from dataclasses import replace

import pytest
from hypothesis import given, settings

from contracts import InputError
from scenarios.loader import build_world, load_scenario
from scenarios.schema import Range
from scenarios.strategies import scenarios
from scenarios.variations import variants, varied
from sim.lights import LightPreset

BASE = load_scenario("head-on-passing-loop")
LOOSE = replace(
    BASE,
    vary={
        "vehicle.blue.speed_mps": Range(min=0.2, max=0.4),
        "vehicle.1.start.offset_m": Range(min=0.5, max=0.7),
        "light": Range(any=("sunny", "cloudy")),
        "event.0.at_s": Range(min=0.5, max=1.5),
        "fps": Range(min=10, max=20),
    },
)


def test_variants_stay_within_their_ranges_and_differ():
    drawn = list(variants(LOOSE, 30))
    assert {one.light for one in drawn} == {LightPreset.SUNNY, LightPreset.CLOUDY}
    for one in drawn:
        assert 0.2 <= one.vehicle[0].speed_mps <= 0.4
        assert 0.5 <= one.vehicle[1].start.offset_m <= 0.7
        assert 0.5 <= one.event[0].at_s <= 1.5
        assert one.vehicle[1].speed_mps == BASE.vehicle[1].speed_mps
    assert len({one.seed for one in drawn}) == len({one.vehicle[0].speed_mps for one in drawn}) == 30
    assert [one.name for one in drawn[:2]] == ["head-on-passing-loop-0", "head-on-passing-loop-1"]


def test_variants_are_the_same_each_time_however_many_are_asked_for():
    assert list(variants(LOOSE, 3)) == list(variants(LOOSE, 7))[:3]


def test_another_seed_draws_other_variants():
    (one,), (other,) = variants(LOOSE, 1), variants(replace(LOOSE, seed=8), 1)
    assert one.vehicle[0].speed_mps != other.vehicle[0].speed_mps


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("lights", "sunny", ["'lights'", "light"]),
        ("vehicle.green.speed_mps", 1.0, ["'green'", "blue, red"]),
        ("vehicle.blue.speed", 1.0, ["'speed'", "speed_mps"]),
        ("light", "dark", ["light", "dark"]),
        ("vehicle.blue.speed_mps", "fast", ["vehicle.blue.speed_mps", "fast"]),
        ("duration_s", -1.0, ["duration_s cannot be -1.0", "> 0.0"]),
    ],
)
def test_a_key_or_value_that_cannot_be_is_refused(key, value, words):
    with pytest.raises(InputError) as refusal:
        varied(BASE, {key: value})
    for word in words:
        assert word in str(refusal.value)


@settings(max_examples=10)
@given(scenarios(duration_s=0.5))
def test_every_scenario_that_hypothesis_draws_runs(scenario):
    world = build_world(scenario, film=False)
    truths = [step.truth for step in world.steps()]
    assert len(truths) == scenario.frame_count
    assert all(truth.ids == tuple(vehicle.id for vehicle in scenario.vehicle) for truth in truths)
