"""What of an HD map a camera can see painted on the road: places along strokes, along edges, and corners."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from contracts import Camera, FloatArray
from georef.hd_map import AreaKind, HdMap, Line
from georef.projection import project

_STEP_M = 0.25  # between places of a line that are looked at


@dataclass(frozen=True, eq=False)
class PaintLine:
    """A line of the map that shows in the image.

    points_m: (M, 3). width_m: of the stroke; 0 for the edge of an area whose paint lies to its left.
    """

    name: str
    points_m: FloatArray
    width_m: float


@dataclass(frozen=True, eq=False)
class PaintMap:
    """All that is painted: lines, and corners (K, 3) with their names."""

    lines: tuple[PaintLine, ...]
    corner_names: tuple[str, ...]
    corners_m: FloatArray


def paint_of(hd_map: HdMap) -> PaintMap:
    """The paint that a map tells exactly; of crosswalks the ends of their bars and the outermost corners."""
    lines = list(_strokes(hd_map))
    names: list[str] = []
    corners: list[FloatArray] = []
    for area in hd_map.painted_areas:
        if area.kind is AreaKind.CROSSWALK:
            half = len(area.ring_m) // 2
            right, left = area.ring_m[:half], area.ring_m[half:]  # along the walkers' way, and back
            lines += [PaintLine(f"{area.id}/right", right, 0.0), PaintLine(f"{area.id}/left", left, 0.0)]
            names += [f"{area.id}/corner {k}" for k in range(4)]
            corners += [right[0], right[-1], left[0], left[-1]]
    return PaintMap(tuple(lines), tuple(names), np.array(corners).reshape(-1, 3))


def _strokes(hd_map: HdMap) -> Iterator[PaintLine]:
    for marking in hd_map.lane_markings:
        yield PaintLine(marking.id, marking.points_m, marking.width_m)
    for stop in hd_map.stop_lines:
        yield PaintLine(stop.id, stop.points_m, stop.width_m)


@dataclass(frozen=True, eq=False)
class Looks:
    """Places along one line as a camera should see them.

    places_m, right: (N, 3) places on the line and unit vectors to its right.
    pixels, normals: (N, 2) their images and unit vectors across the line's, to its right.
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
    dense = Line(line.name, line.points_m).places_m(np.linspace(0.0, along_m, max(2, int(along_m / _STEP_M) + 1)))
    near = np.linalg.norm(dense[:, :2] - camera.pose.position_m[:2], axis=1) < farthest_m
    tangents = np.gradient(dense[:, :2], axis=0)
    tangents /= np.maximum(np.linalg.norm(tangents, axis=1, keepdims=True), 1e-9)
    right = np.column_stack([tangents[:, 1], -tangents[:, 0], np.zeros(len(dense))])
    pixels, valid = project(camera, dense)
    beside, beside_valid = project(camera, dense + 0.05 * right)
    ahead, ahead_valid = project(camera, dense + 0.05 * np.column_stack([tangents, np.zeros(len(dense))]))
    size = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px])
    inside = (pixels > 2).all(axis=1) & (pixels < size - 3).all(axis=1)
    seen = near & valid & beside_valid & ahead_valid & inside
    kept = _spaced(pixels, seen, every_px)
    along = ahead[kept] - pixels[kept]
    length = np.linalg.norm(along, axis=1)
    along /= length[:, None]
    normals = np.column_stack([-along[:, 1], along[:, 0]])
    scale = np.einsum("ni,ni->n", beside[kept] - pixels[kept], normals) / 0.05
    normals = np.where(scale[:, None] < 0, -normals, normals)
    return Looks(line, dense[kept], right[kept], pixels[kept], normals, np.abs(scale), length / 0.05)


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
