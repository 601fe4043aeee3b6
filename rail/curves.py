"""Plane curves of track, parametrised by arc length: lines, arcs and clothoids as one thing, the ``Bend``."""

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import accumulate
from math import ceil, cos, degrees, isfinite, pi, sin, tau

import numpy as np
from numpy.typing import ArrayLike

from contracts import FloatArray, InputError

# Gauss-Legendre nodes on [0, 1]: exact to rounding for the position on a bend that turns by up to a full circle.
_ROOTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)
_NODES = (_ROOTS + 1.0) / 2.0
_NODE_WEIGHTS = _WEIGHTS / 2.0


def wrapped(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    return pi - (pi - angle_rad) % tau


@dataclass(frozen=True)
class Pose2:
    """A point of the ground with a direction: world metres, radians counter-clockwise from east."""

    x_m: float
    y_m: float
    heading_rad: float

    def __str__(self) -> str:
        return f"({self.x_m:.3f}, {self.y_m:.3f}) m heading {degrees(self.heading_rad):.1f} deg"

    def reversed(self) -> "Pose2":
        """The same point, looking back; heading in (-pi, pi]."""
        return Pose2(self.x_m, self.y_m, wrapped(self.heading_rad + pi))

    def offset(self, forward_m: float, left_m: float) -> tuple[float, float]:
        """World x, y of the point so far ahead and to the left."""
        c, s = cos(self.heading_rad), sin(self.heading_rad)
        return self.x_m + c * forward_m - s * left_m, self.y_m + s * forward_m + c * left_m

    def left_of(self, x_m: float, y_m: float) -> float:
        """How far the world point lies to the left, metres; negative to the right."""
        return cos(self.heading_rad) * (y_m - self.y_m) - sin(self.heading_rad) * (x_m - self.x_m)


@dataclass(frozen=True)
class Bend:
    """A piece of track whose curvature grows linearly: a line (0, 0), an arc (k, k), a clothoid (0, k).

    Curvatures in 1/m, positive to the left. A bend turns by a full circle at most.
    """

    length_m: float
    start_curvature_per_m: float = 0.0
    end_curvature_per_m: float = 0.0

    def __post_init__(self) -> None:
        if not (isfinite(self.length_m) and self.length_m > 0):
            raise InputError(f"a bend of {self.length_m} m has no length; give a positive one")
        if not abs(self.turn_rad) <= tau + 1e-9:  # a full circle may round up
            raise InputError(f"a bend that turns by {self.turn_rad:.3f} rad goes round more than once; split it")

    @property
    def turn_rad(self) -> float:
        """Change of heading from start to end."""
        return self.length_m * (self.start_curvature_per_m + self.end_curvature_per_m) / 2.0

    def curvature_at(self, along_m: ArrayLike) -> FloatArray:
        """Curvature in 1/m after ``along_m`` metres."""
        share = np.asarray(along_m, dtype=np.float64) / self.length_m
        return self.start_curvature_per_m + (self.end_curvature_per_m - self.start_curvature_per_m) * share

    def pose_from(self, start: Pose2, along_m: float) -> Pose2:
        """Pose after ``along_m`` metres from ``start``: ``poses_from`` for one point, without NumPy where it can."""
        if self.start_curvature_per_m != self.end_curvature_per_m:
            return Pose2(*self.poses_from(start, along_m).tolist())
        half_turn = self.start_curvature_per_m * along_m / 2.0
        chord_m = along_m * (sin(half_turn) / half_turn if half_turn else 1.0)
        x_m, y_m = Pose2(start.x_m, start.y_m, start.heading_rad + half_turn).offset(chord_m, 0.0)
        return Pose2(x_m, y_m, start.heading_rad + 2.0 * half_turn)

    def poses_from(self, start: Pose2, along_m: ArrayLike) -> FloatArray:
        """Poses (..., 3) x, y, heading after ``along_m`` metres (...) from ``start``: integral of the unit tangent."""
        along = np.asarray(along_m, dtype=np.float64)
        if self.start_curvature_per_m == self.end_curvature_per_m:  # the chord of an arc
            half_turn = self.start_curvature_per_m * along / 2.0
            shift = along * np.sinc(half_turn / pi) * np.exp(1j * (start.heading_rad + half_turn))
        else:
            nodes = along[..., None] * _NODES  # (..., K)
            shift = along * (np.exp(1j * self._headings(start, nodes)) @ _NODE_WEIGHTS)
        return np.stack([start.x_m + shift.real, start.y_m + shift.imag, self._headings(start, along)], axis=-1)

    def _headings(self, start: Pose2, along: FloatArray) -> FloatArray:
        growth = (self.end_curvature_per_m - self.start_curvature_per_m) / self.length_m
        headings: FloatArray = start.heading_rad + along * (self.start_curvature_per_m + along * growth / 2.0)
        return headings


@dataclass(frozen=True)
class Curve:
    """Bends one after the other from ``start``; the heading runs on without a jump and is not wrapped."""

    start: Pose2
    bends: tuple[Bend, ...]
    _offsets_m: tuple[float, ...] = field(init=False, repr=False, compare=False)  # start of each bend, and the end
    _joints: tuple[Pose2, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not self.bends:
            raise InputError("a curve needs at least one bend")
        joints = [self.start]
        for bend in self.bends:
            joints.append(bend.pose_from(joints[-1], bend.length_m))
        object.__setattr__(self, "_joints", tuple(joints))
        object.__setattr__(self, "_offsets_m", tuple(accumulate((b.length_m for b in self.bends), initial=0.0)))

    @property
    def length_m(self) -> float:
        """Length along the curve."""
        return self._offsets_m[-1]

    @property
    def end(self) -> Pose2:
        """Pose at the far end."""
        return self._joints[-1]

    @property
    def min_radius_m(self) -> float:
        """Least radius anywhere; infinite for a straight line."""
        ends = [abs(k) for bend in self.bends for k in (bend.start_curvature_per_m, bend.end_curvature_per_m)]
        return 1.0 / max(ends) if max(ends) > 0 else float("inf")

    def pose_at(self, offset_m: float) -> Pose2:
        """Pose ``offset_m`` metres along the curve; InputError off its ends."""
        index = self._bend_index(offset_m)
        return self.bends[index].pose_from(self._joints[index], offset_m - self._offsets_m[index])

    def poses_at(self, offsets_m: ArrayLike) -> FloatArray:
        """Poses (..., 3) x, y, heading at ``offsets_m`` (...); InputError off the ends."""
        offsets = np.asarray(offsets_m, dtype=np.float64)
        poses = np.empty((*offsets.shape, 3))
        for extreme in (offsets.min(initial=0.0), offsets.max(initial=0.0)):
            self._bend_index(float(extreme))  # refuses what lies off the ends
        indices = np.searchsorted(self._offsets_m[1:-1], offsets, side="right")
        for index in np.unique(indices):
            here = indices == index
            poses[here] = self.bends[index].poses_from(self._joints[index], offsets[here] - self._offsets_m[index])
        return poses

    def curvature_at(self, offset_m: float) -> float:
        """Curvature in 1/m, positive to the left; where it jumps, that of the bend that begins there."""
        index = self._bend_index(offset_m)
        return float(self.bends[index].curvature_at(offset_m - self._offsets_m[index]))

    def points(self, step_m: float) -> FloatArray:
        """Points (N, 2) at equal distances of at most ``step_m``, both ends included."""
        if not step_m > 0:
            raise InputError(f"step_m = {step_m} must be positive")
        return self.poses_at(np.linspace(0.0, self.length_m, ceil(self.length_m / step_m) + 1))[:, :2]

    def _bend_index(self, offset_m: float) -> int:
        if not 0.0 <= offset_m <= self.length_m:
            raise InputError(f"offset {offset_m:.6f} m lies off the curve, which is {self.length_m:.6f} m long")
        return min(bisect_right(self._offsets_m, offset_m), len(self.bends)) - 1
