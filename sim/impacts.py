"""Contacts between the vehicles of a plant, and what they do to the motion: whoever touches comes to rest at once."""

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations

from rail.graph import SwitchStates
from rail.plant import Plant
from sim.boxes import Box, separation_m
from sim.contacts import TOUCH_M, first_touch
from sim.glide import Glide
from sim.vehicle import Vehicle

RELEASE_M = 1e-4  # air after which two vehicles that touched count as apart again
_NOTICEABLE_M = 1e-9  # a motion that changes a gap by less neither opens nor closes it

Pair = tuple[int, int]


class StepMotion:
    """The motion of all vehicles during one step; ``stop`` cuts it short."""

    def __init__(
        self, plant: Plant, vehicles: Sequence[Vehicle], glides: Sequence[Glide], states: SwitchStates, step_s: float
    ) -> None:
        self._plant, self._vehicles, self._states, self.step_s = plant, vehicles, states, step_s
        self.glides = list(glides)
        self._swept_m = [self._reach_of(index) for index in range(len(vehicles))]

    @cached_property
    def pairs(self) -> list[Pair]:
        """All pairs of vehicles, by index."""
        return list(combinations(range(len(self._vehicles)), 2))

    def box(self, index: int, time_s: float) -> Box:
        """Footprint of a vehicle at a time within the step."""
        moved = self._vehicles[index].after(self._plant, self.glides[index], time_s, self._states)
        return moved.box(self._plant, self._states)

    def gap_m(self, pair: Pair, *times_s: float) -> float:
        """Separation of two vehicles, each at its own time, or both at the same one."""
        return separation_m(self.box(pair[0], times_s[0]), self.box(pair[1], times_s[-1]))

    def closing_m(self, pair: Pair) -> float:
        """How much nearer the two can come during the step, at most."""
        return self._swept_m[pair[0]] + self._swept_m[pair[1]]

    def touch_s(self, pair: Pair) -> float | None:
        """When the two first touch."""
        a, b = pair
        closing_mps = sum(self._vehicles[k].reach * self.glides[k].top_speed_mps(self.step_s) for k in pair)
        return first_touch(
            lambda t: self.box(a, t), lambda t: self.box(b, t), closing_mps=closing_mps, until_s=self.step_s
        )

    def stop(self, index: int, time_s: float) -> None:
        """A dead stop of one vehicle."""
        self.glides[index] = self.glides[index].stopped_at(time_s)
        self._swept_m[index] = self._reach_of(index)

    def _reach_of(self, index: int) -> float:
        """How far any point of a vehicle moves during the step, at most."""
        return self._vehicles[index].reach * abs(self.glides[index].travelled_m(self.step_s))


class ImpactWatch:
    """Watches all pairs of vehicles from step to step.

    For each pair it keeps a distance by which the two are certainly apart; only when the ways they have run since
    could have used it up are the bodies themselves looked at.
    """

    def __init__(self) -> None:
        self._clearance_m: dict[Pair, float] = {}
        self._touching: set[Pair] = set()

    def stop_at_contacts(self, motion: StepMotion) -> dict[Pair, float]:
        """Stop whoever touches in this step, or already touches and presses on; the time of each new contact."""
        for pair in self._touching:
            if motion.closing_m(pair) > 0.0:
                _hold_back(motion, pair)
        contacts: dict[Pair, float] = {}
        while hits := _touches(motion, self._doubtful(motion, contacts)):
            time_s, pair = min(hits)  # an earlier contact may prevent a later one
            contacts[pair] = time_s
            for index in pair:
                motion.stop(index, time_s)
        self._touching |= contacts.keys()
        self._keep_books(motion)
        return contacts

    def _doubtful(self, motion: StepMotion, contacts: dict[Pair, float]) -> list[Pair]:
        """The pairs that might come to touch in this step."""
        return [
            pair
            for pair in motion.pairs
            if pair not in self._touching
            and pair not in contacts
            and (closing_m := motion.closing_m(pair)) > 0.0
            and self._clearance_m.get(pair, 0.0) - closing_m <= TOUCH_M
        ]

    def _keep_books(self, motion: StepMotion) -> None:
        for pair in motion.pairs:
            closing_m = motion.closing_m(pair)
            left_m = self._clearance_m.get(pair, 0.0) - closing_m
            doubtful = left_m <= TOUCH_M and (closing_m > 0.0 or pair not in self._clearance_m)
            self._clearance_m[pair] = motion.gap_m(pair, motion.step_s) if doubtful else left_m
        self._touching = {pair for pair in self._touching if self._clearance_m[pair] <= RELEASE_M}


def _touches(motion: StepMotion, pairs: Sequence[Pair]) -> list[tuple[float, Pair]]:
    times_s = [(motion.touch_s(pair), pair) for pair in pairs]
    return [(time_s, pair) for time_s, pair in times_s if time_s is not None]


def _hold_back(motion: StepMotion, pair: Pair) -> None:
    """Stop each of two touching vehicles whose own motion would press it against the other."""
    gap_m = motion.gap_m(pair, 0.0)
    alone_m = motion.gap_m(pair, motion.step_s, 0.0), motion.gap_m(pair, 0.0, motion.step_s)
    for index, after_m in zip(pair, alone_m, strict=True):
        if after_m < gap_m - _NOTICEABLE_M:
            motion.stop(index, 0.0)
