"""Does the chain know which way everything goes, how fast, and how well it knows that? Of the fused tracks.

In the truth a vehicle **travels** from ``TRAVELLING_MPS`` on and **stands** below ``STANDING_MPS``; in between it
crawls, of which nothing is asked. An answer is asked for from ``SETTLE_S`` on after the vehicle was first found, was
found again after a gap longer than that, began or ceased to travel, crawl or stand, or turned round. A compass
direction is right if it is that of a heading within ``MARGIN_RAD`` of the true one: on a diagonal either side will do.

Where nothing was filmed every vehicle counts as visible: direction and speed can be scored from the truth's places.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import radians

import numpy as np

from bench.matching import match
from bench.recording import RecordedStep, Recording
from bench.scores import Score
from bench.scoring.ground import rms
from bench.scoring.population import best_fractions
from contracts import BoolArray, Compass, FloatArray, IntArray, Motions, MotionState
from contracts.motion import compass
from contracts.truth import Truth

STANDING_MPS, TRAVELLING_MPS = 1e-3, 0.02
SETTLE_S = 0.7
MARGIN_RAD = radians(5.0)
SIGMAS_90 = 1.6448536269514722  # 90 % of a normal distribution lie within so many standard deviations


@dataclass(frozen=True, eq=False)
class Course:
    """One vehicle in the F frames in which it was found, with what was said of its motion.

    time_ns: (F,). velocities_mps: (F, 2) true. states, directions: F of each, as stated.
    headings_rad, speeds_mps: (F,) as stated, NaN where unknown; with their sigmas.
    """

    time_ns: IntArray
    velocities_mps: FloatArray
    states: tuple[MotionState, ...]
    directions: tuple[Compass | None, ...]
    headings_rad: FloatArray
    heading_sigmas_rad: FloatArray
    speeds_mps: FloatArray
    speed_sigmas_mps: FloatArray

    @property
    def true_speeds_mps(self) -> FloatArray:
        """(F,)."""
        return np.asarray(np.hypot(self.velocities_mps[:, 0], self.velocities_mps[:, 1]))

    @property
    def true_headings_rad(self) -> FloatArray:
        """(F,) of the velocity; means nothing where the vehicle stands."""
        return np.asarray(np.arctan2(self.velocities_mps[:, 1], self.velocities_mps[:, 0]))

    @property
    def travels(self) -> BoolArray:
        """(F,)."""
        return np.asarray(self.true_speeds_mps >= TRAVELLING_MPS)

    @property
    def stands(self) -> BoolArray:
        """(F,)."""
        return np.asarray(self.true_speeds_mps < STANDING_MPS)

    @property
    def settled(self) -> BoolArray:
        """(F,) where an answer is asked for, as the module's documentation says."""
        settle_ns = round(SETTLE_S * 1e9)
        kinds = self.travels.astype(np.int8) - self.stands  # 1 travels, 0 crawls, -1 stands
        fresh = np.ones(len(self.time_ns), np.bool_)
        fresh[1:] = (np.diff(self.time_ns) > settle_ns) | (np.diff(kinds) != 0)
        fresh[1:] |= (self.velocities_mps[1:] * self.velocities_mps[:-1]).sum(axis=1) < 0
        since_ns = np.maximum.accumulate(np.where(fresh, self.time_ns, self.time_ns[:1]))
        return np.asarray(self.time_ns - since_ns >= settle_ns)


def direction_scores(recording: Recording, gate_m: float) -> list[Score]:
    """Direction, heading, standing and speed, with the coverage of their stated uncertainties.

    ``direction.correct``: share of settled travelling frames with the right compass direction; unknown is not right.
    ``direction.flips``: changes of direction stated beyond those that are true, summed over the vehicles.
    ``direction.standing_correct``: share of settled standing frames that are said to stand.
    ``heading``: settled travelling frames with a stated heading. ``speed``: settled frames with a stated speed.
    Coverage: share of travelling frames within the central 90 % of the stated normal distribution.
    """
    course = courses(recording, gate_m)
    right = _joined([_right(one)[one.settled & one.travels] for one in course])
    still = _joined([_still(one)[one.settled & one.stands] for one in course])
    headings = _joined([_heading_errors(one) for one in course]).reshape(-1, 2)
    speeds = _joined([_speed_errors(one) for one in course]).reshape(-1, 3)
    travelling = speeds[speeds[:, 2] > 0]
    angles = np.abs(headings[:, 0])
    p95 = float(np.quantile(angles, 0.95)) if len(angles) else float("nan")
    rows = sum(len(one.time_ns) for one in course)
    return [
        _share("direction.correct", right),
        Score.of("direction.flips", sum(_flips(one) for one in course), "count", rows),
        _share("direction.standing_correct", still),
        Score.of("direction.heading_rms_rad", rms(angles), "rad", len(angles)),
        Score.of("direction.heading_p95_rad", p95, "rad", len(angles)),
        _share("direction.heading_coverage_90", angles <= SIGMAS_90 * headings[:, 1]),
        Score.of("speed.rms_mps", rms(speeds[:, 0]), "m/s", len(speeds)),
        _share("speed.coverage_90", np.abs(travelling[:, 0]) <= SIGMAS_90 * travelling[:, 1]),
    ]


