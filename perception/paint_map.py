"""What of an HD map a camera can see painted on the road: places along strokes, along edges, and corners."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from contracts import Camera, FloatArray
from georef.hd_map import AreaKind, HdMap, LaneMarking, Line
from georef.projection import project

_STEP_M = 0.25  # between places of a line that are looked at
_SHORT_M = 0.05  # over which scale and direction are taken
_INSET_M = 0.3  # of a stroke at each end, where it is cut or meets another
_MEETING_M, _CLEAR_M = 0.4, 0.6  # strokes so near each other meet; how far from there they can be told apart
_END_SIGMA_PX = 0.15
_END_M, _ACROSS_M = 0.02, 0.5  # an end is looked at in the middle of its stroke, and lies on a line across it


@dataclass(frozen=True, eq=False)
class PaintLine:
    """A line of the map that shows in the image.

    points_m: (M, 3) where it is looked for. width_m: of the stroke; 0 for an edge whose paint lies to its left.
    course_m: (L, 3) the line on which lies what is found: that which a dash is one of, or an end longer than its edge.
    sigma_px: how much less exactly than a stroke it is found, standard deviation.
    meets_m: (K, 2) where it meets another stroke, and cannot be told from it.
    """

    name: str
    points_m: FloatArray
    width_m: float
    course_m: FloatArray
    sigma_px: float = 0.0
    meets_m: FloatArray = field(default_factory=lambda: np.empty((0, 2)))


@dataclass(frozen=True, eq=False)
class PaintMap:
    """All that is painted: lines, and corners (K, 3) with their names."""

    lines: tuple[PaintLine, ...]
    corner_names: tuple[str, ...]
    corners_m: FloatArray


def paint_of(hd_map: HdMap) -> PaintMap:
    """The paint that a map tells exactly; of crosswalks the ends of their bars and the outermost corners."""
    lines = _with_meetings(list(_strokes(hd_map)))
    names: list[str] = []
    corners: list[FloatArray] = []
    for area in hd_map.painted_areas:
        if area.kind is AreaKind.CROSSWALK:
            right, left = area.sides_m
            lines += [_edge(f"{area.id}/right", right), _edge(f"{area.id}/left", left)]
            names += [f"{area.id}/corner {k}" for k in range(4)]
            corners += [right[0], right[-1], left[0], left[-1]]
    return PaintMap(tuple(lines), tuple(names), np.array(corners).reshape(-1, 3))


def _strokes(hd_map: HdMap) -> Iterator[PaintLine]:
    for marking in hd_map.lane_markings:
        if not marking.dash_m:
            yield PaintLine(marking.id, marking.points_m, marking.width_m, marking.points_m)
        for number, (begin_m, end_m) in enumerate(marking.dashes_m.tolist()):
            name = f"{marking.id}/dash {number}"
            yield _piece(marking, name, begin_m, end_m)
            yield _end(f"{name}/begin", marking.places_m([begin_m, begin_m + _END_M]), back=True)
            yield _end(f"{name}/end", marking.places_m([end_m - _END_M, end_m]), back=False)
    for stop in hd_map.stop_lines:
        yield PaintLine(stop.id, stop.points_m, stop.width_m, stop.points_m)


def _with_meetings(lines: Sequence[PaintLine]) -> list[PaintLine]:
    """Each stroke with the places where others come near it, a marking's own dashes aside."""
    strokes = [line for line in lines if line.width_m > 0]
    shapes = [shapely.LineString(line.points_m[:, :2]) for line in strokes]
    tree = shapely.STRtree(shapes)
    meets: dict[str, list[FloatArray]] = {line.name: [] for line in strokes}
    for one, other in zip(*tree.query(shapes, predicate="dwithin", distance=_MEETING_M), strict=True):
        if strokes[one].course_m is not strokes[other].course_m:
            here, _ = shapely.shortest_line(shapes[one], shapes[other]).coords
            meets[strokes[one].name].append(np.array(here))
    return [
        replace(line, meets_m=np.array(meets[line.name]).reshape(-1, 2)) if line.name in meets else line
        for line in lines
    ]


def _piece(marking: LaneMarking, name: str, begin_m: float, end_m: float) -> PaintLine:
    along = np.linspace(begin_m, end_m, max(2, int((end_m - begin_m) / _STEP_M) + 1))
    return PaintLine(name, marking.places_m(along), marking.width_m, marking.points_m)


def _edge(name: str, points_m: FloatArray) -> PaintLine:
    return PaintLine(name, points_m, 0.0, points_m)


