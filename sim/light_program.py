"""Light that changes from one preset to another during a run."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from contracts import InputError
from sim.lights import Light, LightPreset, light_at


@dataclass(frozen=True)
class LightChange:
    """Another light.

    at_s: when it begins to come up. to: the new light.
    over_s: time until nothing is left of the old one; 0 is a switch.
    """

    at_s: float
    to: LightPreset
    over_s: float = 0.0

    def __post_init__(self) -> None:
        for name in ("at_s", "over_s"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"{name} = {value} must be finite and not negative")


@dataclass(frozen=True)
class LightProgram:
    """A light and its changes, in order, none before the one before it is over."""

    first: LightPreset
    changes: tuple[LightChange, ...] = ()

    def __post_init__(self) -> None:
        for _, what in order_faults(self.changes):
            raise InputError(what)

    def at(self, time_ns: int) -> tuple[tuple[float, Light], ...]:
        """The lights that shine and their weights, which sum to 1; light is linear, so pictures mix the same way."""
        time_s = time_ns * 1e-9
        old, new, weight = self.first, self.first, 1.0
        for change in self.changes:
            if time_s >= change.at_s:
                old, new = new, change.to
                weight = min(1.0, (time_s - change.at_s) / change.over_s) if change.over_s else 1.0
        if weight == 1.0:
            return ((1.0, light_at(new, time_ns)),)
        return ((1.0 - weight, light_at(old, time_ns)), (weight, light_at(new, time_ns)))


def lights_at(light: LightPreset | LightProgram, time_ns: int) -> tuple[tuple[float, Light], ...]:
    """See ``LightProgram.at``; a preset is a program without changes."""
    return light.at(time_ns) if isinstance(light, LightProgram) else ((1.0, light_at(light, time_ns)),)


def order_faults(changes: Sequence[LightChange]) -> Iterator[tuple[int, str]]:
    """Changes that begin before the one before them is over: their number, and what is wrong."""
    for number, (before, change) in enumerate(pairwise(changes), start=1):
        over_s = before.at_s + before.over_s
        if change.at_s < over_s:
            yield (
                number,
                f"the light changes at {change.at_s} s, before the change to {before.to} is over at {over_s} s",
            )
