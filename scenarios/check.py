"""Whether a scenario fits its plant, rig and light and speaks of vehicles that it has; each fault with its key."""

from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np

from contracts import InputError
from rail.plant import Plant
from scenarios.network_file import load_network
from scenarios.plant_file import load_plant
from scenarios.rig_file import load_rig
from scenarios.schema import RailScenario, RoadScenario, Scenario
from scenarios.variations import varied
from sim.light_program import order_faults
from sim.lights import RAIL_LIGHTS, ROAD_LIGHTS, LightPreset
from sim.motion_check import KeyPath, MotionFaultError, check_motion
from sim.surroundings import blocks_track
from sim.traffic_check import TrafficFaultError, check_traffic

Fault = tuple[KeyPath, str]

_TRACK_STEP_M = 0.01
_SWAY_M = 0.012  # a vehicle sticks out this much farther in a curve
_HEADROOM_M = 0.005


def faults(scenario: Scenario) -> Iterator[Fault]:
    """All that is wrong with ``scenario``: key and what, in the order of the file's keys."""
    if isinstance(scenario, RailScenario):
        yield from _rail_faults(scenario)
    if isinstance(scenario, RoadScenario):
        yield from _road_faults(scenario)
    try:
        load_rig(scenario.rig)
    except InputError as error:
        yield ("rig",), str(error)
    yield from ((("light_change", index), what) for index, what in order_faults(scenario.light_change))
    yield from _expectation_faults(scenario)
    for index, at_s in enumerate(scenario.event_times_s):
        if at_s > scenario.duration_s:
            yield ("event", index, "at_s"), f"{at_s} s comes after the end at {scenario.duration_s} s"
    for key, values in scenario.vary.items():
        for value in values.extremes:
            try:
                varied(scenario, {key: value})
            except InputError as error:
                yield ("vary", key), str(error)


@cache
def plant_of(name: str) -> Plant:
    """The plant of that name or file; read once."""
    return load_plant(name)


def _rail_faults(scenario: RailScenario) -> Iterator[Fault]:
    yield from _light_faults(scenario, RAIL_LIGHTS, "a room")
    yield from _plant_faults(scenario)
    yield from _surroundings_faults(scenario)


def _road_faults(scenario: RoadScenario) -> Iterator[Fault]:
    yield from _light_faults(scenario, ROAD_LIGHTS, "a road")
    try:
        network = load_network(scenario.network)
    except InputError as error:
        yield ("network",), str(error)
        return
    try:
        check_traffic(network, scenario.traffic)
    except TrafficFaultError as error:
        yield error.keys, str(error)
    if scenario.expect.derail:
        yield ("expect", "derail"), "nothing derails on a road"


def _light_faults(scenario: Scenario, lights: Sequence[LightPreset], where: str) -> Iterator[Fault]:
    """Lights that do not shine there."""
    named = [(("light",), scenario.light)]
    changes = [(("light_change", index, "to"), change.to) for index, change in enumerate(scenario.light_change)]
    for key, light in (*named, *changes):
        if light not in lights:
            yield key, f"{str(light)!r} is no light of {where}; choose from {', '.join(lights)}"


def _plant_faults(scenario: RailScenario) -> Iterator[Fault]:
    try:
        plant = plant_of(scenario.plant)
    except InputError as error:
        yield ("plant",), str(error)
        return
    try:
        check_motion(plant, scenario.motion)
    except MotionFaultError as error:
        yield error.keys, str(error)


def _surroundings_faults(scenario: RailScenario) -> Iterator[Fault]:
    """Objects that a vehicle would run into."""
    try:
        plant = plant_of(scenario.plant)
    except InputError:
        return  # told at its own key
    track = np.concatenate([section.curve.points(_TRACK_STEP_M) for section in plant.sections.values()])
    half_width = max((v.size_m[1] / 2 for v in scenario.vehicle), default=0.0) + _SWAY_M
    height = max((v.size_m[2] for v in scenario.vehicle), default=0.0) + _HEADROOM_M
    groups = (("object", [(thing,) for thing in scenario.object]), ("bridge", [b.parts for b in scenario.bridge]))
    for key, owners in groups:
        for index, parts in enumerate(owners):
            if any(blocks_track(part, track, half_width_m=half_width, height_m=height) for part in parts):
                yield (key, index), "stands in the way of the vehicles; move it off the track or above them"


def _expectation_faults(scenario: Scenario) -> Iterator[Fault]:
    ids = scenario.actors
    for key, groups in (("contact", scenario.expect.contact), ("derail", [(id_,) for id_ in scenario.expect.derail])):
        for index, group in enumerate(groups):
            for id_ in group:
                if id_ not in ids:
                    yield ("expect", key, index), f"vehicle {id_!r} is unknown; there are {', '.join(ids) or 'none'}"
            if len(set(group)) < len(group):
                yield ("expect", key, index), f"vehicle {group[0]!r} cannot touch itself"
