"""What traffic signals show: their fixed programs, functions of time alone, and where each head shines from.

Source: SUMO user documentation, "Simulation/Traffic Lights" (version 1.28): letters of links, offsets of programs.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import accumulate

from contracts import FloatArray, InputError
from contracts.arrays import freeze


class Aspect(StrEnum):
    """The lights of a head, from its pole outwards."""

    RED = "red"
    AMBER = "amber"
    GREEN = "green"


Shown = tuple[tuple[Aspect, ...], ...]  # by head, what is lit

_SHOWN_BY = {
    "G": (Aspect.GREEN,),
    "g": (Aspect.GREEN,),
    "y": (Aspect.AMBER,),
    "u": (Aspect.RED, Aspect.AMBER),
    "r": (Aspect.RED,),
    "s": (Aspect.RED,),
}
"""By SUMO's letter, the one that lets most through first; a signal that is off or only warns is dark."""


@dataclass(frozen=True)
class SignalProgram:
    """The fixed program of one junction's signals, over and over.

    phases: how long each lasts, ns, and a letter for each link. offset_ns: when the first one begins.
    """

    phases: tuple[tuple[int, str], ...]
    offset_ns: int = 0

    def __post_init__(self) -> None:
        lasting_ns = [lasts_ns for lasts_ns, _ in self.phases]
        if sum(lasting_ns) <= 0 or min(lasting_ns) < 0:
            raise InputError("a signal's program needs phases that last for some time")

    def letters(self, time_ns: int) -> str:
        """SUMO's letter for each link at a moment."""
        ends_ns = list(accumulate(lasts_ns for lasts_ns, _ in self.phases))
        return self.phases[bisect_right(ends_ns, (time_ns - self.offset_ns) % ends_ns[-1])][1]

    def shown(self, links: Sequence[int], time_ns: int) -> tuple[Aspect, ...]:
        """What one head shows to these links together: green if one of them may go."""
        letters = self.letters(time_ns)
        present = {letters[link] for link in links}
        return next((lit for letter, lit in _SHOWN_BY.items() if letter in present), ())


@dataclass(frozen=True, eq=False)
class SignalHead:
    """One head, which shows the same on its face and on its back, so that cameras over the junction see it, too.

    lights_m: (3, 3) middles of its lights, in the order of ``Aspect``. facing: (3,) level unit vector out of its face.
    links: that it governs. program: None where it is not fixed: such a head stays dark.
    """

    lights_m: FloatArray
    facing: FloatArray
    links: tuple[int, ...]
    program: SignalProgram | None

    def __post_init__(self) -> None:
        freeze(self, "lights_m", shape=(len(Aspect), 3))
        freeze(self, "facing", shape=(3,))

    def shown(self, time_ns: int) -> tuple[Aspect, ...]:
        """What it shows at a moment."""
        return () if self.program is None else self.program.shown(self.links, time_ns)
