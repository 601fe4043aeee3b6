"""The pieces that track is laid from: line, turn, shift on to a parallel track, and the arcs that close a gap."""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np

from contracts import FloatArray, InputError
from rail.curves import Bend, Pose2


def line(length_m: float) -> tuple[Bend, ...]:
    """Straight track."""
    return (Bend(length_m),)


def turn(angle_rad: float, radius_m: float, ease_m: float = 0.0) -> tuple[Bend, ...]:
    """An arc to the left (positive angle) or right, with a clothoid of ``ease_m`` at either end if that is positive.

    The clothoids take their share of the angle, so the whole turns by ``angle_rad``.
    """
    if not (radius_m > 0 and ease_m >= 0 and angle_rad != 0):
        raise InputError(
            f"a turn needs an angle, a positive radius and no negative ease: {angle_rad}, {radius_m}, {ease_m}"
        )
    arc_m = abs(angle_rad) * radius_m - ease_m
    if arc_m <= 0:
        raise InputError(f"ease_m = {ease_m} is too long for a turn of {abs(angle_rad):.3f} rad at {radius_m} m radius")
    k = 1.0 / radius_m if angle_rad > 0 else -1.0 / radius_m
    if ease_m == 0:
        return (Bend(arc_m, k, k),)
    return Bend(ease_m, 0.0, k), Bend(arc_m, k, k), Bend(ease_m, k, 0.0)


def shift(left_m: float, radius_m: float) -> tuple[Bend, ...]:
    """A pair of equal arcs on to the parallel track ``left_m`` to the left (negative: right)."""
    if not 0 < abs(left_m) < 2 * radius_m:
        raise InputError(f"a shift by {left_m} m takes a radius above {abs(left_m) / 2} m and not {radius_m} m")
    cosine = 1.0 - abs(left_m) / (2.0 * radius_m)
    angle = atan2(sqrt(1.0 - cosine * cosine), cosine)
    k = 1.0 / radius_m if left_m > 0 else -1.0 / radius_m
    return Bend(angle * radius_m, k, k), Bend(angle * radius_m, -k, -k)


def biarc(start: Pose2, end: Pose2) -> tuple[Bend, ...]:
    """Two arcs from ``start`` to ``end`` that meet without a kink; a straight line if the poses are in line.

    Source: Bolton 1975, Biarc curves, with equal tangent lengths.
    """
    v = np.array([end.x_m - start.x_m, end.y_m - start.y_m])
    t1 = np.array([cos(start.heading_rad), sin(start.heading_rad)])
    t2 = np.array([cos(end.heading_rad), sin(end.heading_rad)])
    along, square = float(v @ (t1 + t2)), float(v @ v)
    denominator = along + sqrt(max(0.0, along * along + 2.0 * (1.0 - float(t1 @ t2)) * square))
    if square == 0.0 or denominator <= 1e-9 * sqrt(square):
        raise InputError(f"no pair of arcs leads from {start} to {end}; the end must lie ahead")
    tangent_m = square / denominator
    first = v / 2.0 + tangent_m * (t1 - t2) / 2.0  # from the start to the meeting point
    return _arc(first, t1, from_start=True), _arc(v - first, t2, from_start=False)


def _arc(chord: FloatArray, tangent: FloatArray, *, from_start: bool) -> Bend:
    """The arc over ``chord`` that has ``tangent`` at its start, or at its end."""
    cross = float(tangent[0] * chord[1] - tangent[1] * chord[0]) * (1.0 if from_start else -1.0)
    half_turn = atan2(cross, float(tangent @ chord))
    chord_m = hypot(*chord)
    k = 2.0 * sin(half_turn) / chord_m
    return Bend(chord_m / float(np.sinc(half_turn / pi)), k, k)
