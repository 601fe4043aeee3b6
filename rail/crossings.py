"""Where tracks cross on one level: found in the geometry, matched with what the author declared."""

from collections.abc import Mapping
from itertools import combinations
from math import cos, sin

import numpy as np
from shapely import LineString, get_parts, intersection

from contracts import FloatArray, InputError
from rail.curves import Curve
from rail.plant import Crossing, Section, known
from rail.spec import CrossingSpec

_STEP_M = 0.01  # of the polylines that find a crossing; its place is refined on the curves themselves
_END_M = 0.005  # sections that meet at an end, as at a switch, do not cross there


def crossings_of(specs: Mapping[str, CrossingSpec], sections: Mapping[str, Section]) -> dict[str, Crossing]:
    """The declared crossings, with their place.

    Raises InputError for tracks that cross undeclared, and for a declared pair that does not cross exactly once.
    """
    found = _found(sections)
    crossings: dict[str, Crossing] = {}
    for id_, spec in specs.items():
        a, b = (known(name, sections, f"crossing {id_!r}: section") for name in spec.sections)
        places = found.pop(frozenset((a, b)), [])
        if len(places) != 1:
            raise InputError(f"crossing {id_!r}: sections {a!r} and {b!r} cross {len(places)} times instead of once")
        offsets_m = _refined(sections[a].curve, sections[b].curve, places[0])
        pose = sections[a].curve.pose_at(offsets_m[0])
        crossings[id_] = Crossing(id_, (a, b), offsets_m, (pose.x_m, pose.y_m))
    for pair, places in found.items():
        names, (x, y) = " and ".join(repr(name) for name in sorted(pair)), places[0].tolist()
        raise InputError(f"sections {names} cross near ({x:.3f}, {y:.3f}) m; declare it as [crossing.NAME]")
    return crossings


def _found(sections: Mapping[str, Section]) -> dict[frozenset[str], list[FloatArray]]:
    """Points (2,) near which two sections cross, by pair of names."""
    lines = {id_: LineString(section.curve.points(_STEP_M)) for id_, section in sections.items()}
    found: dict[frozenset[str], list[FloatArray]] = {}
    for a, b in combinations(lines, 2):
        ends = np.array([line.coords[k] for line in (lines[a], lines[b]) for k in (0, -1)])  # (4, 2)
        parts = get_parts(intersection(lines[a], lines[b]))
        points = [np.array([part.centroid.x, part.centroid.y]) for part in parts if not part.is_empty]
        inner = [point for point in points if np.linalg.norm(ends - point, axis=1).min() > _END_M]
        if inner:
            found[frozenset((a, b))] = inner
    return found


def _refined(a: Curve, b: Curve, near: FloatArray) -> tuple[float, float]:
    """Offsets on ``a`` and ``b`` at which the curves meet near the point ``near`` (2,): Newton's method."""
    offsets = np.array([_nearest_offset(a, near), _nearest_offset(b, near)])
    for _ in range(8):  # quadratic from a centimetre away: three would do
        p, q = a.pose_at(offsets[0]), b.pose_at(offsets[1])
        gap = np.array([q.x_m - p.x_m, q.y_m - p.y_m])
        slopes = np.array([[cos(p.heading_rad), -cos(q.heading_rad)], [sin(p.heading_rad), -sin(q.heading_rad)]])
        offsets = np.clip(offsets + np.linalg.solve(slopes, gap), 0.0, [a.length_m, b.length_m])
    return float(offsets[0]), float(offsets[1])


def _nearest_offset(curve: Curve, point: FloatArray) -> float:
    points = curve.points(_STEP_M)
    nearest = int(np.argmin(np.linalg.norm(points - point, axis=1)))
    return nearest * curve.length_m / (len(points) - 1)
