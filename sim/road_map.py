"""The HD map of a road network, as a surveyor would draw it: the road's true lines, each feature a little off.

The error of the survey is one shift for each feature, so that lines stay straight and areas keep their shape, and what
is calibrated against the map sees a map that is not the truth.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

import numpy as np

from contracts import FloatArray, InputError
from georef.hd_map import (
    Area,
    AreaKind,
    Colour,
    Facility,
    FacilityKind,
    GuideLine,
    HdMap,
    LaneCentreline,
    LaneMarking,
    LaneUse,
    Line,
    Link,
    MarkingKind,
    MarkKind,
    Node,
    PaintedArea,
    Point,
    RoadClass,
    RoadMark,
    Sign,
    Signal,
    SignKind,
    StopKind,
    StopLine,
)
from sim.offset_lines import at_end, offset_line, point_before_end
from sim.road_network import BICYCLES, CARS, Connection, RoadEdge, RoadLane, RoadNetwork
from sim.streams import stream

DASH_M, GAP_M = 3.0, 5.0  # lane lines in Korean cities
ARROW_BEFORE_END_M = 12.0
LAMP_EVERY_M, LAMP_BESIDE_M, LAMP_BEFORE_END_M = 30.0, 1.0, 4.0  # the first lights the junction
STOP_BEFORE_END_M = 0.8  # clear of the crosswalk, which begins where the lanes end
SIGNAL_HEIGHT_M, SIGN_HEIGHT_M = 5.0, 2.5
_ARROWS = {"s": MarkKind.STRAIGHT, "l": MarkKind.LEFT, "r": MarkKind.RIGHT}
_ARROWS |= {"ls": MarkKind.STRAIGHT_LEFT, "rs": MarkKind.STRAIGHT_RIGHT, "lrs": MarkKind.ALL}
_Shifted = TypeVar("_Shifted", bound=Line | Point | Area)


def map_of_network(network: RoadNetwork, *, survey_sigma_m: float = 0.0, seed: int = 0) -> HdMap:
    """The map of ``network``.

    survey_sigma_m: standard deviation of each feature's shift, east and north each; heights are exact.
    seed: decides the shifts; a feature's own does not depend on which others there are.
    """
    if not (math.isfinite(survey_sigma_m) and survey_sigma_m >= 0):
        raise InputError(f"survey_sigma_m = {survey_sigma_m} must be finite and not negative")

    def surveyed(features: Iterable[_Shifted]) -> tuple[_Shifted, ...]:
        return tuple(_shifted(feature, survey_sigma_m, seed) for feature in features)

    return HdMap(
        network.geo,
        lane_markings=surveyed(_markings(network)),
        stop_lines=surveyed(_stop_lines(network)),
        centrelines=surveyed(_centrelines(network)),
        signs=surveyed(_signs(network)),
        signals=surveyed(_signals(network)),
        road_marks=surveyed(_arrows(network)),
        guide_lines=surveyed(_guide_lines(network)),
        painted_areas=surveyed(_crosswalks(network)),
        facilities=surveyed(_lamps(network)),
        nodes=surveyed(Node(f"node/{junction.id}", junction.position_m) for junction in network.junctions.values()),
        links=tuple(
            Link(f"link/{r.id}", f"node/{r.from_node}", f"node/{r.to_node}", tuple(lane.id for lane in r.lanes))
            for r in network.roads
        ),
    )


def _shifted(feature: _Shifted, sigma_m: float, seed: int) -> _Shifted:
    if sigma_m == 0.0:
        return feature
    shift = np.append(stream(seed, f"survey/{feature.id}").normal(0.0, sigma_m, 2), 0.0)
    name = "points_m" if isinstance(feature, Line) else "ring_m" if isinstance(feature, Area) else "position_m"
    return replace(feature, **{name: getattr(feature, name) + shift})


def _is_driven(lane: RoadLane) -> bool:
    return bool(lane.users & {CARS, BICYCLES})


def _driven(road: RoadEdge) -> list[RoadLane]:
    """Lanes on the carriageway, the rightmost first."""
    return [lane for lane in road.lanes if _is_driven(lane)]


def _centrelines(network: RoadNetwork) -> Iterator[LaneCentreline]:
    classes = {road.id: road.road_type for road in network.roads}
    by_via = {c.via: classes.get(c.from_lane.rsplit("_", 1)[0], "") for c in network.connections if c.via}
    for edge in network.edges.values():
        if edge.function in ("normal", "internal"):
            for lane in edge.lanes:
                use = LaneUse.CARS if CARS in lane.users else LaneUse.PEDESTRIANS
                use = LaneUse.BICYCLES if lane.users == {BICYCLES} else use
                name = edge.road_type or by_via.get(lane.id, "")
                road_class = RoadClass(name) if name in list(RoadClass) else RoadClass.CITY
                inner = edge.function == "internal"
                yield LaneCentreline(lane.id, lane.shape_m, road_class, lane.width_m, use, inner)


def _markings(network: RoadNetwork) -> Iterator[LaneMarking]:
    opposite = {(road.to_node, road.from_node): road for road in network.roads}
    for road in network.roads:
        lanes = _driven(road)
        right = offset_line(lanes[0].shape_m, -lanes[0].width_m / 2)
        yield LaneMarking(f"edge/{road.id}", right, MarkingKind.EDGE)
        for a, b in pairwise(lanes):
            line = offset_line(a.shape_m, a.width_m / 2)
            if CARS in a.users & b.users:
                yield LaneMarking(f"lanes/{a.id}", line, MarkingKind.LANES, dash_m=DASH_M, gap_m=GAP_M)
            else:
                yield LaneMarking(f"bicycle/{a.id}", line, MarkingKind.BICYCLE)
        left = offset_line(lanes[-1].shape_m, lanes[-1].width_m / 2)
        other = opposite.get((road.from_node, road.to_node))
        if other is None:
            yield LaneMarking(f"left/{road.id}", left, MarkingKind.EDGE)
        elif road.id < other.id:
            yield LaneMarking(f"centre/{road.id}", left, MarkingKind.CENTRE, Colour.YELLOW)


def _waits(network: RoadNetwork, road: RoadEdge) -> StopKind | None:
    """Why traffic stops at the end of ``road``; None where it does not."""
    leaving = [c for c in _leaving(network, road) if _is_driven(network.lanes[c.from_lane])]
    if any(c.signal for c in leaving):
        return StopKind.SIGNAL
    junction = network.junctions[road.to_node]
    return StopKind.YIELD if junction.kind == "priority" and any(c.state == "m" for c in leaving) else None


def _leaving(network: RoadNetwork, road: RoadEdge) -> list[Connection]:
    own = {lane.id for lane in road.lanes}
    return [c for c in network.connections if c.from_lane in own]


def _stop_lines(network: RoadNetwork) -> Iterator[StopLine]:
    for road in network.roads:
        if kind := _waits(network, road):
            lanes = _driven(road)
            right, left = (
                offset_line(lane.shape_m, side * lane.width_m / 2) for lane, side in ((lanes[0], -1), (lanes[-1], 1))
            )
            ends = [point_before_end(side, STOP_BEFORE_END_M)[0] for side in (right, left)]
            yield StopLine(f"stop/{road.id}", np.array(ends), kind)


def _crosswalks(network: RoadNetwork) -> Iterator[PaintedArea]:
    for edge in network.edges.values():
        if edge.function == "crossing":
            lane = edge.lanes[0]
            right, left = (offset_line(lane.shape_m, side * lane.width_m / 2) for side in (-1.0, 1.0))
            yield PaintedArea(f"crosswalk/{edge.id}", np.concatenate([right, left[::-1]]), AreaKind.CROSSWALK)


def _kerb_at_end(road: RoadEdge, height_m: float = 0.0) -> FloatArray:
    lane = _driven(road)[0]
    foot = at_end(lane.shape_m, -lane.width_m / 2 - LAMP_BESIDE_M)
    return np.array([foot[0], foot[1], foot[2] + height_m])


def _signals(network: RoadNetwork) -> Iterator[Signal]:
    for road in network.roads:
        if _waits(network, road) is StopKind.SIGNAL:
            lanes = tuple(lane.id for lane in _driven(road))
            yield Signal(f"signal/{road.id}", _kerb_at_end(road, SIGNAL_HEIGHT_M), lanes)


def _signs(network: RoadNetwork) -> Iterator[Sign]:
    for road in network.roads:
        if _waits(network, road) is StopKind.YIELD:
            yield Sign(f"sign/{road.id}", _kerb_at_end(road, SIGN_HEIGHT_M), SignKind.REGULATION)


def _arrows(network: RoadNetwork) -> Iterator[RoadMark]:
    for road in network.roads:
        leaving = _leaving(network, road)
        for lane in _driven(road):
            ways = "".join(sorted({c.direction for c in leaving if c.from_lane == lane.id}))
            if CARS in lane.users and ways in _ARROWS and _waits(network, road):
                position, heading_rad = point_before_end(lane.shape_m, ARROW_BEFORE_END_M)
                yield RoadMark(f"arrow/{lane.id}", position, _ARROWS[ways], heading_rad)


def _guide_lines(network: RoadNetwork) -> Iterator[GuideLine]:
    for c in network.connections:
        if c.signal and c.direction == "l" and c.via in network.lanes and CARS in network.lanes[c.via].users:
            yield GuideLine(f"guide/{c.via}", network.lanes[c.via].shape_m)


def _lamps(network: RoadNetwork) -> Iterator[Facility]:
    for road in network.roads:
        outer = road.lanes[0]
        kerb = offset_line(outer.shape_m, -outer.width_m / 2 - LAMP_BESIDE_M)
        length = float(np.linalg.norm(np.diff(kerb[:, :2], axis=0), axis=1).sum())
        for k in range(max(1, int(length / LAMP_EVERY_M))):
            position, _ = point_before_end(kerb, LAMP_BEFORE_END_M + k * LAMP_EVERY_M)
            yield Facility(f"lamp/{road.id}/{k}", position, FacilityKind.STREETLAMP)
        if _waits(network, road) is StopKind.SIGNAL:
            yield Facility(f"pole/{road.id}", _kerb_at_end(road), FacilityKind.SIGNAL_POLE)
