"""The short infrared link over which a vehicle asks a switch for a setting."""

from dataclasses import dataclass

from contracts import SwitchState
from rail.graph import Location, next_switch_ahead
from rail.plant import Plant
from sim.vehicle import Vehicle

LINK_M = 0.15  # reach, from the leading end of the body


@dataclass(frozen=True)
class Request:
    """What a vehicle wants of the switch before it; None if it takes that as it lies."""

    switch: str
    setting: SwitchState | None


def request_of(plant: Plant, vehicle: Vehicle, leading_end: Location) -> Request | None:
    """The request to the switch that is within reach; None if none is, or the vehicle operates none.

    leading_end: the end of the body that goes first, looking the way it goes.
    Before points it wants what its route says; from a branch it wants that branch.
    """
    if not vehicle.spec.operates_switches or vehicle.derailed or not (vehicle.speed_mps or vehicle.commanded_mps):
        return None
    ahead = next_switch_ahead(plant, leading_end, LINK_M)
    if ahead is None:
        return None
    if not ahead.facing:
        straight = ahead.port == ahead.switch.straight
        return Request(ahead.switch.id, SwitchState.STRAIGHT if straight else SwitchState.DIVERGING)
    setting = vehicle.spec.route.get(ahead.switch.id)
    return Request(ahead.switch.id, SwitchState(setting) if setting else None)
