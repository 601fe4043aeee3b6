"""The plant: sections of track and what joins, crosses, ends and marks them. Built by ``rail.build``."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from contracts import InputError, SwitchState
from rail.curves import Curve, Pose2


class End(StrEnum):
    """The two ends of a section."""

    START = "start"
    END = "end"


class Side(StrEnum):
    """Left or right of a direction."""

    LEFT = "left"
    RIGHT = "right"


@dataclass(frozen=True)
class Port:
    """One end of a section, where track goes on or stops."""

    section: str
    end: End

    def __str__(self) -> str:
        return f"{self.section}.{self.end}"


@dataclass(frozen=True)
class Section:
    """A piece of track without branches; its offsets run from ``start`` to ``end``."""

    id: str
    curve: Curve

    @property
    def length_m(self) -> float:
        """Length along the track."""
        return self.curve.length_m

    def pose_out_of(self, end: End) -> Pose2:
        """Pose of a vehicle that is just leaving the section through ``end``."""
        return self.curve.end if end is End.END else self.curve.start.reversed()


@dataclass(frozen=True)
class Switch:
    """Three section ends that meet at the toe.

    stem, straight, diverging: the ports; the switch joins the stem to one branch.
    toe: pose at the toe, looking from the stem into the branches (the facing direction).
    diverging_side: on which side of the straight branch the diverging one lies, looking in the facing direction.
    spot_m: world x, y of the white spot on the notch, beside the stem.
    spot_state: the state in which the spot shows; it is hidden in the other (see ``rail.switch_status``).
    """

    id: str
    stem: Port
    straight: Port
    diverging: Port
    toe: Pose2
    diverging_side: Side
    spot_m: tuple[float, float]
    spot_state: SwitchState

    @property
    def ports(self) -> tuple[Port, Port, Port]:
        """Stem, straight, diverging."""
        return self.stem, self.straight, self.diverging

    def branch(self, state: SwitchState) -> Port | None:
        """The branch that the stem leads to; None while it moves or where the state is unknown."""
        return {SwitchState.STRAIGHT: self.straight, SwitchState.DIVERGING: self.diverging}.get(state)

    def other_side(self, port: Port, state: SwitchState) -> Port | None:
        """Where track that leaves its section through ``port`` goes on; None if the switch lies against it."""
        branch = self.branch(state)
        if port == self.stem:
            return branch
        return self.stem if port == branch else None


@dataclass(frozen=True)
class Crossing:
    """Two sections that cross on one level without a connection; offsets of the crossing point on either."""

    id: str
    sections: tuple[str, str]
    offsets_m: tuple[float, float]
    position_m: tuple[float, float]


@dataclass(frozen=True)
class BufferStop:
    """The end of the line; ``pose`` looks at the buffer."""

    id: str
    port: Port
    pose: Pose2


@dataclass(frozen=True)
class Balise:
    """A mark in the track that tells a passing vehicle its 16-bit position code."""

    code: int
    section: str
    offset_m: float

    @property
    def name(self) -> str:
        """The code as four hexadecimal digits, as in events."""
        return f"{self.code:04x}"


@dataclass(frozen=True, repr=False)
class Plant:
    """A whole model railway; consistent by construction when made by ``rail.build.build_plant``.

    joints: for each port that simply goes on into another, that port (both ways).
    bounds_m: x_min, y_min, x_max, y_max of the track's centre lines.
    """

    name: str
    sections: Mapping[str, Section]
    switches: Mapping[str, Switch]
    crossings: Mapping[str, Crossing]
    buffers: Mapping[str, BufferStop]
    balises: tuple[Balise, ...]
    joints: Mapping[Port, Port]
    bounds_m: tuple[float, float, float, float]

    def __repr__(self) -> str:
        return f"Plant({self.name!r})"

    @property
    def length_m(self) -> float:
        """Metres of rail in all sections."""
        return sum(section.length_m for section in self.sections.values())

    def section(self, name: str) -> Section:
        """The section of that name; InputError that lists those there are."""
        return self.sections[known(name, self.sections, f"plant {self.name!r}: section")]

    def switch(self, name: str) -> Switch:
        """The switch of that name; InputError that lists those there are."""
        return self.switches[known(name, self.switches, f"plant {self.name!r}: switch")]

    @cached_property
    def switch_at(self) -> Mapping[Port, Switch]:
        """The switch to which a port belongs."""
        return {port: switch for switch in self.switches.values() for port in switch.ports}

    @cached_property
    def buffer_at(self) -> Mapping[Port, BufferStop]:
        """The buffer stop that closes a port."""
        return {buffer.port: buffer for buffer in self.buffers.values()}

    @cached_property
    def balises_of(self) -> Mapping[str, tuple[Balise, ...]]:
        """The balises of each section, by rising offset."""
        by_offset = sorted(self.balises, key=lambda balise: balise.offset_m)
        return {name: tuple(b for b in by_offset if b.section == name) for name in self.sections}


def known(name: str, names: Iterable[str], what: str) -> str:
    """``name`` if it is one of ``names``; else InputError that lists them."""
    names = list(names)
    if name not in names:
        raise InputError(f"{what} {name!r} is unknown; there are {', '.join(names) or 'none'}")
    return name
