"""What an owner picks by hand in a picture: points of the map and pixels on its lines, with a hand's errors."""

from collections.abc import Iterator

import numpy as np
import shapely

from contracts import BoolArray, Camera, FloatArray, IntArray
from georef.hd_map import AreaKind, HdMap, Line
from georef.picks import LinePicks, PointPicks
from sim.projection import project
from sim.road_surface import crosswalk_bars

_FARTHEST_M, _ON_LINES_M = 70.0, 50.0
_BORDER_PX = 5.0
_PER_LINE, _STEP_M = 5, 0.5


def hand_picks(
    camera: Camera,
    true_map: HdMap,
    owners_map: HdMap,
    rng: np.random.Generator,
    *,
    points: int = 25,
    noise_px: float = 1.0,
    wrong_share: float = 0.1,
) -> tuple[PointPicks, LinePicks]:
    """Up to ``points`` picks of points, as far apart in the image as they can be, and some pixels on painted lines.

    camera: the true one. Where a thing truly is decides the pixel; where ``owners_map`` has it, the pick's place.
    noise_px: per axis. wrong_share: of the picks of points, put somewhere else in the image.
    """
    names, places = _points(true_map)
    believed = dict(zip(*_points(owners_map), strict=True))
    pixels, seen = _seen(camera, np.array(places).reshape(-1, 3), _FARTHEST_M)
    rows = _spread(pixels, np.flatnonzero(seen).astype(np.int64), points)
    picked = pixels[rows] + noise_px * rng.standard_normal((len(rows), 2))
    size = camera.intrinsics.width_px, camera.intrinsics.height_px
    wrong = rng.permutation(len(rows))[: round(wrong_share * len(rows))]
    picked[wrong] = rng.uniform((0, 0), size, (len(wrong), 2))
    on_map = np.array([believed[names[row]] for row in rows]).reshape(-1, 3)
    chosen = PointPicks(tuple(names[row] for row in rows), picked, on_map, np.zeros(len(rows)))
    return chosen, _on_lines(camera, true_map, owners_map, rng, noise_px)


def _points(hd_map: HdMap) -> tuple[list[str], list[FloatArray]]:
    """Points that one finds in a picture: ends of stop lines and dashes, corners of crosswalks, feet of poles."""
    named = [(f"{line.id}/{end}", line.points_m[end]) for line in hd_map.stop_lines for end in (0, -1)]
    for area in hd_map.painted_areas:
        if area.kind is AreaKind.CROSSWALK:
            corners_m = [side_m[end] for side_m in area.sides_m for end in (0, -1)]
            named += [(f"{area.id}/{k}", corner_m) for k, corner_m in enumerate(corners_m)]
    named += [(facility.id, facility.position_m) for facility in hd_map.facilities]
    for marking in hd_map.lane_markings:
        ends = marking.places_m(marking.dashes_m.ravel())
        named += [(f"{marking.id}/{k}", place) for k, place in enumerate(ends)]
    return [name for name, _ in named], [place for _, place in named]


def _lines(hd_map: HdMap) -> Iterator[tuple[Line, FloatArray]]:
    """Lines on which one can pick, with places (N, 3) where they show: where a crosswalk's side has a bar's end."""
    for line in (*(line for line in hd_map.lane_markings if not line.dash_m), *hd_map.stop_lines):
        yield line, line.places_m(np.arange(0.0, line.length_m, _STEP_M))
    for area in hd_map.painted_areas:
        if area.kind is AreaKind.CROSSWALK:
            bars = np.array([bar.exterior.coords[:4] for bar in crosswalk_bars(area)])  # (B, 4, 2)
            for side, points_m, ends_m in zip(("right", "left"), area.sides_m, (bars[:, :2], bars[:, 2:]), strict=True):
                line = Line(f"{area.id}/{side}", points_m)
                middles = shapely.points(ends_m.mean(axis=1))
                yield line, line.places_m(shapely.line_locate_point(shapely.LineString(points_m[:, :2]), middles))


def _seen(camera: Camera, places_m: FloatArray, farthest_m: float) -> tuple[FloatArray, BoolArray]:
    pixels, valid = project(camera, places_m)
    size = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px])
    inside = (pixels > _BORDER_PX).all(axis=-1) & (pixels < size - 1 - _BORDER_PX).all(axis=-1)
    near = np.linalg.norm(places_m - camera.pose.position_m, axis=-1) < farthest_m
    return pixels, valid & inside & near


def _spread(pixels: FloatArray, rows: IntArray, count: int) -> IntArray:
    """Rows whose pixels are far from each other: always the one farthest from those before (Gonzalez 1985)."""
    if len(rows) <= count:
        return rows
    kept = [int(rows[0])]
    away = np.linalg.norm(pixels[rows] - pixels[kept[0]], axis=1)
    while len(kept) < count:
        kept.append(int(rows[away.argmax()]))
        away = np.minimum(away, np.linalg.norm(pixels[rows] - pixels[kept[-1]], axis=1))
    return np.array(kept)


def _on_lines(
    camera: Camera, true_map: HdMap, owners_map: HdMap, rng: np.random.Generator, noise_px: float
) -> LinePicks:
    believed = {line.id: line.points_m for line, _ in _lines(owners_map)}
    names: list[str] = []
    pixels: list[FloatArray] = []
    for line, places_m in _lines(true_map):
        shown, seen = _seen(camera, places_m, _ON_LINES_M)
        rows = _spread(shown, np.flatnonzero(seen).astype(np.int64), _PER_LINE)
        names += len(rows) * [line.id]
        pixels.append(shown[rows] + noise_px * rng.standard_normal((len(rows), 2)))
    together = np.concatenate([np.empty((0, 2)), *pixels])
    return LinePicks(tuple(names), together, tuple(believed[name] for name in names), np.zeros(len(names)))
