"""What lies ahead of a vehicle on its path: the nearest body on the track, or the end of the way."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf

from rail.graph import Location, SwitchStates, metres_to_end, port_ahead
from rail.plant import End, Plant, Port

SIGHT_M = 1.5  # more than the braking distance of anything that runs on the plants


@dataclass(frozen=True)
class Occupant:
    """Another vehicle as seen along the track.

    marks: both ends of its body and its centre, looking the way it faces.
    speed_mps: its speed, positive the way it faces.
    """

    marks: tuple[Location, ...]
    speed_mps: float


@dataclass(frozen=True)
class Obstacle:
    """The nearest thing that cannot be passed: its distance, infinite if there is none, and how fast it goes away."""

    distance_m: float = inf
    speed_mps: float = 0.0


def obstacle_ahead(plant: Plant, start: Location, states: SwitchStates, others: Sequence[Occupant]) -> Obstacle:
    """The nearest of ``others`` on the way that ``start`` looks along, or its end; within ``SIGHT_M``."""
    for entrance, done_m in _stretches(plant, start, states):
        found = [
            Obstacle(done_m + ahead_m, other.speed_mps * entrance.direction * mark.direction)
            for other in others
            for mark in other.marks
            if mark.section == entrance.section
            and (ahead_m := (mark.offset_m - entrance.offset_m) * entrance.direction) >= 0.0
        ]
        if found:
            return min(found, key=lambda obstacle: (obstacle.distance_m, obstacle.speed_mps))
        end_m = done_m + metres_to_end(plant, entrance)
        if end_m > SIGHT_M:
            break
        if _onward(plant, port_ahead(entrance), states) is None:
            return Obstacle(end_m)
    return Obstacle()


def _stretches(plant: Plant, start: Location, states: SwitchStates) -> Iterator[tuple[Location, float]]:
    """``start``, then the entrance of each further section on the way, with the distance to it."""
    here, done_m = start, 0.0
    while True:
        yield here, done_m
        done_m += metres_to_end(plant, here)
        port = _onward(plant, port_ahead(here), states)
        if port is None:
            return
        at_start = port.end is End.START
        here = Location(port.section, 0.0 if at_start else plant.sections[port.section].length_m, 1 if at_start else -1)


def _onward(plant: Plant, port: Port, states: SwitchStates) -> Port | None:
    """Where track that leaves its section through ``port`` goes on; None at a buffer or a switch against it."""
    if port in plant.joints:
        return plant.joints[port]
    switch = plant.switch_at.get(port)
    return switch.other_side(port, states[switch.id]) if switch else None
