"""Which control point is which: marks that all look alike, told apart by where the camera may stand.

On a tile grid the image repeats: a camera moved by one tile sees the same picture. What does not repeat is the
camera's pose. It may depart from the nominal one by less than half a tile, so of all labellings that fit one rigid
camera at most one puts that camera near enough to where it should be.

    1. lay the marks on the ground with the nominal pose: places, shifted and turned by the unknown departure
    2. for each pair of neighbouring marks and each pair of control points with about the same step between them:
       move all places along, give each the nearest control point: a hypothesis
    3. fit a pose to each hypothesis, re-label by that pose, until nothing changes
    4. keep those within the permitted departure; the most marks win; two different winners are no answer
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from contracts import CalibrationError, Camera, FloatArray, InputError, IntArray
from georef.location import on_plane
from georef.pose import fit_pose
from georef.projection import project

LEAST_MARKS = 5  # ten numbers for six unknowns
_GATE_PX = 2.5  # between a mark and its control point once the pose is fitted
_RIVAL_SHARE = 0.8  # another labelling with this share of the winner's marks makes the answer ambiguous
_LEAST_SHARE = 0.5  # of the marks found that must be labelled


@dataclass(frozen=True)
class Departure:
    """How far a camera may stand from its nominal pose: the length of the shift and the angle of the turn."""

    position_m: float = 0.13
    angle_rad: float = np.deg2rad(4.0)

    def __post_init__(self) -> None:
        if not (self.position_m > 0 and self.angle_rad > 0):
            raise InputError(f"Departure of {self.position_m} m and {self.angle_rad} rad: both must be positive")

    def permits(self, nominal: Camera, camera: Camera) -> bool:
        """Whether ``camera`` stands near enough to ``nominal``."""
        turn = Rotation.from_matrix(camera.pose.world_from_camera @ nominal.pose.world_from_camera.T)
        shift = np.linalg.norm(camera.pose.position_m - nominal.pose.position_m)
        return bool(shift <= self.position_m and turn.magnitude() <= self.angle_rad)


@dataclass(frozen=True, eq=False)
class Labelled:
    """Marks that have been told apart.

    camera: intrinsics as given, pose fitted to the marks.
    marks, points: (K,) row numbers of the marks and of the control points that they are.
    """

    camera: Camera
    marks: IntArray
    points: IntArray


def label(nominal: Camera, marks_px: FloatArray, points_m: FloatArray, departure: Departure | None = None) -> Labelled:
    """Label marks with control points.

    nominal: calibrated intrinsics at the nominal pose. marks_px: (M, 2), some of them false. points_m: (N, 3) control
    points in the world, on nearly horizontal ground; those out of sight or hidden do no harm.
    Raises CalibrationError where no labelling fits, or more than one does.
    """
    departure = departure or Departure()
    if len(marks_px) < LEAST_MARKS:
        raise CalibrationError(
            f'camera "{nominal.name}": {len(marks_px)} control points were found in the image; {LEAST_MARKS} are needed'
        )
    fits: dict[frozenset[tuple[int, int]], Labelled] = {}
    for pairs in _hypotheses(nominal, marks_px, points_m, departure):
        fit = _settle(nominal, marks_px, points_m, pairs)
        if fit is not None and departure.permits(nominal, fit.camera):
            fits[_pairs(fit)] = fit
    ranked = sorted(fits.values(), key=lambda fit: len(fit.marks), reverse=True)
    if not ranked or len(ranked[0].marks) < max(LEAST_MARKS, _LEAST_SHARE * len(marks_px)):
        best = len(ranked[0].marks) if ranked else 0
        raise CalibrationError(
            f'camera "{nominal.name}": of {len(marks_px)} marks found only {best} fit the control points from a pose '
            f"within {departure.position_m:.2f} m and {np.rad2deg(departure.angle_rad):.1f} deg of the nominal one"
        )
    for rival in ranked[1:]:
        if len(rival.marks) >= _RIVAL_SHARE * len(ranked[0].marks) and _contradict(ranked[0], rival):
            raise CalibrationError(
                f'camera "{nominal.name}": two labellings of the control points fit; give a better nominal pose'
            )
    return ranked[0]


def _hypotheses(
    nominal: Camera, marks_px: FloatArray, points_m: FloatArray, departure: Departure
) -> Iterator[IntArray]:
    """First labellings (K, 2) of mark and point numbers, each once."""
    height = float(np.median(points_m[:, 2]))
    places, valid = on_plane(nominal, marks_px, height)
    kept = np.flatnonzero(valid)
    if len(kept) < LEAST_MARKS:
        return
    ground, tree = places[kept, :2], cKDTree(points_m[:, :2])
    reach = _reach(nominal, places[kept], departure)  # (M,)
    step_slack = 0.05 + 2 * departure.angle_rad  # a turn and a change of scale and perspective, relative
    gaps, neighbours = _nearest(ground, ground, min(6, len(kept)))  # (M, 6), itself first
    spacing = float(np.median(gaps[:, 1]))
    seen: set[bytes] = set()
    for first in range(len(kept)):
        for second in neighbours[first, 1:]:
            step = ground[second] - ground[first]
            for point in tree.query_ball_point(ground[first], reach[first]):
                distance, partner = tree.query(points_m[point, :2] + step)
                if distance > step_slack * np.linalg.norm(step) or partner == point:
                    continue
                moved = _carried(ground, ground[[first, second]], points_m[[point, partner], :2])
                gap, nearest = _nearest(points_m[:, :2], moved)
                pairs = _one_to_one(kept, nearest[:, 0], gap[:, 0], 0.3 * spacing)
                if len(pairs) >= LEAST_MARKS and pairs.tobytes() not in seen:
                    seen.add(pairs.tobytes())
                    yield pairs


def _reach(nominal: Camera, places_m: FloatArray, departure: Departure) -> FloatArray:
    """How far each place (M, 3) on the ground can move if the camera departs as far as is permitted, metres."""
    away = places_m - nominal.pose.position_m
    distance = np.linalg.norm(away, axis=-1)
    slant = distance / np.maximum(np.abs(away[:, 2]), 1e-9)
    reach: FloatArray = slant * (departure.position_m + 1.1 * distance * departure.angle_rad)
    return reach


def _carried(ground: FloatArray, source: FloatArray, target: FloatArray) -> FloatArray:
    """``ground`` (M, 2) moved by the similarity that takes the two points of ``source`` to those of ``target``."""
    plane = ground @ [1, 1j]
    (a, b), (c, d) = source @ [1, 1j], target @ [1, 1j]
    moved = c + (plane - a) * (d - c) / (b - a)
    return np.stack([moved.real, moved.imag], axis=-1)


def _settle(nominal: Camera, marks_px: FloatArray, points_m: FloatArray, pairs: IntArray) -> Labelled | None:
    """Fit a pose, label by it, with a gate that shrinks; None where fewer than LEAST_MARKS remain."""
    camera = nominal
    for gate_px in (30.0, 8.0, _GATE_PX, _GATE_PX):
        try:
            camera, _ = fit_pose(camera, points_m[pairs[:, 1]], marks_px[pairs[:, 0]])
        except CalibrationError:
            return None
        predicted, valid = project(camera, points_m)
        visible = np.flatnonzero(valid)
        gap, nearest = _nearest(predicted[visible], marks_px)
        pairs = _one_to_one(np.arange(len(marks_px)), visible[nearest[:, 0]], gap[:, 0], gate_px)
        if len(pairs) < LEAST_MARKS:
            return None
    return Labelled(camera, pairs[:, 0], pairs[:, 1])


def _nearest(targets: FloatArray, queries: FloatArray, count: int = 1) -> tuple[FloatArray, IntArray]:
    """Distances and row numbers (M, count) of the targets nearest to each query."""
    distance, number = cKDTree(targets).query(queries, k=range(1, count + 1))
    return np.asarray(distance, dtype=np.float64), np.asarray(number, dtype=np.int64)


def _one_to_one(marks: IntArray, points: IntArray, gap: FloatArray, gate: float) -> IntArray:
    """Pairs (K, 2) within the gate, each point taken by its nearest mark only, in the marks' order."""
    near = np.flatnonzero(gap < gate)
    order = near[np.argsort(gap[near], kind="stable")]
    _, first = np.unique(points[order], return_index=True)
    chosen = np.sort(order[first])
    return np.stack([marks[chosen], points[chosen]], axis=-1)


def _pairs(fit: Labelled) -> frozenset[tuple[int, int]]:
    return frozenset(zip(fit.marks.tolist(), fit.points.tolist(), strict=True))


def _contradict(one: Labelled, other: Labelled) -> bool:
    """Whether a mark is called different points."""
    names = dict(_pairs(one))
    return any(names.get(mark, point) != point for mark, point in _pairs(other))
