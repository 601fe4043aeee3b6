"""Ways along the plant: how far it is from one place to another, and where one can get to."""

from collections.abc import Iterator
from heapq import heappop, heappush
from itertools import count

from contracts import SwitchState
from rail.graph import Location, SwitchStates, at_port, check_location, metres_to_end, port_ahead, state_of
from rail.plant import Plant, Port


def distance_ahead(plant: Plant, a: Location, b: Location, states: SwitchStates | None = None) -> float | None:
    """Least way from ``a`` to the place of ``b`` (its direction does not matter) without turning back.

    states: how the switches lie; None lets each be set as needed. None where no way leads there.
    """
    check_location(plant, a)
    check_location(plant, b)
    ways = (
        done_m + (b.offset_m - here.offset_m) * here.direction
        for here, done_m in _ways_ahead(plant, a, states)
        if here.section == b.section and (b.offset_m - here.offset_m) * here.direction >= 0
    )
    return min(ways, default=None)


def distance(plant: Plant, a: Location, b: Location, states: SwitchStates | None = None) -> float | None:
    """Least way along the track between the places of ``a`` and ``b``, starting forwards or backwards from ``a``."""
    ways = (distance_ahead(plant, start, b, states) for start in (a, a.reversed()))
    return min((way for way in ways if way is not None), default=None)


def sections_reachable(plant: Plant, location: Location, states: SwitchStates | None = None) -> frozenset[str]:
    """Sections that a vehicle comes to from ``location`` without turning back, its own included."""
    check_location(plant, location)
    return frozenset(here.section for here, _ in _ways_ahead(plant, location, states))


def _ways_ahead(plant: Plant, start: Location, states: SwitchStates | None) -> Iterator[tuple[Location, float]]:
    """``start``, then every section entrance ahead of it with its distance, nearest first (Dijkstra 1959)."""
    order = count()  # decides between equal distances; locations have no order of their own
    queue: list[tuple[float, int, Location]] = [(0.0, next(order), start)]
    seen: set[Location] = set()
    while queue:
        done_m, _, here = heappop(queue)
        if here in seen:
            continue
        seen.add(here)
        yield here, done_m
        done_m += metres_to_end(plant, here)
        for port in _exits(plant, port_ahead(here), states):
            heappush(queue, (done_m, next(order), at_port(plant, port)))


def _exits(plant: Plant, port: Port, states: SwitchStates | None) -> list[Port]:
    """Ports at which track that leaves through ``port`` can go on."""
    if port in plant.joints:
        return [plant.joints[port]]
    if port not in plant.switch_at:
        return []
    switch = plant.switch_at[port]
    chosen = [SwitchState.STRAIGHT, SwitchState.DIVERGING] if states is None else [state_of(switch, states)]
    return [exit_ for state in chosen if (exit_ := switch.other_side(port, state)) is not None]
