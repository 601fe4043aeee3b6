"""Robust fitting: good picks with Gaussian noise, among wrong ones whose size is anybody's guess.

Each pick is good with the normal density of its residual, or wrong with a density that is flat in the logarithm of the
error's length. A pick's probability of being good weights it in the fit; noise, share of wrong picks, weights and
parameters settle each other (expectation-maximisation: Dempster, Laird & Rubin 1977). Within three standard deviations
a good pick weighs almost one, so that nothing is lost against least squares; far out the influence goes to nought.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np

from contracts import CalibrationError, FloatArray
from georef.refinement import Linear, inverse_normal, refine

State = TypeVar("State")

_WRONG_SHARE, _WRONG_WEIGHT = 0.1, 10.0  # believed beforehand, and how many picks that belief is worth
_CORE_SIGMAS = 3.0  # wrong picks nearer than this are no more likely for being nearer
_ROUNDS = 80
_SETTLED, _ROUGHLY_SETTLED = 1e-5, 1e-2
_NEGLIGIBLE = 1e-12  # probability; a pick below it is left out, so that its place need not lie before the camera
_LEAST_LEFT = 0.2


@dataclass(frozen=True, eq=False)
class Observed:
    """N picks of d numbers each, as a model sees them at one state.

    residuals: (N, d) px; NaN where the model images the pick nowhere.
    by_parameters: (N, d, p) their derivatives.
    map_covs_px2: (N, d, d) the share of the map's own error.
    """

    residuals: FloatArray
    by_parameters: FloatArray
    map_covs_px2: FloatArray

    def whitener(self, noise_px: float) -> FloatArray:
        """(N, d, d) matrices that bring each residual to unit covariance."""
        covariance = noise_px**2 * np.eye(self.residuals.shape[1]) + self.map_covs_px2
        return np.linalg.inv(np.linalg.cholesky(covariance))


class Model(Protocol[State]):
    """A camera model among others: how picks look at a state, what is believed of it, how it moves."""

    def observe(self, state: State) -> Sequence[Observed]:
        """Residuals and derivatives, one block for each kind of pick."""
        ...

    def beliefs(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Residuals (q,) of what was believed beforehand, in standard deviations, and derivatives (q, p)."""
        ...

    def move(self, state: State, step: FloatArray) -> State:
        """The state after a step (p,)."""
        ...


@dataclass(frozen=True)
class Noise:
    """The picks' noise, standard deviation per axis, as believed, and how many residuals that belief is worth."""

    sigma_px: float = 1.0
    weight: float = 8.0


@dataclass(frozen=True, eq=False)
class Fit(Generic[State]):
    """A settled fit.

    good: for each block, (N,) probabilities that a pick is good.
    residuals: for each block, (N, d) px.
    covariance: (p, p) of the parameters, the uncertainty of noise and of the picks' being good included.
    noise_px: of the good picks, estimated.
    log_likelihood: of everything, up to a constant; for comparing fits of the same picks.
    """

    state: State
    good: tuple[FloatArray, ...]
    residuals: tuple[FloatArray, ...]
    covariance: FloatArray
    noise_px: float
    log_likelihood: float


def best_fit(
    model: Model[State], starts: Sequence[tuple[State, float]], noise: Noise, *, extent_px: float
) -> Fit[State]:
    """The most likely of the fits from all ``starts``, each with its own start_noise_px; compare ``fit``.

    Raises CalibrationError, with the first start's reason, where none settles.
    """
    fits, reasons = [], []
    for start, noise_px in starts:
        try:
            rough = fit(model, start, noise, start_noise_px=noise_px, extent_px=extent_px, settled=_ROUGHLY_SETTLED)
        except CalibrationError as error:
            reasons.append(error)
        else:
            fits.append(rough)
    if not fits:
        raise reasons[0]
    best = max(fits, key=lambda found: found.log_likelihood)
    return fit(model, best.state, noise, start_noise_px=best.noise_px, extent_px=extent_px)


def fit(
    model: Model[State],
    start: State,
    noise: Noise,
    *,
    start_noise_px: float,
    extent_px: float,
    settled: float = _SETTLED,
) -> Fit[State]:
    """The most likely state near ``start``.

    start_noise_px: residuals that the start leaves with good picks. extent_px: the longest error a pick can have.
    settled: change of probabilities and of the noise's logarithm from round to round at which it ends.
    Raises CalibrationError where it does not settle or leaves parameters undetermined.
    """
    state, noise_px, wrong_share = start, start_noise_px, _WRONG_SHARE
    before = np.array([np.inf])
    for _ in range(_ROUNDS):
        blocks = model.observe(state)
        whiteners = [block.whitener(noise_px) for block in blocks]
        good = [_good(b, w, wrong_share, extent_px / noise_px)[0] for b, w in zip(blocks, whiteners, strict=True)]
        state, solution = refine(state, _weighted(model, whiteners, good), model.move)
        noise_px *= _noise_ratio(model, state, solution, good, noise=noise, noise_px=noise_px)
        wrong = sum(float((1 - g).sum()) for g in good)
        wrong_share = (_WRONG_SHARE * _WRONG_WEIGHT + wrong) / (_WRONG_WEIGHT + sum(map(len, good)))
        now = np.concatenate([*good, [np.log(noise_px)]])
        if np.abs(now - before).max() < settled:
            break
        before = now
    return _settled(model, state, noise=noise, noise_px=noise_px, wrong_share=wrong_share, extent_px=extent_px)


