"""What an author says about a plant: the content of a plant file, not yet checked as a whole."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite, radians

from contracts import InputError
from rail.curves import Bend, Pose2
from rail.pieces import line, shift, turn
from rail.plant import Side


@dataclass(frozen=True)
class PlaceSpec:
    """A pose in the world, in degrees."""

    x_m: float
    y_m: float
    heading_deg: float

    def __post_init__(self) -> None:
        if not all(map(isfinite, (self.x_m, self.y_m, self.heading_deg))):
            raise InputError(
                f"a pose at ({self.x_m}, {self.y_m}) m, {self.heading_deg} deg is none; give finite numbers"
            )

    @property
    def pose(self) -> Pose2:
        """The same in radians."""
        return Pose2(self.x_m, self.y_m, radians(self.heading_deg))


@dataclass(frozen=True)
class PieceSpec:
    """One piece of a section; exactly one of ``line_m``, ``turn_deg``, ``shift_m`` and ``close``.

    line_m: straight.
    turn_deg, radius_m, ease_m: an arc, to the left if positive; with clothoids of ``ease_m`` within it at both ends.
    shift_m, radius_m: a pair of arcs on to the parallel track so far to the left.
    close: two arcs (in line: a straight) from here exactly on to the port ``to``; the last piece.
    """

    line_m: float | None = None
    turn_deg: float | None = None
    shift_m: float | None = None
    close: bool = False
    radius_m: float | None = None
    ease_m: float = 0.0

    def __post_init__(self) -> None:
        kinds = [self.line_m is not None, self.turn_deg is not None, self.shift_m is not None, self.close]
        if sum(kinds) != 1:
            raise InputError("a piece needs exactly one of line_m, turn_deg, shift_m and close = true")
        curved = self.turn_deg is not None or self.shift_m is not None
        if curved != (self.radius_m is not None):
            raise InputError("radius_m belongs to turn_deg and shift_m, which both need it")
        if self.ease_m and self.turn_deg is None:
            raise InputError("ease_m belongs to turn_deg")

    def bends(self) -> tuple[Bend, ...]:
        """The piece as bends; for every kind but ``close``, which depends on where it begins."""
        if self.line_m is not None:
            return line(self.line_m)
        assert self.radius_m is not None
        if self.turn_deg is not None:
            return turn(radians(self.turn_deg), self.radius_m, self.ease_m)
        assert self.shift_m is not None
        return shift(self.shift_m, self.radius_m)


@dataclass(frozen=True)
class SectionSpec:
    """A section: where it begins, its pieces, where it leads.

    at: pose of its start; or
    after: the port that its start continues, such as ``"north.end"``.
    to: the port that its end leads to. ``after`` and ``to`` join the two ports unless a switch joins them.
    """

    pieces: tuple[PieceSpec, ...]
    at: PlaceSpec | None = None
    after: str | None = None
    to: str | None = None


@dataclass(frozen=True)
class SwitchSpec:
    """A switch between three ports; the notch stands on ``spot_side`` of the stem (default: away from the branch)."""

    stem: str
    straight: str
    diverging: str
    spot_side: Side | None = None


@dataclass(frozen=True)
class CrossingSpec:
    """Two sections that cross on one level."""

    sections: tuple[str, str]


@dataclass(frozen=True)
class BufferSpec:
    """A buffer stop at a port."""

    port: str


@dataclass(frozen=True)
class BaliseSpec:
    """A balise with its 16-bit code on a section."""

    code: int
    section: str
    offset_m: float


@dataclass(frozen=True)
class PlantSpec:
    """A plant as its file says it; ``rail.build.build_plant`` checks it and makes the plant.

    min_radius_m: least radius of track; the vehicles' axles need 0.35 m.
    """

    title: str
    section: Mapping[str, SectionSpec]
    min_radius_m: float = 0.35
    switch: Mapping[str, SwitchSpec] = field(default_factory=dict)
    crossing: Mapping[str, CrossingSpec] = field(default_factory=dict)
    buffer: Mapping[str, BufferSpec] = field(default_factory=dict)
    balise: tuple[BaliseSpec, ...] = ()