def courses(recording: Recording, gate_m: float) -> list[Course]:
    """The course of every vehicle that was found at least once."""
    rows: dict[str, list[tuple[Truth, int, Motions, int]]] = {}
    for step in recording.steps:
        for truth, thing, said in _found(step, gate_m):
            rows.setdefault(truth.ids[thing], []).append((truth, thing, step.motions, said))
    return [_course(found) for found in rows.values()]


def _found(step: RecordedStep, gate_m: float) -> list[tuple[Truth, int, int]]:
    """Truth, its row, and the row of the motions, of every hit; a track without a motion is unknown to the analyst."""
    truth, ground = step.truth, step.fused
    if truth is None:
        return []
    fractions = best_fractions(truth) if truth.cameras else np.ones(len(truth.ids))
    estimates_m = np.where(ground.valid[:, None], ground.positions_m, np.nan)
    hits = match(truth.positions_m[:, :2], estimates_m, fractions=fractions, gate_m=gate_m).hits
    place = {identity: k for k, identity in enumerate(step.motions.ids.tolist())}
    return [(truth, thing, place.get(int(ground.ids[row]), -1)) for thing, row in hits.tolist()]


def _course(found: Sequence[tuple[Truth, int, Motions, int]]) -> Course:
    def column(name: str) -> FloatArray:
        values = {id(motions): getattr(motions, name) for _, _, motions, _ in found}
        return np.array([values[id(motions)][said] if said >= 0 else np.nan for _, _, motions, said in found])

    return Course(
        time_ns=np.array([truth.time_ns for truth, _, _, _ in found], dtype=np.int64),
        velocities_mps=np.array([truth.velocities_mps[thing] for truth, thing, _, _ in found]),
        states=tuple(m.states[said] if said >= 0 else MotionState.UNKNOWN for _, _, m, said in found),
        directions=tuple(m.directions[said] if said >= 0 else None for _, _, m, said in found),
        headings_rad=column("headings_rad"),
        heading_sigmas_rad=column("heading_sigmas_rad"),
        speeds_mps=column("speeds_mps"),
        speed_sigmas_mps=column("speed_sigmas_mps"),
    )


def _right(course: Course) -> BoolArray:
    near = ((heading - MARGIN_RAD, heading, heading + MARGIN_RAD) for heading in course.true_headings_rad.tolist())
    accepted = [{compass(heading) for heading in headings} for headings in near]
    return np.array([said in known for said, known in zip(course.directions, accepted, strict=True)], np.bool_)


def _still(course: Course) -> BoolArray:
    return np.array([state == MotionState.STANDING for state in course.states], np.bool_)


def _flips(course: Course) -> int:
    true = [compass(h) for h, t in zip(course.true_headings_rad.tolist(), course.travels.tolist(), strict=True) if t]
    stated = [direction for direction in course.directions if direction is not None]
    return max(0, _changes(stated) - _changes(true))


def _changes(directions: Sequence[Compass]) -> int:
    return sum(a != b for a, b in pairwise(directions))


def _heading_errors(course: Course) -> FloatArray:
    """(K, 2) error in (-pi, pi] and stated sigma."""
    rows = course.settled & course.travels & np.isfinite(course.headings_rad)
    turned = course.headings_rad[rows] - course.true_headings_rad[rows]
    errors = np.arctan2(np.sin(turned), np.cos(turned))
    return np.column_stack([errors, course.heading_sigmas_rad[rows]])


def _speed_errors(course: Course) -> FloatArray:
    """(K, 3) error, stated sigma, and 1 where the vehicle travels."""
    rows = course.settled & (course.travels | course.stands) & np.isfinite(course.speeds_mps)
    errors = course.speeds_mps[rows] - course.true_speeds_mps[rows]
    return np.column_stack([errors, course.speed_sigmas_mps[rows], course.travels[rows]])


def _share(name: str, held: BoolArray | FloatArray) -> Score:
    n = len(held)
    return Score.of(name, float(held.mean()) if n else float("nan"), "1", n)


def _joined(parts: Sequence[BoolArray | FloatArray]) -> FloatArray:
    return np.concatenate([np.empty(0), *(part.reshape(-1) for part in parts)]).astype(np.float64)
