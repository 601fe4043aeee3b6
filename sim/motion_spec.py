"""What moves on the rails and what happens when: the typed specification that ``sim.rail_motion`` runs."""

import math
from collections import Counter
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

from contracts import InputError
from sim.colours import Colour

SwitchSetting = Literal["straight", "diverging"]


class Heading(StrEnum):
    """Which way a vehicle faces at its start: the compass direction nearest to the track's, or along the section."""

    EAST = "east"
    NORTH = "north"
    WEST = "west"
    SOUTH = "south"
    FORWARD = "forward"  # towards the section's end
    BACKWARD = "backward"  # towards the section's start


class Manner(StrEnum):
    """How a vehicle treats what is ahead of it on its path."""

    ATTENTIVE = "attentive"  # keeps its distance and stops before whatever it cannot pass
    BLIND = "blind"  # holds its speed


@dataclass(frozen=True)
class Start:
    """Where a vehicle's centre is at the beginning, metres along the section from its start."""

    section: str
    offset_m: float
    heading: Heading


@dataclass(frozen=True)
class VehicleSpec:
    """One vehicle.

    speed_mps: commanded speed; it rolls at it from the first moment. Negative: backwards.
    size_m: length, width, height of the body.
    wheelbase_m: distance between the axles, which lie symmetrically about the body's centre.
    acceleration_mps2, braking_mps2: limits of what its motor and its brakes do.
    operates_switches: whether it asks for switches over its 15 cm link: before points, for what ``route`` says;
        from a branch, for that branch.
    route: setting to ask for, by switch.
    link: ``"dead"`` never reaches a switch.
    link_failure: probability that one request is lost.
    behaviour: ``"package.module:function"``, a ``sim.drivers.Driver`` that takes the place of ``manner``.
    """

    id: str
    colour: Colour
    start: Start
    speed_mps: float
    size_m: tuple[float, float, float] = (0.12, 0.06, 0.06)
    wheelbase_m: float = 0.07
    acceleration_mps2: float = 0.5
    braking_mps2: float = 1.0
    manner: Manner = Manner.ATTENTIVE
    operates_switches: bool = True
    route: dict[str, SwitchSetting] = field(default_factory=dict)
    link: Literal["live", "dead"] = "live"
    link_failure: float = 0.0
    behaviour: str | None = None

    def __post_init__(self) -> None:
        if not self.id:
            raise InputError("vehicle: id is empty")
        positive = {"wheelbase_m": self.wheelbase_m, "acceleration_mps2": self.acceleration_mps2}
        positive |= {"braking_mps2": self.braking_mps2} | {f"size_m[{k}]": x for k, x in enumerate(self.size_m)}
        for name, value in positive.items():
            if not (math.isfinite(value) and value > 0):
                raise InputError(f"vehicle {self.id}: {name} = {value} must be finite and positive")
        if not (math.isfinite(self.speed_mps) and math.isfinite(self.start.offset_m)):
            raise InputError(f"vehicle {self.id}: speed_mps and start.offset_m must be finite")
        if self.wheelbase_m > self.size_m[0]:
            raise InputError(f"vehicle {self.id}: wheelbase_m = {self.wheelbase_m} exceeds its length {self.size_m[0]}")
        if not 0 <= self.link_failure <= 1:
            raise InputError(f"vehicle {self.id}: link_failure = {self.link_failure} must lie in [0, 1]")


@dataclass(frozen=True)
class TimedEvent:
    """A command at a moment: either ``switch`` and ``set``, or ``vehicle`` and one of ``speed_mps`` and ``do``.

    at_s: seconds since the start of the run; it takes effect when the next internal step of the motion begins.
    do: ``"stop"``, or ``"reverse"``: brake and go back the other way at the speed commanded before.
    """

    at_s: float
    switch: str | None = None
    set: SwitchSetting | None = None
    vehicle: str | None = None
    speed_mps: float | None = None
    do: Literal["stop", "reverse"] | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.at_s) and self.at_s >= 0):
            raise InputError(f"event: at_s = {self.at_s} must be finite and not negative")
        given = {name for name in ("switch", "set", "vehicle", "speed_mps", "do") if getattr(self, name) is not None}
        if given not in ({"switch", "set"}, {"vehicle", "speed_mps"}, {"vehicle", "do"}):
            raise InputError(
                f"event at {self.at_s} s has {', '.join(sorted(given)) or 'no command'}; accepted: "
                "switch and set, vehicle and speed_mps, or vehicle and do"
            )
        if self.speed_mps is not None and not math.isfinite(self.speed_mps):
            raise InputError(f"event at {self.at_s} s: speed_mps = {self.speed_mps} must be finite")


@dataclass(frozen=True)
class MotionSpec:
    """All that moves on one plant.

    switches: how switches lie at the beginning, by id; those not named lie straight.
    switch_travel_s: time a switch takes to move from one end to the other.
    """

    vehicles: tuple[VehicleSpec, ...]
    events: tuple[TimedEvent, ...] = ()
    switches: dict[str, SwitchSetting] = field(default_factory=dict)
    switch_travel_s: float = 0.25

    def __post_init__(self) -> None:
        for what in ("id", "colour"):
            for value, count in Counter(str(getattr(vehicle, what)) for vehicle in self.vehicles).items():
                if count > 1:
                    raise InputError(f"{count} vehicles have the {what} {value}; each needs its own")
        if not (math.isfinite(self.switch_travel_s) and self.switch_travel_s >= 0):
            raise InputError(f"switch_travel_s = {self.switch_travel_s} must be finite and not negative")