def _end(name: str, last_m: FloatArray, *, back: bool) -> PaintLine:
    """The end of a dash. last_m: (2, 3) places near it in the marking's direction. back: whether it begins there."""
    ahead = (last_m[1] - last_m[0]) / np.linalg.norm(last_m[1] - last_m[0])
    middle, outwards = (last_m[0], -ahead) if back else (last_m[1], ahead)
    left = np.array([-outwards[1], outwards[0], 0.0])  # walking this way has what is behind the end on the left
    across = np.outer([-1.0, 1.0], left)
    return PaintLine(name, middle + _END_M * across, 0.0, middle + _ACROSS_M * across, _END_SIGMA_PX)


@dataclass(frozen=True, eq=False)
class Looks:
    """Places along one line as a camera should see them.

    places_m, right: (N, 3) places on the line and unit vectors to its right.
    pixels, normals: (N, 2) their images and unit vectors to look along, to the right: across a stroke's image; but at
    an edge the image of what is across it on the road, so that one looks along the bar or the dash which ends there.
    across_px_per_m, along_px_per_m: (N,) scale that way, and along the line.
    """

    line: PaintLine
    places_m: FloatArray
    right: FloatArray
    pixels: FloatArray
    normals: FloatArray
    across_px_per_m: FloatArray
    along_px_per_m: FloatArray


def looks_along(camera: Camera, line: PaintLine, *, every_px: float, farthest_m: float) -> Looks:
    """Where to look for ``line``: places about ``every_px`` apart in the image, no farther than ``farthest_m``."""
    along_m = Line(line.name, line.points_m).length_m
    inset_m = min(_INSET_M, along_m / 3) if line.width_m > 0 else 0.0
    along_line_m = np.linspace(inset_m, along_m - inset_m, max(2, int(along_m / _STEP_M) + 1))
    dense = Line(line.name, line.points_m).places_m(along_line_m)
    apart = np.linalg.norm(dense[:, None, :2] - line.meets_m, axis=2).min(axis=1, initial=np.inf) > _CLEAR_M
    near = np.linalg.norm(dense[:, :2] - camera.pose.position_m[:2], axis=1) < farthest_m
    tangents = np.gradient(dense[:, :2], axis=0)
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-9)
    right = np.column_stack([tangents[:, 1], -tangents[:, 0], np.zeros(len(dense))])
    pixels, valid = project(camera, dense)
    beside, beside_valid = project(camera, dense + _SHORT_M * right)
    ahead, ahead_valid = project(camera, dense + _SHORT_M * np.column_stack([tangents, np.zeros(len(dense))]))
    size = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px])
    inside = (pixels > 2).all(axis=1) & (pixels < size - 3).all(axis=1)
    seen = near & apart & valid & beside_valid & ahead_valid & inside
    kept = _spaced(pixels, seen, every_px)
    along, across = ahead[kept] - pixels[kept], beside[kept] - pixels[kept]
    length = np.linalg.norm(along, axis=1)
    if line.width_m > 0:
        upright = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
        normals = upright * np.sign((upright * across).sum(axis=1, keepdims=True))
    else:
        normals = across / np.linalg.norm(across, axis=1, keepdims=True)
    scale = (across * normals).sum(axis=1) / _SHORT_M
    return Looks(line, dense[kept], right[kept], pixels[kept], normals, scale, length / _SHORT_M)


def stretch_around(points_m: FloatArray, place_m: FloatArray, reach_m: float) -> FloatArray:
    """The part of a line (M, 3) within about ``reach_m`` of a place on it: whole sides, at least one."""
    starts, sides = points_m[:-1, :2], np.diff(points_m[:, :2], axis=0)
    share = ((place_m[:2] - starts) * sides).sum(axis=1) / (sides**2).sum(axis=1)
    feet = starts + np.clip(share, 0.0, 1.0)[:, None] * sides
    away = np.linalg.norm(feet - place_m[:2], axis=1)
    near = np.flatnonzero(away <= max(reach_m, float(away.min())))
    middle = int(away.argmin())
    first = middle - int(np.argmin(np.append(np.isin(np.arange(middle, -1, -1), near), False))) + 1
    last = middle + int(np.argmin(np.append(np.isin(np.arange(middle, len(sides)), near), False)))
    return points_m[first : last + 1]


def _spaced(pixels: FloatArray, seen: np.ndarray, every_px: float) -> np.ndarray:
    """Rows of places that are seen and no nearer to the one before than ``every_px``."""
    kept: list[int] = []
    for row in np.flatnonzero(seen).tolist():
        if not kept or np.hypot(*(pixels[row] - pixels[kept[-1]])) >= every_px:
            kept.append(row)
    return np.array(kept, dtype=np.int64)
