"""Moving along the plant: where a distance leads, what is passed on the way, which switch comes next."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from math import copysign, isfinite, pi

from contracts import InputError, SwitchState
from rail.curves import Pose2, wrapped
from rail.plant import Balise, BufferStop, End, Plant, Port, Switch

SwitchStates = Mapping[str, SwitchState]


@dataclass(frozen=True)
class Location:
    """A place on the track with a direction.

    offset_m: along the section from its start.
    direction: +1 looking towards the section's end, -1 towards its start.
    """

    section: str
    offset_m: float
    direction: int

    def reversed(self) -> "Location":
        """The same place, looking back."""
        return replace(self, direction=-self.direction)


class BlockedBy(StrEnum):
    """Why a way ends."""

    BUFFER = "buffer"
    SWITCH_AGAINST = "switch against"
    SWITCH_MOVING = "switch moving"


@dataclass(frozen=True)
class Block:
    """What stopped an advance: the kind and the id of the buffer stop or switch."""

    kind: BlockedBy
    subject: str


@dataclass(frozen=True)
class Passage:
    """A balise or switch passed, and after how many metres of this advance (never negative)."""

    subject: Balise | Switch
    distance_m: float


@dataclass(frozen=True)
class Advance:
    """The outcome of ``advance``.

    location: where it ended; looks the same way along the track as at the start, also after moving backwards.
    passages: in the order in which they were passed.
    blocked: what cut the way short, or None.
    travelled_m: signed like the distance asked for, and equal to it unless blocked.
    """

    location: Location
    passages: tuple[Passage, ...]
    blocked: Block | None
    travelled_m: float


@dataclass(frozen=True)
class SwitchAhead:
    """The next switch on a way: ``port`` is the one through which it would be entered."""

    switch: Switch
    port: Port
    distance_m: float

    @property
    def facing(self) -> bool:
        """Whether it is approached from its stem."""
        return self.port == self.switch.stem


def check_location(plant: Plant, location: Location) -> Location:
    """``location`` if it is on ``plant``'s track; else InputError."""
    length_m = plant.section(location.section).length_m
    if not 0.0 <= location.offset_m <= length_m:
        raise InputError(
            f"offset {location.offset_m} m lies off section {location.section!r}, which is {length_m:.3f} m long"
        )
    if location.direction not in (1, -1):
        raise InputError(f"direction {location.direction!r} must be 1 (towards the section's end) or -1")
    return location


def pose_at(plant: Plant, location: Location) -> Pose2:
    """Pose on the ground; the heading follows ``location.direction`` and lies in (-pi, pi]."""
    pose = plant.section(location.section).curve.pose_at(location.offset_m)
    turn_rad = 0.0 if location.direction > 0 else pi
    return Pose2(pose.x_m, pose.y_m, wrapped(pose.heading_rad + turn_rad))


def advance(plant: Plant, location: Location, distance_m: float, states: SwitchStates) -> Advance:
    """Follow the track for ``distance_m`` (negative: backwards) through switches as they lie.

    A balise at the very end of the way is passed, one at its very beginning is not. A joint or switch at the very end
    is not passed yet. Raises InputError for a place off the track, a distance that is not finite or a switch on the way
    without a state.
    """
    check_location(plant, location)
    if not isfinite(distance_m):
        raise InputError(f"a distance of {distance_m} m cannot be travelled; give a finite one")
    backwards = distance_m < 0
    here = location.reversed() if backwards else location
    left_m, passages, blocked = abs(distance_m), list[Passage](), None
    while left_m > 0:
        run_m = min(left_m, metres_to_end(plant, here))
        done_m = abs(distance_m) - left_m
        passages += [Passage(b, done_m + run) for b, run in _balises_within(plant, here, run_m)]
        here, left_m = _moved(plant, here, run_m), left_m - run_m
        if left_m > 0:
            entered = _entered(plant, port_ahead(here), states)
            if isinstance(entered, Block):
                blocked = entered
                break
            if switch := plant.switch_at.get(port_ahead(here)):
                passages.append(Passage(switch, abs(distance_m) - left_m))
            here = entered
    travelled_m = copysign(abs(distance_m) - left_m, distance_m)
    return Advance(here.reversed() if backwards else here, tuple(passages), blocked, travelled_m)


def port_ahead(location: Location) -> Port:
    """The end of its section that ``location`` looks at."""
    return Port(location.section, End.END if location.direction > 0 else End.START)


def metres_to_end(plant: Plant, location: Location) -> float:
    """Distance to the end of the section that ``location`` looks at."""
    length_m = plant.sections[location.section].length_m
    return length_m - location.offset_m if location.direction > 0 else location.offset_m


def next_switch_ahead(plant: Plant, location: Location, within_m: float) -> SwitchAhead | None:
    """The first switch that a vehicle looking ahead from ``location`` comes to, at most ``within_m`` metres away."""
    check_location(plant, location)
    distance_m = metres_to_end(plant, location)
    while distance_m <= within_m:
        port = port_ahead(location)
        if switch := plant.switch_at.get(port):
            return SwitchAhead(switch, port, distance_m)
        if port not in plant.joints:
            return None
        location = at_port(plant, plant.joints[port])
        distance_m += metres_to_end(plant, location)
    return None


def _entered(plant: Plant, port: Port, states: SwitchStates) -> Location | Block:
    """Where one comes out that leaves a section through ``port``, or what blocks the way."""
    if port in plant.joints:
        return at_port(plant, plant.joints[port])
    buffer: BufferStop | None = plant.buffer_at.get(port)
    if buffer is not None:
        return Block(BlockedBy.BUFFER, buffer.id)
    switch = plant.switch_at[port]
    state = state_of(switch, states)
    other = switch.other_side(port, state)
    if other is not None:
        return at_port(plant, other)
    moving = switch.branch(state) is None
    return Block(BlockedBy.SWITCH_MOVING if moving else BlockedBy.SWITCH_AGAINST, switch.id)


def state_of(switch: Switch, states: SwitchStates) -> SwitchState:
    """How ``switch`` lies; InputError if ``states`` does not say."""
    try:
        return states[switch.id]
    except KeyError:
        raise InputError(f"no state given for switch {switch.id!r}; states are known of {sorted(states)}") from None


def at_port(plant: Plant, port: Port) -> Location:
    """Just inside the section, looking away from ``port``."""
    if port.end is End.START:
        return Location(port.section, 0.0, 1)
    return Location(port.section, plant.sections[port.section].length_m, -1)


def _moved(plant: Plant, location: Location, run_m: float) -> Location:
    """``location`` moved ahead within its section; exactly on the end if it reaches it."""
    if run_m >= metres_to_end(plant, location):
        offset_m = plant.sections[location.section].length_m if location.direction > 0 else 0.0
    else:
        offset_m = location.offset_m + location.direction * run_m
    return replace(location, offset_m=offset_m)


def _balises_within(plant: Plant, location: Location, run_m: float) -> list[tuple[Balise, float]]:
    """Balises of this section in (0, run_m] ahead, with their distances, nearest first."""
    balises = plant.balises_of[location.section][:: location.direction]
    ahead = [(balise, (balise.offset_m - location.offset_m) * location.direction) for balise in balises]
    return [(balise, run) for balise, run in ahead if 0.0 < run <= run_m]
