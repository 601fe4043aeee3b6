"""The high-definition map as a typed model: paper T's table 1, in local metres.

A: lines (lane markings, stop lines, centrelines of lanes). B: points and areas (signs, signals, road marks, guide
lines, crosswalks, protection zones, facilities). C: nodes with the links between them.
Heights are part of every coordinate, so that a map may rise; z = 0 where the ground is flat.
Source: paper T (Sensors 2022), table 1, after the precise road map of Korea's national geographic institute.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, fields
from enum import StrEnum

import numpy as np
import shapely
from numpy.typing import ArrayLike

from contracts import FloatArray, InputError
from contracts.arrays import freeze
from georef.geo_reference import GeoReference

MIN_LINE_M = 1e-3  # a line shorter than a millimetre is a mistake, and has no direction


class MarkingKind(StrEnum):
    """What a painted line along the road parts."""

    EDGE = "edge"
    LANES = "lanes"  # lanes of one direction
    CENTRE = "centre"  # the two directions
    BUS_ONLY = "bus_only"
    BICYCLE = "bicycle"


class Colour(StrEnum):
    """Paint."""

    WHITE = "white"
    YELLOW = "yellow"
    BLUE = "blue"


class StopKind(StrEnum):
    """Why one stops there."""

    SIGNAL = "signal"
    CROSSWALK = "crosswalk"
    YIELD = "yield"


class RoadClass(StrEnum):
    """Whose road it is."""

    HIGHWAY = "highway"
    NATIONAL = "national"
    LOCAL = "local"
    CITY = "city"
    COUNTRY = "country"


class LaneUse(StrEnum):
    """Whom a lane is for."""

    CARS = "cars"
    BICYCLES = "bicycles"
    PEDESTRIANS = "pedestrians"


class SignKind(StrEnum):
    """Families of traffic signs."""

    ATTENTION = "attention"
    REGULATION = "regulation"
    INDICATION = "indication"
    SUBSIDIARY = "subsidiary"


class MarkKind(StrEnum):
    """Signs painted on the road; arrows say where a lane leads."""

    STRAIGHT = "straight"
    LEFT = "left"
    RIGHT = "right"
    STRAIGHT_LEFT = "straight_left"
    STRAIGHT_RIGHT = "straight_right"
    ALL = "all"
    BICYCLE = "bicycle"
    TEXT = "text"


class AreaKind(StrEnum):
    """Painted areas."""

    CROSSWALK = "crosswalk"
    NO_STOPPING = "no_stopping"
    GUIDE = "guide"
    UPHILL = "uphill"


class ZoneKind(StrEnum):
    """For whose protection a zone is closed to autonomous driving."""

    CHILDREN = "children"
    DISABLED = "disabled"
    ELDERLY = "elderly"
    OTHER = "other"


class FacilityKind(StrEnum):
    """What stands beside the road."""

    STREETLAMP = "streetlamp"
    SIGN_POLE = "sign_pole"
    SIGNAL_POLE = "signal_pole"


@dataclass(frozen=True, eq=False)
class Line:
    """A line of the map. points_m: (N, 3) east, north, up; N >= 2, longer than a millimetre."""

    id: str
    points_m: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "points_m", shape=(None, 3))
        if len(self.points_m) < 2 or self.length_m < MIN_LINE_M:
            raise InputError(f"{type(self).__name__} {self.id!r} has no length: give it at least two different points")

    @property
    def length_m(self) -> float:
        """Length on the ground plane, as a map measures it."""
        return float(np.linalg.norm(np.diff(self.points_m[:, :2], axis=0), axis=1).sum())

    @property
    def reached_m(self) -> FloatArray:
        """Length on the ground plane from the start to each point, (N,)."""
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.points_m[:, :2], axis=0), axis=1))])

    def places_m(self, along_m: ArrayLike) -> FloatArray:
        """Points (K, 3) at lengths (K,) from the start; beyond the ends, the ends."""
        asked, reached = np.asarray(along_m, np.float64), self.reached_m
        return np.column_stack([np.interp(asked, reached, self.points_m[:, axis]) for axis in range(3)])


@dataclass(frozen=True, eq=False)
class Point:
    """A point of the map. position_m: (3,) east, north, up."""

    id: str
    position_m: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "position_m", shape=(3,))


@dataclass(frozen=True, eq=False)
class Area:
    """A simple polygon of the map. ring_m: (N, 3) corners, N >= 3, the first one not repeated."""

    id: str
    ring_m: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "ring_m", shape=(None, 3))
        if len(self.ring_m) < 3 or not (ring := shapely.Polygon(self.ring_m[:, :2])).is_valid or ring.area <= 0:
            raise InputError(
                f"{type(self).__name__} {self.id!r} is no simple polygon: its sides cross or enclose nothing"
            )


@dataclass(frozen=True, eq=False)
class LaneMarking(Line):
    """A: paint along the lanes.

    width_m: of the stroke. dash_m, gap_m: 0 for a solid line; the first dash begins where the line does.
    """

    kind: MarkingKind
    colour: Colour = Colour.WHITE
    width_m: float = 0.15
    dash_m: float = 0.0
    gap_m: float = 0.0

    @property
    def dashes_m(self) -> FloatArray:
        """Where each dash begins and ends along the line, (K, 2) metres; none of a solid line."""
        if not self.dash_m:
            return np.empty((0, 2))
        begins = np.arange(0.0, self.length_m - self.dash_m / 2, self.dash_m + self.gap_m)
        return np.column_stack([begins, np.minimum(begins + self.dash_m, self.length_m)])


@dataclass(frozen=True, eq=False)
class StopLine(Line):
    """A: where one stops. width_m: of the stroke."""

    kind: StopKind
    width_m: float = 0.4


@dataclass(frozen=True, eq=False)
class LaneCentreline(Line):
    """A: the middle of a lane, in the direction of travel.

    inner: whether it leads across a junction, where nothing is painted.
    """

    road_class: RoadClass
    width_m: float
    use: LaneUse = LaneUse.CARS
    inner: bool = False


@dataclass(frozen=True, eq=False)
class Sign(Point):
    """B: a traffic sign."""

    kind: SignKind


@dataclass(frozen=True, eq=False)
class Signal(Point):
    """B: a traffic light. lanes: centrelines that it governs."""

    lanes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class RoadMark(Point):
    """B: an arrow or a sign on the road; heading_rad: of travel, counter-clockwise from east."""

    kind: MarkKind
    heading_rad: float


@dataclass(frozen=True, eq=False)
class GuideLine(Line):
    """B: leads left-turning traffic across a junction."""


@dataclass(frozen=True, eq=False)
class PaintedArea(Area):
    """B: crosswalks and other painted areas."""

    kind: AreaKind

    @property
    def sides_m(self) -> tuple[FloatArray, FloatArray]:
        """Of a crosswalk: its right side (M, 3) in the walkers' direction, and its left one back again."""
        half = len(self.ring_m) // 2
        return self.ring_m[:half], self.ring_m[half:]


