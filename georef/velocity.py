"""Where a thing is and how fast, right now: a curve through its latest places, as long as one such curve will do.

A short window of places follows every curve but is noisy; a long one is quiet but lags where the motion changes. So the
parabola is fitted to several windows that all end now, and the longest is taken whose velocity agrees with that of
every shorter one. Nothing has to be known of the vehicles: neither how they accelerate nor how tight the curves are.

What turns evenly runs on a circle, and the tangent at a parabola's end would be too fast by millimetres per second: the
parabola tells the circle, and the places are freed from what lies between the two before it is fitted for good.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.stats import chi2

from contracts import FloatArray, InputError, IntArray

MIN_PLACES = 4  # one more than a parabola needs, so that the places can contradict it
FULL = 0.8  # share of its window that the places must span
EXACT_M = 1e-7  # a place known exactly, as an oracle's is, counts as known to a tenth of a micrometre
LASTING_SHARE, LASTING_S = 0.6, 0.1  # of a place's error that is still there, fading, at the next; from training films
ALIKE_M = 20.0  # way on which an error that places share, as by calibration, changes by its own size
_MILLIONTH, _NO_SCATTER = 1e-6, 1e-9  # chance that is none; scatter of places without any error
_ORDER = 3  # position, velocity, acceleration
_TURNS = 25.0  # squared Mahalanobis distance of the velocity from none, from which its turning means something
_CIRCLES = 4  # rounds: the first circle is told by a parabola through places that are not freed yet
_LEAST_TURN_RAD, _LARGEST_TURN_RAD = (
    1e-4,
    1.5,
)  # in a window; less is rounding, and of more no parabola tells the circle
_VELOCITY = slice(2, 4)  # in the parameters: position (2), velocity (2), acceleration (2)
_MOTION = slice(2, 6)


@dataclass(frozen=True, eq=False)
class Fit:
    """A parabola p(t) = p + v t + a t^2 / 2, or its circle, through the places of one window, t = 0 at the newest.

    parameters: (6,) position, velocity, acceleration; metres and seconds.
    covariance: (6, 6) from what the places err by themselves, each apart from the others: windows are compared by it.
    lasting_m2ps2: (2, 2) of the velocity, from the same, a share of which lasts from place to place.
    shared_m2: (2, 2) of the newest place, by which all places err together.
    misfit: by how much the places scatter more than they state, in squares per degree of freedom; at least 1.
    span_s: time between the oldest and the newest place.
    displacement_m, displacement_cov_m2: (2,) from the oldest to the newest place, and (2, 2) its covariance.
    """

    parameters: FloatArray
    covariance: FloatArray
    lasting_m2ps2: FloatArray
    shared_m2: FloatArray
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
        """(2, 2), widened by the misfit: places that are off, or another curve (Birge 1932, Phys. Rev. 40, 207).

        A shared error counts by what of it changes while the thing moves on.
        """
        changing = float(self.velocity_mps @ self.velocity_mps) / ALIKE_M**2
        return self.misfit * self.lasting_m2ps2 + changing * self.shared_m2

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
    """The weighted least-squares curve of each window, the windows in rising order; None where it is not full.

    Places that scatter less than chance allows err together, as by their camera's calibration, and what each errs by
    itself is as small as the scatter tells. A shared error changes slowly along the way: see ``ALIKE_M``.

    times_ns: (K,) rising. places_m: (K, 2). covs_m2: (K, 2, 2) positive semidefinite. A window is full if
    its places span most of it and are at least ``MIN_PLACES``.
    Raises InputError if the arrays do not fit each other or times do not rise.
    """
    n = len(times_ns)
    if places_m.shape != (n, 2) or covs_m2.shape != (n, 2, 2) or n == 0 or (np.diff(times_ns) <= 0).any():
        raise InputError("a parabola needs rising times (K,) with places (K, 2) and covariances (K, 2, 2), K > 0")
    sums = _Sums.of(times_ns, places_m, covs_m2)
    counts = np.searchsorted(-sums.ago_s, np.asarray(windows_s) * (1 + 1e-9), side="right")
    spans_s = -sums.ago_s[counts - 1]
    is_full = (counts >= MIN_PLACES) & (spans_s >= FULL * np.asarray(windows_s))
    solved = [
        sums.fitted(count) if full else None for count, full in zip(counts.tolist(), is_full.tolist(), strict=True)
    ]
    own = min([1.0, *(one.scatter / _least_scatter(one.freedom) for one in solved if one is not None)])
    fits: list[Fit | None] = []
    for count, one in zip(counts.tolist(), solved, strict=True):
        if one is None:
            fits.append(None)
            continue
        lasting = _lasting(sums.velocity_gain(one.inverse, count), sums.weights[:count], sums.ago_s[:count])
        chord_cov_m2 = covs_m2[-1] + covs_m2[-count] + EXACT_M**2 * np.eye(2)
        fits.append(
            Fit(
                one.parameters + np.concatenate([places_m[-1], np.zeros(4)]),
                own * sums.in_seconds(one.inverse),
                own * lasting,
                (1 - own) * covs_m2[-1],
                max(1.0, one.scatter / own),
                float(-sums.ago_s[count - 1]),
                places_m[-1] - places_m[-count],
                own * chord_cov_m2,
            )
        )
    return fits


@lru_cache(maxsize=512)
def _least_scatter(freedom: int) -> float:
    """Mean square of ``freedom`` standard normal numbers, below which it lies once in a million times."""
    return float(chi2.ppf(_MILLIONTH, df=freedom)) / freedom


@dataclass(frozen=True, eq=False)
class _Solved:
    """parameters: (6,) from the newest place. inverse: (6, 6) of the normal matrix, in units of time.

    scatter: mean square of the places about the curve, over what they state. freedom: degrees of it.
    """

    parameters: FloatArray
    inverse: FloatArray
    scatter: float
    freedom: int


@dataclass(frozen=True, eq=False)
class _Sums:
    """The least-squares problems of all windows that end at the newest place, the k-th of k + 1 places.

    ago_s: (K,) 0 and falling. moved_m: (K, 2) from the newest place. weights: (K, 2, 2) inverse covariances.
    unit_s: times are counted in it, that the equations stay well-conditioned. powers: (3, K) of the times.
    normal: (K, 6, 6), right: (K, 6), squares: (K,) summed up.
    """

    ago_s: FloatArray
    moved_m: FloatArray
    weights: FloatArray
    unit_s: float
    powers: FloatArray
    normal: FloatArray
    right: FloatArray
    squares: FloatArray

    @classmethod
    def of(cls, times_ns: IntArray, places_m: FloatArray, covs_m2: FloatArray) -> "_Sums":
        """From places in the order of time."""
        n, ago_s = len(times_ns), (times_ns[::-1] - times_ns[-1]) / 1e9
        unit_s = max(float(-ago_s[-1]), 1e-9)
        powers = np.array([np.ones(n), ago_s / unit_s, (ago_s / unit_s) ** 2 / 2])
        weights = np.asarray(np.linalg.inv(covs_m2[::-1] + EXACT_M**2 * np.eye(2)), np.float64)
        moved_m = places_m[::-1] - places_m[-1]
        weighted = np.einsum("kab,kb->ka", weights, moved_m)
        normal = np.einsum("pk,qk,kab->kpaqb", powers, powers, weights).reshape(n, 6, 6).cumsum(axis=0)
        right = np.einsum("pk,ka->kpa", powers, weighted).reshape(n, 6).cumsum(axis=0)
        return cls(ago_s, moved_m, weights, unit_s, powers, normal, right, (weighted * moved_m).sum(axis=1).cumsum())

    def in_seconds(self, inverse: FloatArray) -> FloatArray:
        """(6, 6) symmetric, from units of time."""
        return np.asarray(0.5 * (inverse + inverse.T) * np.outer(self._seconds, self._seconds))

    @property
    def _seconds(self) -> FloatArray:
        return np.repeat(self.unit_s ** -np.arange(_ORDER, dtype=np.float64), 2)

    def fitted(self, count: int) -> _Solved:
        """Through the newest ``count`` places."""
        inverse, right, square = np.linalg.inv(self.normal[count - 1]), self.right[count - 1], self.squares[count - 1]
        scaled, residual = inverse @ right, float(square - right @ inverse @ right)
        for _ in range(_CIRCLES):
            covariance = self.in_seconds(inverse)
            bent_m = _circle_less_parabola(self._seconds * scaled, covariance, self.ago_s[:count])
            bent = np.einsum("kab,kb->ka", self.weights[:count], bent_m)
            freed = right - np.einsum("pk,ka->pa", self.powers[:, :count], bent).ravel()
            scaled = inverse @ freed
            residual = float(square + (bent * (bent_m - 2 * self.moved_m[:count])).sum() - scaled @ freed)
        freedom = 2 * count - 6
        return _Solved(self._seconds * scaled, inverse, max(residual / freedom, _NO_SCATTER), freedom)

    def velocity_gain(self, inverse: FloatArray, count: int) -> FloatArray:
        """(2, K, 2) by which each place moves the velocity."""
        rows = np.einsum("pk,kab->pakb", self.powers[:, :count], self.weights[:count]).reshape(6, 2 * count)
        return np.asarray((inverse[_VELOCITY] @ rows / self.unit_s).reshape(2, count, 2))


def _lasting(gain: FloatArray, weights: FloatArray, times_s: FloatArray) -> FloatArray:
    """(2, 2) covariance of a velocity gain (2, K, 2) times the places, a share of whose errors fades with time.

    weights: (K, 2, 2) inverse covariances of the places. times_s: (K,).
    """
    scaled = np.einsum("ikb,kbc->ikc", gain, np.linalg.cholesky(np.linalg.inv(weights)))
    alike = LASTING_SHARE * np.exp(-np.abs(times_s[:, None] - times_s) / LASTING_S)
    np.fill_diagonal(alike, 1.0)
    covariance = np.einsum("ikc,kl,jlc->ij", scaled, alike, scaled)
    return np.asarray(0.5 * (covariance + covariance.T))


def _circle_less_parabola(parameters: FloatArray, covariance: FloatArray, times_s: FloatArray) -> FloatArray:
    """(K, 2) metres by which a circle departs from the parabola of the same position, velocity and turn at t = 0.

    parameters: (6,), covariance: (6, 6). times_s: (K,). Nothing where the thing hardly moves or turns too far.
    """
    velocity, acceleration = parameters[_VELOCITY], parameters[4:]
    left = np.array([-velocity[1], velocity[0]])
    square = float(velocity @ velocity)
    none = np.zeros((len(times_s), 2))
    if square == 0.0 or _square(velocity, covariance[_VELOCITY, _VELOCITY]) < _TURNS:
        return none
    turn_radps = float(left @ acceleration) / square
    turned = turn_radps * times_s
    if not _LEAST_TURN_RAD < np.abs(turned).max() <= _LARGEST_TURN_RAD:
        return none
    ahead_s, aside_s = np.sin(turned) / turn_radps - times_s, (1 - np.cos(turned)) / turn_radps - turned * times_s / 2
    return np.asarray(np.outer(ahead_s, velocity) + np.outer(aside_s, left))


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