def _weighted(
    model: Model[State], whiteners: Sequence[FloatArray], good: Sequence[FloatArray]
) -> Callable[[State], Linear]:
    """The least-squares problem with weights and whitening held."""

    def linearise(state: State) -> Linear:
        residuals, rows = [], []
        for block, whitener, weight in zip(model.observe(state), whiteners, good, strict=True):
            used = weight > 0
            scaled = np.sqrt(weight[used])[:, None, None] * whitener[used]
            residuals.append((scaled @ block.residuals[used][..., None]).ravel())
            rows.append((scaled @ block.by_parameters[used]).reshape(-1, block.by_parameters.shape[-1]))
        believed, by_parameters = model.beliefs(state)
        return Linear.of(np.concatenate([*residuals, believed]), np.concatenate([*rows, by_parameters]))

    return linearise


def _good(
    block: Observed, whitener: FloatArray, wrong_share: float, extent: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(N,) probability of being good, (N,) log likelihood, and (N, d) whitened residuals, 0 where there is none.

    Densities of whitened residuals. Wrong ones: proportional to 1 / (r^2 + c^2) in the plane and 1 / (r + c) across a
    line, up to ``extent``: flat in the logarithm of r beyond the core c.
    """
    seen = np.asarray(np.isfinite(block.residuals).all(axis=1))
    whitened = (whitener @ np.where(seen[:, None], block.residuals, 0.0)[..., None])[..., 0]
    size = whitened.shape[1]
    length = np.linalg.norm(whitened, axis=1)
    as_good = np.log1p(-wrong_share) - 0.5 * size * np.log(2 * np.pi) - 0.5 * length**2
    if size == 2:
        as_wrong = -np.log(np.pi * np.log1p((extent / _CORE_SIGMAS) ** 2) * (length**2 + _CORE_SIGMAS**2))
    else:
        as_wrong = -np.log(2 * np.log1p(extent / _CORE_SIGMAS) * (length + _CORE_SIGMAS))
    as_wrong = np.log(wrong_share) + np.where(seen, as_wrong, -np.log(np.pi) - size * np.log(extent))
    as_good = np.where(seen, as_good, -np.inf)
    either = np.logaddexp(as_good, as_wrong)
    weight = np.exp(as_good - either)
    return np.where(weight < _NEGLIGIBLE, 0.0, weight), either, whitened


def _noise_ratio(
    model: Model[State],
    state: State,
    solution: Linear,
    good: Sequence[FloatArray],
    *,
    noise: Noise,
    noise_px: float,
    student: float = 0.0,
) -> float:
    """By which the noise has to grow for the good picks' residuals to have the size that it says.

    student: 2 for the variance of errors whose noise is itself estimated (Student's t), else 0.
    """
    believed, by_parameters = model.beliefs(state)
    squares = solution.cost - float(believed @ believed)
    left_to_beliefs = float(np.trace(inverse_normal(solution.normal) @ (by_parameters.T @ by_parameters)))
    numbers = sum(float(g.sum()) * b.residuals.shape[1] for g, b in zip(good, model.observe(state), strict=True))
    freedom = max(numbers - by_parameters.shape[1] + left_to_beliefs, 0.0)
    weight = noise.weight + freedom - student
    return float(np.sqrt((noise.weight * (noise.sigma_px / noise_px) ** 2 + squares) / weight))


def _settled(
    model: Model[State], state: State, *, noise: Noise, noise_px: float, wrong_share: float, extent_px: float
) -> Fit[State]:
    blocks = model.observe(state)
    whiteners = [block.whitener(noise_px) for block in blocks]
    judged = [_good(b, w, wrong_share, extent_px / noise_px) for b, w in zip(blocks, whiteners, strict=True)]
    good = [weight for weight, _, _ in judged]
    solution = _weighted(model, whiteners, good)(state)
    believed, _ = model.beliefs(state)
    logs = sum(float(log.sum()) for _, log, _ in judged) + sum(float(np.log(np.linalg.det(w)).sum()) for w in whiteners)
    grown = noise_px * _noise_ratio(model, state, solution, good, noise=noise, noise_px=noise_px, student=2.0)
    whiteners = [block.whitener(grown) for block in blocks]
    solution = _weighted(model, whiteners, good)(state)
    missing = np.sum([_missing(b, w, g) for b, w, g in zip(blocks, whiteners, good, strict=True)], axis=0)
    return Fit(
        state,
        tuple(good),
        tuple(block.residuals for block in blocks),
        _covariance(solution.normal, missing),
        noise_px,
        logs - 0.5 * float(believed @ believed),
    )


def _missing(block: Observed, whitener: FloatArray, good: FloatArray) -> FloatArray:
    """(p, p) information that is lost by not knowing which picks are good (Louis 1982, equation 3.2)."""
    doubtful = (good > 0) & (good < 1)
    whitened = (whitener[doubtful] @ block.residuals[doubtful][..., None])[..., 0]
    gradients = np.einsum("ni,nij,njp->np", whitened, whitener[doubtful], block.by_parameters[doubtful])
    weights = good[doubtful] * (1 - good[doubtful])
    lost: FloatArray = (gradients * weights[:, None]).T @ gradients
    return lost


def _covariance(information: FloatArray, missing: FloatArray) -> FloatArray:
    """Inverse of the observed information; of the whole information where a single doubtful pick would undo it."""
    scale = 1 / np.sqrt(np.diag(information))
    least = np.linalg.eigvalsh((information - missing) * np.outer(scale, scale)).min()
    whole = np.linalg.eigvalsh(information * np.outer(scale, scale)).min()
    return inverse_normal(information - missing if least > _LEAST_LEFT * whole else information)