@dataclass(frozen=True, eq=False)
class ProtectionZone(Area):
    """B: closed to autonomous driving."""

    kind: ZoneKind


@dataclass(frozen=True, eq=False)
class Facility(Point):
    """B: a streetlamp, a pole."""

    kind: FacilityKind


@dataclass(frozen=True, eq=False)
class Node(Point):
    """C: a junction, or where a road ends."""


@dataclass(frozen=True)
class Link:
    """C: a road from one node to another. lanes: its centrelines from right to left."""

    id: str
    from_node: str
    to_node: str
    lanes: tuple[str, ...] = ()


Feature = Line | Point | Area | Link


@dataclass(frozen=True, eq=False)
class HdMap:
    """A map of a few hundred metres around ``geo``'s origin; ids are unique over all its tables.

    Raises InputError for an id given twice and for a node or lane that is named but not there.
    """

    geo: GeoReference
    lane_markings: tuple[LaneMarking, ...] = ()
    stop_lines: tuple[StopLine, ...] = ()
    centrelines: tuple[LaneCentreline, ...] = ()
    signs: tuple[Sign, ...] = ()
    signals: tuple[Signal, ...] = ()
    road_marks: tuple[RoadMark, ...] = ()
    guide_lines: tuple[GuideLine, ...] = ()
    painted_areas: tuple[PaintedArea, ...] = ()
    protection_zones: tuple[ProtectionZone, ...] = ()
    facilities: tuple[Facility, ...] = ()
    nodes: tuple[Node, ...] = ()
    links: tuple[Link, ...] = ()

    def __post_init__(self) -> None:
        for id_, count in Counter(feature.id for feature in self.features()).items():
            if count > 1:
                raise InputError(f"the map has {count} features with the id {id_!r}; each needs its own")
        lanes, nodes = {lane.id for lane in self.centrelines}, {node.id for node in self.nodes}
        for link in self.links:
            _check_known(f"link {link.id!r}", (link.from_node, link.to_node), nodes, "node")
            _check_known(f"link {link.id!r}", link.lanes, lanes, "lane")
        for signal in self.signals:
            _check_known(f"signal {signal.id!r}", signal.lanes, lanes, "lane")

    def features(self) -> Iterator[Feature]:
        """All features, table by table."""
        for field in fields(self)[1:]:
            yield from getattr(self, field.name)


def _check_known(owner: str, names: tuple[str, ...], known: set[str], what: str) -> None:
    if missing := [name for name in names if name not in known]:
        raise InputError(f"{owner} of the map names the {what} {missing[0]!r}, which is not in it")
