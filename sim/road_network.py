"""A SUMO road network as its built ``.net.xml`` file says it. Nothing is simulated.

Source: SUMO user documentation, "SUMO Road Networks" (version 1.28).
"""

import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from contracts import FloatArray, InputError
from contracts.arrays import freeze
from georef.geo_reference import GeoReference
from sim.signals import SignalProgram

CARS, BICYCLES, PEDESTRIANS = "passenger", "bicycle", "pedestrian"  # SUMO's vehicle classes that Gantry tells apart


@dataclass(frozen=True, eq=False)
class RoadLane:
    """One lane: id, middle line (N, 3) in the direction of travel, width, and which of the three classes may use it."""

    id: str
    shape_m: FloatArray
    width_m: float
    users: frozenset[str]

    def __post_init__(self) -> None:
        freeze(self, "shape_m", shape=(None, 3))


@dataclass(frozen=True, eq=False)
class RoadEdge:
    """Lanes side by side, the rightmost first. function: ``normal``, ``internal``, ``crossing`` or ``walkingarea``."""

    id: str
    function: str
    from_node: str
    to_node: str
    road_type: str
    lanes: tuple[RoadLane, ...]


@dataclass(frozen=True, eq=False)
class Junction:
    """Where edges meet. kind: SUMO's (``traffic_light``, ``priority``, ``zipper``, ``dead_end``, ...)."""

    id: str
    kind: str
    position_m: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "position_m", shape=(3,))


@dataclass(frozen=True)
class Connection:
    """From one lane over a junction to another.

    via: the lane that leads across, or "". direction: ``s``, ``l``, ``r``, ``t``, ...; state: ``M`` has right of way,
    ``m`` waits; signal: the light that governs it, or "", and link: under which number, or -1.
    """

    from_lane: str
    to_lane: str
    via: str
    direction: str
    state: str
    signal: str
    link: int


@dataclass(frozen=True, eq=False)
class RoadNetwork:
    """A whole network. path: of its file, for SUMO; geo: where its metres lie on the globe; signals: fixed programs."""

    path: Path
    geo: GeoReference
    edges: dict[str, RoadEdge]
    junctions: dict[str, Junction]
    connections: tuple[Connection, ...]
    signals: dict[str, SignalProgram]

    @cached_property
    def lanes(self) -> dict[str, RoadLane]:
        """Every lane by its id."""
        return {lane.id: lane for edge in self.edges.values() for lane in edge.lanes}

    @property
    def roads(self) -> tuple[RoadEdge, ...]:
        """The edges between junctions, in the file's order."""
        return tuple(edge for edge in self.edges.values() if edge.function == "normal")


def read_network(path: Path) -> RoadNetwork:
    """Read a ``.net.xml``. Raises InputError naming the file and what is wrong with it."""
    try:
        root = ElementTree.parse(path).getroot()
    except OSError as error:
        raise InputError(f"cannot read the network {path}: {error.strerror}") from error
    except ElementTree.ParseError as error:
        raise InputError(f"{path} is no XML: {error}") from error
    if root.tag != "net":
        raise InputError(f"{path} is no SUMO network: its outermost element is <{root.tag}>, not <net>; build it first")
    try:
        edges = {node.attrib["id"]: _edge(node) for node in root.iter("edge")}
        junctions = {
            node.attrib["id"]: Junction(node.attrib["id"], node.attrib["type"], _position(node))
            for node in root.iter("junction")
            if node.attrib["type"] != "internal"
        }
        connections = tuple(_connection(node) for node in root.iter("connection"))
        network = RoadNetwork(path, _geo(root), edges, junctions, connections, _signals(root))
    except KeyError as error:
        raise InputError(f"{path} lacks the attribute {error}") from error
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    if not network.roads:
        raise InputError(f"{path} has no roads")
    return network


def _edge(node: ElementTree.Element) -> RoadEdge:
    own = node.attrib
    lanes = sorted(node.iter("lane"), key=lambda lane: int(lane.attrib["index"]))
    return RoadEdge(
        own["id"],
        own.get("function", "normal"),
        own.get("from", ""),
        own.get("to", ""),
        own.get("type", ""),
        tuple(_lane(lane) for lane in lanes),
    )


def _lane(node: ElementTree.Element) -> RoadLane:
    own = node.attrib
    return RoadLane(own["id"], _shape(own["shape"]), float(own.get("width", "3.2")), _users(own))


def _users(own: dict[str, str]) -> frozenset[str]:
    known = frozenset((CARS, BICYCLES, PEDESTRIANS))
    if "allow" in own:
        return known & frozenset(own["allow"].split()) if own["allow"] != "all" else known
    return known - frozenset(own.get("disallow", "").split())


def _shape(text: str) -> FloatArray:
    """(N, 3); a height that is not written is 0."""
    points = [[float(number) for number in point.split(",")] for point in text.split()]
    return np.array([(*point, 0.0)[:3] for point in points])


def _position(node: ElementTree.Element) -> FloatArray:
    return np.array([float(node.attrib.get(axis, "0")) for axis in "xyz"])


def _connection(node: ElementTree.Element) -> Connection:
    own = node.attrib
    return Connection(
        f"{own['from']}_{own['fromLane']}",
        f"{own['to']}_{own['toLane']}",
        own.get("via", ""),
        own["dir"],
        own["state"],
        own.get("tl", ""),
        int(own.get("linkIndex", "-1")),
    )


def _signals(root: ElementTree.Element) -> dict[str, SignalProgram]:
    """The programs that do not depend on traffic, by the signal's id."""
    return {
        node.attrib["id"]: SignalProgram(
            tuple((_ns(phase.attrib["duration"]), phase.attrib["state"]) for phase in node.iter("phase")),
            _ns(node.attrib.get("offset", "0")),
        )
        for node in root.iter("tlLogic")
        if node.attrib["type"] == "static"
    }


def _ns(seconds: str) -> int:
    return round(float(seconds) * 1e9)


def _geo(root: ElementTree.Element) -> GeoReference:
    """The origin; the network must have been made with Gantry's projection and without an offset."""
    location = root.find("location")
    if location is None:
        raise ValueError("has no <location>, so it lies nowhere on the globe")
    if any(float(number) != 0.0 for number in location.attrib["netOffset"].split(",")):
        raise ValueError("its netOffset is not 0,0: build it with --offset.disable-normalization true")
    found = re.match(r"\+proj=tmerc \+lat_0=(\S+) \+lon_0=(\S+) \+k=1 \+x_0=0 ", location.attrib["projParameter"])
    if not found:
        raise ValueError(
            "its projParameter must be +proj=tmerc +lat_0=LATITUDE +lon_0=LONGITUDE +k=1 +x_0=0 +y_0=0 +ellps=WGS84"
        )
    return GeoReference(float(found[1]), float(found[2]))
