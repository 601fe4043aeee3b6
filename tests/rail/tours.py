"""A vehicle that visits every section of a plant, setting switches as it needs them."""

from collections import deque
from dataclasses import replace

from contracts import SwitchState
from rail.graph import Location, advance, metres_to_end, port_ahead
from rail.plant import End, Plant, Port


def tour(plant: Plant, start: Location) -> list[Location]:
    """Middles of sections, one hop after the other, until every section is visited; hops are driven by ``advance``."""
    states = dict.fromkeys(plant.switches, SwitchState.STRAIGHT)
    visited, here, way = {start.section}, start, [start]
    while len(visited) < len(plant.sections):
        for hop in route_to_new(plant, here, visited):
            if hop == here.reversed():
                here = hop
                continue
            if switch := plant.switch_at.get(port_ahead(here)):
                branch = entrance(hop) if port_ahead(here) == switch.stem else port_ahead(here)
                states[switch.id] = SwitchState.STRAIGHT if branch == switch.straight else SwitchState.DIVERGING
            half_m = plant.sections[hop.section].length_m / 2
            driven = advance(plant, here, metres_to_end(plant, here) + half_m, states)
            assert driven.blocked is None
            assert driven.location.section == hop.section
            assert driven.location.direction == hop.direction
            here = hop
            visited.add(here.section)
            way.append(here)
    return way


def route_to_new(plant: Plant, start: Location, visited: set[str]) -> list[Location]:
    """Hops from middle to middle (or turning round on the spot) to the nearest section not yet visited."""
    before: dict[Location, Location | None] = {start: None}
    queue = deque([start])
    while queue:
        here = queue.popleft()
        if here.section not in visited:
            route = [here]
            while (previous := before[route[0]]) is not None:
                route.insert(0, previous)
            return route[1:]
        for there in [here.reversed(), *(middle(plant, port) for port in onward(plant, port_ahead(here)))]:
            if there not in before:
                before[there] = here
                queue.append(there)
    raise AssertionError(f"no way to {set(plant.sections) - visited}")


def onward(plant: Plant, port: Port) -> list[Port]:
    if port in plant.joints:
        return [plant.joints[port]]
    switch = plant.switch_at.get(port)
    if switch is None:
        return []
    return [switch.straight, switch.diverging] if port == switch.stem else [switch.stem]


def middle(plant: Plant, entered: Port) -> Location:
    """The middle of the section that is entered through a port, looking on."""
    return Location(
        entered.section, plant.sections[entered.section].length_m / 2, 1 if entered.end is End.START else -1
    )


def entrance(location: Location) -> Port:
    return port_ahead(replace(location, direction=-location.direction))
