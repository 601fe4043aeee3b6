"""Where a thing is and how fast, right now: a parabola through its latest places, as long as a parabola will do.

A short window of places follows every curve but is noisy; a long one is quiet but lags where the motion changes. So the
parabola is fitted to several windows that all end now, and the longest is taken whose velocity agrees with that of
every shorter one. Nothing has to be known of the vehicles: neither how they accelerate nor how tight the curves are.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from contracts import FloatArray, InputError, IntArray

MIN_PLACES = 4  # one more than a parabola needs, so that the places can contradict it
FULL = 0.8  # share of its window that the places must span
EXACT_M = 1e-7  # a place known exactly, as an oracle's is, counts as known to a tenth of a micrometre
_ORDER = 3  # position, velocity, acceleration
_VELOCITY = slice(2, 4)  # in the parameters: position (2), velocity (2), acceleration (2)
_MOTION = slice(2, 6)


@dataclass(frozen=True, eq=False)
class Fit:
    """A parabola p(t) = p + v t + a t^2 / 2 through the places of one window, t = 0 at the newest.

    parameters: (6,) position, velocity, acceleration; metres and seconds.
    covariance: (6, 6) if the places scatter about the parabola as they state.
    misfit: by how much their squares exceed that, per degree of freedom; 1 where they do not.
    span_s: time between the oldest and the newest place.
    displacement_m, displacement_cov_m2: (2,) from the oldest to the newest place, and (2, 2) its covariance.
    """

    parameters: FloatArray
    covariance: FloatArray
    misfit: float
    span_s: float
    displacement_m: FloatArray
    displacement_cov_m2: FloatArray

    @property
    def velocity_mps(self) -> FloatArray:
        """(2,) at the newest place: the tangent there, not the chord of the window."""
        return self.parameters[_VELOCITY]

    @property
    def velocity_cov_m2ps2(self) -> FloatArray:
        """(2, 2), widened by the misfit: places that are off, or no parabola (Birge 1932, Phys. Rev. 40, 207)."""
        return self.misfit * self.covariance[_VELOCITY, _VELOCITY]

    @property
    def velocity_square(self) -> float:
        """Squared Mahalanobis distance of the velocity from none: chi-square with 2 degrees of freedom at rest."""
        return _square(self.velocity_mps, self.velocity_cov_m2ps2)

    @property
    def motion_square(self) -> float:
        """That of velocity and acceleration together, not widened: chi-square with 4 degrees of freedom at rest."""
        return _square(self.parameters[_MOTION], self.covariance[_MOTION, _MOTION])

    def displacement_sigmas(self, direction: FloatArray) -> float:
        """How far the displacement points along ``direction`` (2,), in its own standard deviations."""
        return float(direction @ self.displacement_m / np.sqrt(direction @ self.displacement_cov_m2 @ direction))


def parabolas(
    times_ns: IntArray, places_m: FloatArray, covs_m2: FloatArray, windows_s: Sequence[float]
) -> list[Fit | None]:
    """The weighted least-squares parabola of each window, the windows in rising order; None where it is not full.

    times_ns: (K,) rising. places_m: (K, 2). covs_m2: (K, 2, 2) positive semidefinite, errors independent from place to
    place. A window is full if its places span most of it and are at least ``MIN_PLACES``.
    Raises InputError if the arrays do not fit each other or times do not rise.
    """
    n = len(times_ns)
    if places_m.shape != (n, 2) or covs_m2.shape != (n, 2, 2) or n == 0 or (np.diff(times_ns) <= 0).any():
        raise InputError("a parabola needs rising times (K,) with places (K, 2) and covariances (K, 2, 2), K > 0")
    ago_s = (times_ns[::-1] - times_ns[-1]) / 1e9  # (K,) from the newest back: 0, -0.04, ...
    counts = np.searchsorted(-ago_s, np.asarray(windows_s) * (1 + 1e-9), side="right")
    spans_s = -ago_s[counts - 1]
    unit_s = max(float(-ago_s[-1]), 1e-9)  # times in units of the longest span keep the equations well-conditioned
    powers = np.array([np.ones(n), ago_s / unit_s, (ago_s / unit_s) ** 2 / 2])  # (3, K)
    weights = np.linalg.inv(covs_m2[::-1] + EXACT_M**2 * np.eye(2))  # (K, 2, 2)
    moved_m = places_m[::-1] - places_m[-1]
    weighted = np.einsum("kab,kb->ka", weights, moved_m)  # (K, 2)
    squares = (weighted * moved_m).sum(axis=1).cumsum()  # (K,)
    normal = np.einsum("pk,qk,kab->kpaqb", powers, powers, weights).reshape(n, 6, 6).cumsum(axis=0)
    right = np.einsum("pk,ka->kpa", powers, weighted).reshape(n, 6).cumsum(axis=0)
    to_seconds = np.repeat(unit_s ** -np.arange(_ORDER, dtype=np.float64), 2)  # (6,)
    offset = np.concatenate([places_m[-1], np.zeros(4)])
    fits: list[Fit | None] = []
    for count, span_s, window_s in zip(counts.tolist(), spans_s.tolist(), windows_s, strict=True):
        if count < MIN_PLACES or span_s < FULL * window_s:
            fits.append(None)
            continue
        covariance = np.linalg.inv(normal[count - 1])
        scaled = covariance @ right[count - 1]
        residual = float(squares[count - 1] - scaled @ right[count - 1])
        misfit = max(1.0, residual / (2 * count - 6))
        parameters = to_seconds * scaled + offset
        covariance = 0.5 * (covariance + covariance.T) * np.outer(to_seconds, to_seconds)
        chord_m, chord_cov_m2 = places_m[-1] - places_m[-count], covs_m2[-1] + covs_m2[-count] + EXACT_M**2 * np.eye(2)
        fits.append(Fit(parameters, covariance, misfit, span_s, chord_m, chord_cov_m2))
    return fits


def longest_that_agrees(fits: Sequence[Fit], confidence: float) -> Fit:
    """The longest window of ``fits`` (rising) whose velocity agrees with every shorter one's, up to the first that not.

    The shorter window is part of the longer, so the covariance of the difference is the difference of the covariances
    (Hausman 1978, Specification tests in econometrics, cor. 2.6). The rule that stops at the first contradiction is
    Lepski's (1991), here with ``confidence`` that windows of one parabola agree.
    """
    bound = float(chi2.ppf(confidence, df=2))
    chosen = fits[0]
    for k, longer in enumerate(fits[1:], start=1):
        if any(_disagreement(shorter, longer) > bound for shorter in fits[:k]):
            break
        chosen = longer
    return chosen


def _disagreement(shorter: Fit, longer: Fit) -> float:
    if longer.span_s <= shorter.span_s:
        return 0.0  # the same places
    apart = shorter.velocity_mps - longer.velocity_mps
    return _square(apart, (shorter.covariance - longer.covariance)[_VELOCITY, _VELOCITY])


def _square(value: FloatArray, covariance: FloatArray) -> float:
    return float(value @ np.linalg.solve(covariance, value))
