"""The motors of the switches: asked for a setting, they move there in their own time, but never beneath a vehicle."""

from collections.abc import Mapping, Set
from types import MappingProxyType

from contracts import Event, EventKind, SwitchState


class SwitchDrives:
    """All switches of a plant. Time is the internal step's: a switch starts and arrives at the beginning of a step."""

    def __init__(self, states: Mapping[str, SwitchState], travel_ns: int) -> None:
        self._states = dict(states)
        self._travel_ns = travel_ns
        self._wanted: dict[str, SwitchState] = {}  # asked for and not begun, because a vehicle stands on the switch
        self._moving: dict[str, tuple[int, SwitchState]] = {}  # arrival and target

    @property
    def states(self) -> Mapping[str, SwitchState]:
        """How each switch lies now; later calls give another mapping, this one stays as it is."""
        return MappingProxyType(dict(self._states))

    def ask(self, switch: str, setting: SwitchState) -> None:
        """Ask for a setting; the latest wins."""
        self._wanted[switch] = setting

    def update(self, time_ns: int, occupied: Set[str]) -> list[Event]:
        """Finish and begin movements at ``time_ns``; ``occupied`` switches wait."""
        events: list[Event] = []
        for switch, (arrival_ns, target) in list(self._moving.items()):
            if arrival_ns <= time_ns:
                del self._moving[switch]
                events.append(self._set(time_ns, switch, target))
        for switch, target in list(self._wanted.items()):
            if switch in occupied:
                continue
            del self._wanted[switch]
            heading_for = self._moving[switch][1] if switch in self._moving else self._states[switch]
            if target is not heading_for:
                events += self._begin(time_ns, switch, target)
        return events

    def _begin(self, time_ns: int, switch: str, target: SwitchState) -> list[Event]:
        if self._travel_ns == 0:
            return [self._set(time_ns, switch, target)]
        already_moving = switch in self._moving
        self._moving[switch] = (time_ns + self._travel_ns, target)
        return [] if already_moving else [self._set(time_ns, switch, SwitchState.MOVING)]

    def _set(self, time_ns: int, switch: str, state: SwitchState) -> Event:
        self._states[switch] = state
        return Event(time_ns, EventKind.SWITCH, (switch,), str(state))
