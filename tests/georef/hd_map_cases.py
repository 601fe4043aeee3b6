"""Maps to test with: drawn by Hypothesis, and one by hand that has every table."""

import numpy as np
from hypothesis import strategies as st

from georef.geo_reference import GeoReference
from georef.hd_map import (
    AreaKind,
    Colour,
    Facility,
    FacilityKind,
    GuideLine,
    HdMap,
    LaneCentreline,
    LaneMarking,
    LaneUse,
    Link,
    MarkingKind,
    MarkKind,
    Node,
    PaintedArea,
    ProtectionZone,
    RoadClass,
    RoadMark,
    Sign,
    Signal,
    SignKind,
    StopKind,
    StopLine,
    ZoneKind,
)

PANGYO = GeoReference(37.398, 127.112)
SQUARE = [(0, 0, 0.5), (4, 0, 0.5), (4, 3, 0.5), (0, 3, 0.5)]


def full_map(geo: GeoReference = PANGYO) -> HdMap:
    """One feature of each table."""
    line = [(-30.0, 1.5, 0.0), (10.0, 1.5, 0.8), (40.0, 20.0, 1.2)]
    return HdMap(
        geo,
        lane_markings=(LaneMarking("m", line, MarkingKind.CENTRE, Colour.YELLOW, 0.12, 3.0, 5.0),),
        stop_lines=(StopLine("stop", line[:2], StopKind.SIGNAL),),
        centrelines=(LaneCentreline("l", line, RoadClass.CITY, 3.25), _cycle_lane(line)),
        signs=(Sign("sign", (1, 2, 3), SignKind.REGULATION),),
        signals=(Signal("light", (4, 5, 6), ("l",)),),
        road_marks=(RoadMark("arrow", (0, 0, 0), MarkKind.STRAIGHT_LEFT, -1.25),),
        guide_lines=(GuideLine("guide", line),),
        painted_areas=(PaintedArea("zebra", SQUARE, AreaKind.CROSSWALK),),
        protection_zones=(ProtectionZone("school", SQUARE, ZoneKind.CHILDREN),),
        facilities=(Facility("lamp", (9, 9, 0), FacilityKind.STREETLAMP),),
        nodes=(Node("a", (-30, 0, 0)), Node("b", (40, 20, 1))),
        links=(Link("ab", "a", "b", ("l", "bike")),),
    )


def _cycle_lane(line: list[tuple[float, float, float]]) -> LaneCentreline:
    return LaneCentreline("bike", np.add(line, (0, -3, 0)), RoadClass.CITY, 1.5, LaneUse.BICYCLES)


@st.composite
def centrelines(draw: st.DrawFn, name: str = "lane") -> LaneCentreline:
    """A lane that never turns back on itself: corners at least 2 m apart, each turn below 60 degrees."""
    heading, corner = draw(st.floats(-np.pi, np.pi)), np.array([draw(st.floats(-80, 80)), draw(st.floats(-80, 80))])
    points = [corner]
    for _ in range(draw(st.integers(1, 5))):
        points.append(points[-1] + draw(st.floats(2, 40)) * np.array([np.cos(heading), np.sin(heading)]))
        heading += draw(st.floats(-np.pi / 3, np.pi / 3))
    return LaneCentreline(name, np.column_stack([points, np.zeros(len(points))]), RoadClass.CITY, 3.0)
