"""Direction and speed from places on the ground: paper R's displacement over a longer time, with its uncertainty."""

from collections import deque
from dataclasses import dataclass, field, replace
from math import cos, radians

import numpy as np
from scipy.stats import chi2

from contracts import Compass, FloatArray, GroundTracks, InputError, Motions, MotionState
from contracts.motion import compass
from georef.velocity import Fit, longest_that_agrees, parabolas

WINDOWS_S = (0.2, 0.3, 0.45, 0.7, 1.0)  # each about half as long again as the one before
STANDING_S = 0.45  # no shorter time without motion is called standing
CONFIRM_S = 0.08  # a motion must last so long before it is believed: a place that is off for a frame starts nothing
PLACES = 240  # kept of one object at most
AGREE = 0.95  # confidence that windows of one parabola agree
_START = float(chi2.isf(1e-6, df=2))  # squared Mahalanobis distance of the velocity from none that means motion
_ALONG = 3.0  # sigmas by which the displacement over the shortest window must point along that velocity
_REST = float(chi2.ppf(0.95, df=4))  # that of velocity and acceleration below which nothing moves
_KEEP = cos(radians(45.0 + 3.0))  # a direction is kept until the heading lies 3 degrees beyond its sector


@dataclass(frozen=True)
class _Said:
    """What was said of an object last. since_ns: when it seemed to begin to move, until that is believed."""

    state: MotionState = MotionState.UNKNOWN
    direction: Compass | None = None
    since_ns: int | None = None


@dataclass(eq=False)
class _Memory:
    """The latest places of one object: (time_ns, place (2,), covariance (2, 2)), oldest first."""

    places: deque[tuple[int, FloatArray, FloatArray]] = field(default_factory=lambda: deque(maxlen=PLACES))
    said: _Said = field(default_factory=_Said)


class WindowAnalyst:
    """Velocity, state and compass direction of every object; implements ``contracts.Analyst``.

    The velocity is the tangent, at this moment, of the curve of ``georef.velocity``: on a curve it lags behind
    nothing. An object moves once its velocity stands out of its own uncertainty for ``CONFIRM_S`` and the displacement
    over the shortest window points the same way (a parabola across a dead stop swings back; the places do not). It
    stands once the places of the last ``STANDING_S`` agree with rest. In between it keeps what it was. So noise starts
    nothing. The direction follows the heading with 3 degrees of inertia: on the diagonal it does not chatter.

    Only times and places count, never numbers of frames: gaps do no harm. What is older than the longest window is
    forgotten, and so is an object without a place for that long.
    """

    def __init__(self) -> None:
        self._memories: dict[int, _Memory] = {}
        self._time_ns: int | None = None

    def reset(self) -> None:
        """Forget all moments."""
        self._memories.clear()
        self._time_ns = None

    def analyse(self, ground: GroundTracks) -> Motions:
        """How the objects of ``ground`` move; an object seen for less than the shortest window is unknown.

        Raises InputError if ``ground`` is not later than the moment before, an identity occurs twice, or a covariance
        of a valid place is no covariance.
        """
        self._check(ground)
        self._forget(ground.time_ns)
        rows = [self._row(ground, k) for k in range(len(ground))]
        unknown = Motions.unknown(ground)
        velocities, covs = unknown.velocities_mps.copy(), unknown.velocity_covs_m2ps2.copy()
        for k, (fit, _) in enumerate(rows):
            if fit is not None:
                velocities[k], covs[k] = fit.velocity_mps, fit.velocity_cov_m2ps2
        return replace(
            unknown,
            velocities_mps=velocities,
            velocity_covs_m2ps2=covs,
            states=tuple(said.state for _, said in rows),
            directions=tuple(said.direction for _, said in rows),
            valid=np.array([fit is not None for fit, _ in rows], np.bool_),
        )

    def _check(self, ground: GroundTracks) -> None:
        if self._time_ns is not None and ground.time_ns <= self._time_ns:
            raise InputError(f"moments must rise: {ground.time_ns} ns follows {self._time_ns} ns; reset() begins anew")
        if len(set(ground.ids.tolist())) < len(ground):
            raise InputError(f"an identity occurs twice at {ground.time_ns} ns: {ground.ids.tolist()}")
        places, covs = ground.positions_m[ground.valid], ground.covs_m2[ground.valid]
        if not (np.isfinite(places).all() and np.isfinite(covs).all()):
            raise InputError(f"a valid place at {ground.time_ns} ns, or its covariance, is not finite")
        if len(covs) and np.linalg.eigvalsh(covs).min() < -1e-12:
            raise InputError(f"a covariance of the places at {ground.time_ns} ns is negative")
        self._time_ns = ground.time_ns

    def _forget(self, time_ns: int) -> None:
        oldest_ns = time_ns - round(WINDOWS_S[-1] * 1e9)
        for identity, memory in list(self._memories.items()):
            while memory.places and memory.places[0][0] < oldest_ns:
                memory.places.popleft()
            if not memory.places:
                del self._memories[identity]

    def _row(self, ground: GroundTracks, row: int) -> tuple[Fit | None, _Said]:
        """The fit and what is said of one object; of one without a place nothing is known at this moment."""
        if not ground.valid[row]:
            return None, _Said()
        memory = self._memories.setdefault(int(ground.ids[row]), _Memory())
        memory.places.append((ground.time_ns, ground.positions_m[row], ground.covs_m2[row]))
        times_ns, places_m, covs_m2 = (np.array(column) for column in zip(*memory.places, strict=True))
        by_window = dict(zip(WINDOWS_S, parabolas(times_ns, places_m, covs_m2, WINDOWS_S), strict=True))
        fits = [fit for fit in by_window.values() if fit is not None]
        if not fits:
            return None, _Said()
        fit = longest_that_agrees(fits, AGREE)
        moves = fit.velocity_square > _START and fits[0].displacement_sigmas(fit.velocity_mps) > _ALONG
        standing = by_window[STANDING_S]
        rests = standing is not None and standing.motion_square < _REST
        memory.said = _judged(memory.said, fit.velocity_mps, moves=moves, rests=rests, time_ns=ground.time_ns)
        return fit, memory.said


def _judged(before: _Said, velocity_mps: FloatArray, *, moves: bool, rests: bool, time_ns: int) -> _Said:
    """What is said now, after ``before``, of an object that seems to move, or to rest, or neither."""
    if moves:
        since_ns = time_ns if before.since_ns is None else before.since_ns
        if before.state is not MotionState.MOVING and time_ns - since_ns < CONFIRM_S * 1e9:
            return replace(before, since_ns=since_ns)
        return _Said(MotionState.MOVING, _direction(before.direction, velocity_mps), since_ns)
    if rests:
        return _Said(MotionState.STANDING)
    return replace(before, since_ns=None)


def _direction(before: Compass | None, velocity_mps: FloatArray) -> Compass:
    heading_rad = float(np.arctan2(velocity_mps[1], velocity_mps[0]))
    if before is not None and cos(heading_rad - before.heading_rad) > _KEEP:
        return before
    return compass(heading_rad)
