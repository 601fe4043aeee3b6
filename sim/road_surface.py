"""What lies on the ground: asphalt, pavement, grass, and the paint of the map, all thin geometry.

Paint lies exactly at the road's own height, where the truth has the wheels; the surfaces below it sink a little, so
that no two lie in one plane.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from contracts import FloatArray
from georef.hd_map import AreaKind, Colour, HdMap, Line, MarkKind, PaintedArea, RoadMark
from sim.meshes import Mesh
from sim.offset_lines import offset_line
from sim.road_network import BICYCLES, CARS, RoadLane, RoadNetwork
from sim.road_scene import PartKind, StillPart
from sim.terrain import Terrain

ROAD_BELOW_M, PAVEMENT_BELOW_M, GROUND_BELOW_M = 0.006, 0.010, 0.050

_ASPHALT, _PAVEMENT, _GRASS, _KERB = (0.30, 0.30, 0.31), (0.56, 0.54, 0.51), (0.36, 0.42, 0.24), (0.66, 0.65, 0.62)
_WHITE, _YELLOW, _BLUE = (0.88, 0.88, 0.86), (0.87, 0.68, 0.12), (0.25, 0.40, 0.75)
_PAINT = {Colour.WHITE: _WHITE, Colour.YELLOW: _YELLOW, Colour.BLUE: _BLUE}
_SHOULDER_M = 0.35  # asphalt beyond the outer lines
_KERB_M = 0.25
_GORE_M = 6.0  # what is no wider between the lanes of a junction is asphalt, too
_GROUND_STEP_M, _GROUND_MARGIN_M = 10.0, 260.0  # beyond the network, to where the horizon hides the end
_SIDE_M = 4.0  # longest side of a surface's outline: heights follow the terrain
_GUIDE_DASH_M, _GUIDE_WIDTH_M = 0.75, 0.15
_BAR_M = 0.5  # of a crosswalk, and the gap between two
_AREA_EDGE_M = 0.15


def surface_parts(
    carriageway: BaseGeometry, pavement: BaseGeometry, road_map: HdMap, terrain: Terrain
) -> Iterator[StillPart]:
    """Ground, asphalt, kerbs, pavement and paint."""
    yield StillPart("ground", PartKind.GROUND, _ground(terrain, carriageway), _GRASS)
    kerb = carriageway.buffer(_KERB_M, join_style="mitre").difference(carriageway)
    walked = pavement.difference(carriageway)
    yield StillPart("pavement", PartKind.PAVEMENT, _flat(walked, terrain, PAVEMENT_BELOW_M), _PAVEMENT)
    yield StillPart("kerb", PartKind.PAVEMENT, _flat(kerb, terrain, ROAD_BELOW_M), _KERB)
    yield StillPart("asphalt", PartKind.ROAD, _flat(carriageway, terrain, ROAD_BELOW_M), _ASPHALT)
    white = shapely.union_all(list(painted(road_map, Colour.WHITE)))
    for colour, rgb in _PAINT.items():
        area = white if colour is Colour.WHITE else shapely.union_all(list(painted(road_map, colour))).difference(white)
        if not area.is_empty:
            yield StillPart(f"paint/{colour}", PartKind.PAINT, _flat(area, terrain, 0.0), rgb)


def painted(road_map: HdMap, colour: Colour) -> Iterator[shapely.Polygon]:
    """Every stroke of paint of one colour, on the ground plane; they may overlap."""
    for line in road_map.lane_markings:
        pieces = [cut(line, *dash) for dash in line.dashes_m.tolist()] if line.dash_m else [line.points_m]
        if line.colour is colour:
            yield from (stroke(piece, line.width_m) for piece in pieces)
    if colour is not Colour.WHITE:
        return
    for stop in road_map.stop_lines:
        yield stroke(stop.points_m, stop.width_m)
    for guide in road_map.guide_lines:
        for begin_m in np.arange(0.0, guide.length_m - _GUIDE_DASH_M, 2 * _GUIDE_DASH_M).tolist():
            yield stroke(cut(guide, begin_m, begin_m + _GUIDE_DASH_M), _GUIDE_WIDTH_M)
    for mark in road_map.road_marks:
        yield from _arrow(mark)
    for area in road_map.painted_areas:
        if area.kind is AreaKind.CROSSWALK:
            yield from crosswalk_bars(area)
        else:
            yield stroke(np.vstack([area.ring_m, area.ring_m[:1]]), _AREA_EDGE_M)


def road_area(network: RoadNetwork) -> BaseGeometry:
    """The carriageway on the ground plane: lanes with a shoulder, and whatever junctions enclose."""
    lanes = [lane for lane in network.lanes.values() if lane.users & {CARS, BICYCLES}]
    return shapely.union_all([_lane_area(lane, _SHOULDER_M) for lane in lanes] + _gores(network)).buffer(0.0)


def pavement_area(network: RoadNetwork) -> BaseGeometry:
    """Where people walk, the carriageway included where a crosswalk leads over it."""
    outlines = [edge.lanes[0].shape_m[:, :2] for edge in network.edges.values() if edge.function == "walkingarea"]
    corners = [outline for outline in outlines if len(outline) >= 3]  # others lead from one pavement into its own
    walks = [
        _lane_area(lane, 0.2)
        for edge in network.edges.values()
        if edge.function in ("normal", "crossing")
        for lane in edge.lanes
        if not lane.users & {CARS, BICYCLES}
    ]
    return shapely.union_all([*walks, *(shapely.Polygon(ring).buffer(0.2) for ring in corners)])


def _gores(network: RoadNetwork) -> list[BaseGeometry]:
    """What lies between the lanes of a junction."""
    inner = [
        _lane_area(lane, 1.0)
        for edge in network.edges.values()
        if edge.function == "internal"
        for lane in edge.lanes
        if lane.users & {CARS, BICYCLES}
    ]
    return [shapely.union_all(inner).buffer(_GORE_M).buffer(-_GORE_M)] if inner else []


def _lane_area(lane: RoadLane, wider_m: float) -> BaseGeometry:
    line = shapely.LineString(lane.shape_m[:, :2])
    return line.buffer(lane.width_m / 2 + wider_m, cap_style="flat", join_style="mitre")


def _flat(area: BaseGeometry, terrain: Terrain, below_m: float) -> Mesh:
    """The area as triangles on the terrain, facing up."""
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.segmentize(area, _SIDE_M)))
    rings = shapely.get_coordinates(shapely.normalize(triangles)).reshape(-1, 4, 2)[:, :3]  # clockwise
    corners = rings[:, ::-1].reshape(-1, 2)
    return Mesh(terrain.lifted(corners, -below_m), np.arange(len(corners)).reshape(-1, 3))


def _ground(terrain: Terrain, carriageway: BaseGeometry) -> Mesh:
    """Grass far beyond the road on all sides."""
    bounds = np.array(carriageway.bounds)
    low, high = bounds[:2] - _GROUND_MARGIN_M, bounds[2:] + _GROUND_MARGIN_M
    x, y = (np.arange(low[k], high[k] + _GROUND_STEP_M, _GROUND_STEP_M) for k in range(2))
    places = np.stack(np.meshgrid(x, y), axis=-1)  # (R, C, 2)
    vertices = terrain.lifted(places.reshape(-1, 2), -GROUND_BELOW_M)
    rows, columns = places.shape[:2]
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1)
    quads = first[:, None] + (0, 1, columns + 1, columns)
    return Mesh(vertices, np.concatenate([quads[:, (0, 1, 2)], quads[:, (0, 2, 3)]]))


def stroke(line_m: FloatArray, width_m: float) -> shapely.Polygon:
    """A stroke of paint along ``line_m`` (N, 3)."""
    left, right = offset_line(line_m, width_m / 2), offset_line(line_m, -width_m / 2)
    return shapely.Polygon(np.vstack([right, left[::-1]])[:, :2])


def cut(line: Line, begin_m: float, end_m: float) -> FloatArray:
    """The part (N, 3) of a line between two lengths along it, measured on the ground plane."""
    reached = line.reached_m
    inside = reached[(reached > begin_m + 1e-6) & (reached < end_m - 1e-6)]
    return line.places_m([begin_m, *inside, end_m])


def crosswalk_bars(area: PaintedArea) -> Iterator[shapely.Polygon]:
    """Bars along the traffic's way; the first and the last end exactly at the area's ends.

    The ring goes along one side in the walkers' direction and back along the other.
    """
    ahead_m, back_m = area.sides_m
    right, left = Line("right", ahead_m), Line("left", back_m[::-1])
    count = max(1, round((right.length_m / _BAR_M + 1) / 2))
    share = np.arange(2 * count).reshape(-1, 2) / (2 * count - 1)  # begin and end of each bar
    for begin, end in share.tolist():
        near, far = (cut(side, begin * side.length_m, end * side.length_m)[[0, -1]] for side in (right, left))
        yield shapely.Polygon(np.array([near[0], near[1], far[1], far[0]])[:, :2])


def _arrow(mark: RoadMark) -> Iterator[shapely.Polygon]:
    """An arrow for each way in which the lane leads, on one stem; other signs are left to their text."""
    cos, sin = np.cos(mark.heading_rad), np.sin(mark.heading_rad)
    for outline in _ARROWS.get(mark.kind, ()):
        yield shapely.Polygon(np.array(outline) @ np.array([[cos, sin], [-sin, cos]]) + mark.position_m[:2])


Outline = Sequence[tuple[float, float]]  # convex, counter-clockwise, x ahead and y to the left, metres

_STEM: Outline = ((-2.5, -0.08), (0.6, -0.08), (0.6, 0.08), (-2.5, 0.08))
_AHEAD: tuple[Outline, ...] = (
    ((0.6, -0.08), (1.2, -0.08), (1.2, 0.08), (0.6, 0.08)),
    ((1.2, -0.35), (2.5, 0.0), (1.2, 0.35)),
)
_TO_LEFT: tuple[Outline, ...] = (
    ((0.2, 0.08), (0.6, 0.08), (1.1, 0.55), (0.9, 0.55)),
    ((0.55, 0.5), (1.45, 0.5), (1.0, 1.15)),
)
_TO_RIGHT: tuple[Outline, ...] = tuple(tuple((x, -y) for x, y in reversed(outline)) for outline in _TO_LEFT)
_ARROWS: dict[MarkKind, tuple[Outline, ...]] = {
    MarkKind.STRAIGHT: (_STEM, *_AHEAD),
    MarkKind.LEFT: (_STEM, *_TO_LEFT),
    MarkKind.RIGHT: (_STEM, *_TO_RIGHT),
    MarkKind.STRAIGHT_LEFT: (_STEM, *_AHEAD, *_TO_LEFT),
    MarkKind.STRAIGHT_RIGHT: (_STEM, *_AHEAD, *_TO_RIGHT),
    MarkKind.ALL: (_STEM, *_AHEAD, *_TO_LEFT, *_TO_RIGHT),
}
