"""Hypothesis strategies that shrink: boxes, vehicles, motions and whole scenarios.

Shrinking leads to fewer vehicles and events, short times, round numbers and the first section of the plant.
"""

from math import hypot, pi
from typing import Any

from hypothesis import strategies as st

from rail.graph import Location, pose_at
from rail.plant import Plant
from scenarios.check import plant_of
from scenarios.schema import RailScenario
from sim.boxes import Box
from sim.colours import Colour
from sim.lights import RAIL_LIGHTS
from sim.motion_spec import Heading, Manner, MotionSpec, Start, SwitchSetting, TimedEvent, VehicleSpec

_SETTINGS: tuple[SwitchSetting, ...] = ("straight", "diverging")
_SLOT_M = 0.20  # distance of starting places: vehicles of the usual size stand apart however they face
_CLEAR_M = 0.07  # free track from a starting place to the end of its section


def headings() -> st.SearchStrategy[float]:
    """Angles in radians, (-pi, pi]."""
    return st.floats(-pi, pi, exclude_min=True)


@st.composite
def boxes(draw: st.DrawFn, *, within_m: float = 0.3) -> Box:
    """Footprints of vehicle-like size whose centres lie within a square around the origin."""
    place = st.floats(-within_m, within_m)
    side = st.floats(0.02, 0.3)
    return Box(draw(place), draw(place), draw(headings()), draw(side), draw(side))


def starting_places(plant: Plant) -> tuple[tuple[str, float], ...]:
    """Sections and offsets at which vehicles can stand at the same time, all of them apart from each other."""
    places: list[tuple[str, float]] = []
    points: list[tuple[float, float]] = []
    for section in plant.sections.values():
        for k in range(int((section.length_m - 2 * _CLEAR_M) / _SLOT_M) + 1):
            pose = pose_at(plant, Location(section.id, _CLEAR_M + k * _SLOT_M, 1))
            if all(hypot(pose.x_m - x, pose.y_m - y) >= _SLOT_M * 0.9 for x, y in points):
                points.append((pose.x_m, pose.y_m))
                places.append((section.id, _CLEAR_M + k * _SLOT_M))
    return tuple(places)


@st.composite
def vehicles(draw: st.DrawFn, plant: Plant, *, colour: Colour, place: tuple[str, float]) -> VehicleSpec:
    """A vehicle that starts at ``place``; its id is its colour."""
    heading = draw(st.sampled_from([Heading.FORWARD, Heading.BACKWARD]))
    return VehicleSpec(
        id=str(colour),
        colour=colour,
        start=Start(place[0], place[1], heading),
        speed_mps=draw(st.integers(-12, 12)) * 0.05,
        acceleration_mps2=draw(st.sampled_from([0.5, 0.2, 1.0])),
        braking_mps2=draw(st.sampled_from([1.0, 0.5, 2.0])),
        manner=draw(st.sampled_from(Manner)),
        operates_switches=draw(st.booleans()),
        route=draw(settings(plant)),
        link_failure=draw(st.sampled_from([0.0, 0.5])),
    )


def settings(plant: Plant) -> st.SearchStrategy[dict[str, SwitchSetting]]:
    """A position for some of the switches."""
    either: st.SearchStrategy[SwitchSetting] = st.sampled_from(_SETTINGS)
    return st.fixed_dictionaries({}, optional=dict.fromkeys(plant.switches, either))


@st.composite
def timed_events(draw: st.DrawFn, plant: Plant, ids: list[str], duration_s: float) -> TimedEvent:
    """A command to a switch or to one of the vehicles ``ids``; there must be at least one of either."""
    at_s = draw(st.integers(0, int(duration_s * 100))) / 100
    subject = draw(st.sampled_from([*ids, *plant.switches]))
    if subject not in ids:
        return TimedEvent(at_s, switch=subject, set=draw(st.sampled_from(_SETTINGS)))
    if draw(st.booleans()):
        return TimedEvent(at_s, vehicle=subject, speed_mps=draw(st.integers(-12, 12)) * 0.05)
    return TimedEvent(at_s, vehicle=subject, do=draw(st.sampled_from(["stop", "reverse"])))


def motions(
    plant: Plant, *, min_vehicles: int = 0, max_vehicles: int = 4, duration_s: float = 3.0
) -> st.SearchStrategy[MotionSpec]:
    """Vehicles and commands that ``plant`` can serve; at most one vehicle of each colour."""
    places = st.sampled_from(starting_places(plant))
    starts = st.lists(places, unique=True, min_size=min_vehicles, max_size=min(max_vehicles, len(Colour)))
    return starts.flatmap(lambda places: _motion_from(plant, places, duration_s))


@st.composite
def _motion_from(draw: st.DrawFn, plant: Plant, places: list[tuple[str, float]], duration_s: float) -> MotionSpec:
    moving = tuple(draw(vehicles(plant, colour=c, place=p)) for c, p in zip(Colour, places, strict=False))
    ids = [vehicle.id for vehicle in moving]
    events = st.lists(timed_events(plant, ids, duration_s), max_size=4) if ids or plant.switches else st.just([])
    return MotionSpec(moving, tuple(draw(events)), draw(settings(plant)))


def scenarios(
    plant: str = "oval", rig: str = "two_overhead", duration_s: float = 2.0
) -> st.SearchStrategy[RailScenario]:
    """Whole scenarios of ``duration_s`` without expectations."""
    return st.builds(
        _scenario,
        motions(plant_of(plant), duration_s=duration_s),
        plant=st.just(plant),
        rig=st.just(rig),
        duration_s=st.just(duration_s),
        light=st.sampled_from(RAIL_LIGHTS),
        seed=st.integers(0, 2**31 - 1),
        fps=st.sampled_from([25.0, 10.0, 50.0]),
    )


def _scenario(motion: MotionSpec, **keys: Any) -> RailScenario:
    return RailScenario(
        title="Drawn by Hypothesis",
        vehicle=motion.vehicles,
        event=motion.events,
        switch=motion.switches,
        switch_travel_s=motion.switch_travel_s,
        **keys,
    )
