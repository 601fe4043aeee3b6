"""What an author puts round the track: the floor's look, things that lie or stand about, bridges, highlights."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from contracts import FloatArray, InputError
from sim.floor import FloorSpec
from sim.highlights import HighlightSpec
from sim.lights import Rgb
from sim.solids import Solid

Shape = Literal["box", "cylinder"]
SHEET_M = 0.003  # what is no higher may lie under the rails; it casts no shadow

_CYLINDER_CORNERS = 16
_MAX_REACH_M = 100.0


@dataclass(frozen=True)
class ObjectSpec:
    """A thing of one matte colour that does not move.

    at_m: x, y of its centre. heading_deg: of its length, counter-clockwise from east.
    size_m: length, width, height. A sheet of paper is a box that is 1 mm high; what is higher than 3 mm must keep clear
        of the track, below the roofs of the vehicles.
    srgb: red, green, blue, 0 to 255.
    bottom_m: height of its underside.
    shape: ``"cylinder"`` is an upright prism of sixteen sides in the ellipse of length and width.
    """

    at_m: tuple[float, float]
    size_m: tuple[float, float, float]
    srgb: tuple[int, int, int]
    heading_deg: float = 0.0
    bottom_m: float = 0.0
    shape: Shape = "box"

    def __post_init__(self) -> None:
        _check_colour("srgb", self.srgb)
        _check_place("at_m", self.at_m)
        if not all(0 < x <= _MAX_REACH_M for x in self.size_m):
            raise InputError(f"size_m = {list(self.size_m)} must be lengths in (0, {_MAX_REACH_M:.0f}] m")
        if not 0 <= self.bottom_m <= _MAX_REACH_M:
            raise InputError(f"bottom_m = {self.bottom_m} must lie in [0, {_MAX_REACH_M:.0f}]")
        if not math.isfinite(self.heading_deg):
            raise InputError(f"heading_deg = {self.heading_deg} must be finite")

    @property
    def solid(self) -> Solid:
        """Its shape in the world."""
        length, width, height = self.size_m
        outline = outline_of(self.shape, self.at_m, math.radians(self.heading_deg), length, width)
        return Solid(outline, self.bottom_m, self.bottom_m + height)

    @property
    def rgb(self) -> Rgb:
        """Its colour, 0 to 1."""
        red, green, blue = self.srgb
        return red / 255, green / 255, blue / 255


@dataclass(frozen=True)
class BridgeSpec:
    """A bridge over the track: a deck between two walls.

    at_m: x, y of its middle. heading_deg: along the deck, so across the track beneath it.
    span_m: clear width between the walls. width_m: of the deck. clear_m: height of its underside.
    srgb: red, green, blue, 0 to 255.
    """

    at_m: tuple[float, float]
    heading_deg: float
    span_m: float = 0.16
    width_m: float = 0.10
    clear_m: float = 0.10
    srgb: tuple[int, int, int] = (120, 112, 104)

    def __post_init__(self) -> None:
        _check_colour("srgb", self.srgb)
        _check_place("at_m", self.at_m)
        for name in ("span_m", "width_m", "clear_m"):
            if not 0 < getattr(self, name) <= _MAX_REACH_M:
                raise InputError(f"{name} = {getattr(self, name)} must lie in (0, {_MAX_REACH_M:.0f}]")
        if not math.isfinite(self.heading_deg):
            raise InputError(f"heading_deg = {self.heading_deg} must be finite")

    @property
    def parts(self) -> tuple[ObjectSpec, ...]:
        """Deck and walls."""
        thick = 0.012
        along = np.array([math.cos(math.radians(self.heading_deg)), math.sin(math.radians(self.heading_deg))])

        def part(offset_m: float, size_m: tuple[float, float, float], bottom_m: float) -> ObjectSpec:
            x, y = np.array(self.at_m) + offset_m * along
            return ObjectSpec((float(x), float(y)), size_m, self.srgb, self.heading_deg, bottom_m)

        offset = (self.span_m + thick) / 2
        walls = [part(side * offset, (thick, self.width_m, self.clear_m), 0.0) for side in (-1, 1)]
        return (part(0.0, (self.span_m + 2 * thick, self.width_m, thick), self.clear_m), *walls)


@dataclass(frozen=True)
class Surroundings:
    """All that an author puts round the track of one plant."""

    floor: FloorSpec = field(default_factory=FloorSpec)
    objects: tuple[ObjectSpec, ...] = ()
    bridges: tuple[BridgeSpec, ...] = ()
    highlights: tuple[HighlightSpec, ...] = ()

    @property
    def things(self) -> tuple[ObjectSpec, ...]:
        """Objects and the parts of bridges."""
        return (*self.objects, *(part for bridge in self.bridges for part in bridge.parts))


def outline_of(
    shape: Shape, at_m: tuple[float, float], heading_rad: float, length_m: float, width_m: float
) -> FloatArray:
    """The outline (C, 2) of a shape on the ground, counter-clockwise."""
    corners = np.array([[1, -1], [1, 1], [-1, 1], [-1, -1]], dtype=np.float64)
    if shape == "cylinder":
        angle = np.arange(_CYLINDER_CORNERS) * (2 * np.pi / _CYLINDER_CORNERS)
        corners = np.column_stack([np.cos(angle), np.sin(angle)])
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return np.asarray(corners * (length_m / 2, width_m / 2) @ np.array([[c, s], [-s, c]]) + at_m)


def blocks_track(thing: ObjectSpec, track_m: FloatArray, *, half_width_m: float, height_m: float) -> bool:
    """Whether vehicles of that half width and height would run into ``thing`` on a track (N, 2)."""
    solid = thing.solid
    passed_under = solid.bottom_m > height_m
    return not passed_under and solid.top_m > SHEET_M and bool((solid.gap_m(track_m) < half_width_m).any())


def _check_colour(name: str, srgb: tuple[int, int, int]) -> None:
    if not all(0 <= level <= 255 for level in srgb):
        raise InputError(f"{name} = {list(srgb)} must be three levels from 0 to 255")


def _check_place(name: str, at_m: tuple[float, float]) -> None:
    if not all(math.isfinite(x) for x in at_m):
        raise InputError(f"{name} = {list(at_m)} must be finite")
