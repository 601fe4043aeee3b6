"""Which estimate belongs to which object: by position on the ground, and by nothing else.

In one frame of one source (a camera, or all of them fused) the objects of the truth fall into three classes by the
fraction ``f`` of them that is visible - in that camera, or for the fused positions in the camera that sees most:

    target    f >= 0.8       must be found
    ignored   0 < f < 0.8    may be found: an estimate matched to one is neither a hit nor a false alarm
    absent    f == 0         is not there: takes part in nothing

Targets and ignored objects are assigned to estimates together, one to one, so that the sum of the distances is
smallest, where every object or estimate that stays alone costs half the gate: the assignment of GOSPA with p = 1 and
alpha = 2 (Rahmathullah, Garcia-Fernandez & Svensson 2017, eq. 1 and prop. 1). No pair is farther apart than the gate.
Then:

    hit          a target with an estimate
    miss         a target without one: every visible vehicle is counted
    false alarm  an estimate without any object, and an estimate that has no place on the ground

Labels (colours, classes) and track identities take no part. A vehicle that is found where it is but called by a wrong
name is a hit; ``label.accuracy`` counts wrong names and the ``track.*`` scores count wrong identities.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from contracts import BoolArray, FloatArray, InputError, IntArray

TARGET_FRACTION = 0.8
DEFAULT_GATE_M = 0.060
GATES_M = {"rail": 0.060, "road": 2.0}  # half the length of a vehicle, its whole width


def gate_m(world: str) -> float:
    """Largest distance on the ground between an object and its estimate in ``world``, metres."""
    return GATES_M.get(world, DEFAULT_GATE_M)


@dataclass(frozen=True, eq=False)
class Matching:
    """The outcome for one frame, as row numbers of the objects and of the estimates.

    hits: (K, 2) target, estimate.
    ignored: (I, 2) ignored object, estimate.
    misses: (L,) targets.
    false_alarms: (F,) estimates.
    """

    hits: IntArray
    ignored: IntArray
    misses: IntArray
    false_alarms: IntArray


def match(objects_m: FloatArray, estimates_m: FloatArray, *, fractions: FloatArray, gate_m: float) -> Matching:
    """Match the objects and the estimates of one frame as the module's documentation says.

    objects_m: (N, 2) true positions on the ground.
    estimates_m: (M, 2) estimated positions; NaN where an estimate has no place on the ground.
    fractions: (N,) visible fraction of each object.
    gate_m: largest distance of a pair.
    Raises InputError if the gate is not positive.
    """
    if not gate_m > 0:
        raise InputError(f"the gate of the matching must be positive, got {gate_m} m")
    present = np.flatnonzero(fractions > 0)
    placed = np.flatnonzero(np.isfinite(estimates_m).all(axis=1))
    pairs = nearest_pairs(objects_m[present], estimates_m[placed], gate_m=gate_m)
    pairs = np.column_stack([present[pairs[:, 0]], placed[pairs[:, 1]]])  # (K + I, 2)
    target = is_target(fractions)
    hit = target[pairs[:, 0]]
    return Matching(
        hits=pairs[hit],
        ignored=pairs[~hit],
        misses=np.flatnonzero(target & _without(len(target), pairs[:, 0])),
        false_alarms=np.flatnonzero(_without(len(estimates_m), pairs[:, 1])),
    )


def is_target(fractions: FloatArray) -> BoolArray:
    """Whether so much of an object is visible that it must be found."""
    return np.asarray(fractions >= TARGET_FRACTION)


def nearest_pairs(a_m: FloatArray, b_m: FloatArray, *, gate_m: float) -> IntArray:
    """One-to-one pairs of rows of ``a_m`` (N, 2) and ``b_m`` (M, 2), (K, 2), none farther apart than the gate.

    Minimises the sum of distances where a row that stays alone costs half the gate.
    """
    distances_m = np.linalg.norm(a_m[:, None, :] - b_m[None, :, :], axis=2)  # (N, M)
    rows, columns = linear_sum_assignment(np.minimum(distances_m, gate_m))
    near = distances_m[rows, columns] <= gate_m
    return np.column_stack([rows[near], columns[near]]).astype(np.int64)


def _without(count: int, rows: IntArray) -> BoolArray:
    """A mask (count,) that is False in ``rows``."""
    mask = np.ones(count, dtype=np.bool_)
    mask[rows] = False
    return mask
