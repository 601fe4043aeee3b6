"""A mixture of Gaussians over colours, fitted by expectation and maximisation (Dempster, Laird & Rubin 1977)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, InputError
from contracts.arrays import freeze

CHANNELS = 3
LEAST_VARIANCE = 1.0  # squared levels: below, 8-bit colours are all rounding
SETTLED = 1e-6  # gain of the mean log likelihood at which the fit ends
ROUNDING = 1e-4  # of the weights in a file
MOST_ROUNDS = 200
_FEATURES = 10  # monomials of three channels up to the second degree


@dataclass(frozen=True, eq=False)
class Mixture:
    """K weighted Gaussians over BGR levels.

    weights: (K,) positive, of sum 1. means: (K, 3). covariances: (K, 3, 3), positive definite.
    """

    weights: FloatArray
    means: FloatArray
    covariances: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "weights", shape=(None,))
        n = len(self.weights)
        freeze(self, "means", shape=(n, CHANNELS))
        freeze(self, "covariances", shape=(n, CHANNELS, CHANNELS))
        if not n or self.weights.min() <= 0 or abs(self.weights.sum() - 1) > ROUNDING:
            raise InputError(f"Mixture.weights must be positive and of sum 1, got {self.weights.tolist()}")
        if np.linalg.eigvalsh(self.covariances).min() <= 0:
            raise InputError("Mixture.covariances must be positive definite")

    def log_densities(self, colours: FloatArray) -> FloatArray:
        """(..., K) log of weight times density of each component at ``colours`` (..., 3)."""
        return np.asarray(monomials(np.asarray(colours, np.float64)) @ self.coefficients)

    @cached_property
    def coefficients(self) -> FloatArray:
        """(10, K) the log densities as polynomials in the ``monomials``: one matrix product serves a whole image."""
        precisions = np.linalg.inv(self.covariances)  # (K, 3, 3)
        pulled = np.einsum("kij,kj->ki", precisions, self.means)  # (K, 3)
        _, log_determinants = np.linalg.slogdet(2 * np.pi * self.covariances)
        constants = np.log(self.weights) - 0.5 * (log_determinants + np.einsum("ki,ki->k", pulled, self.means))
        rows, columns = np.triu_indices(CHANNELS)
        doubled = np.where(rows == columns, 0.5, 1.0)
        return np.concatenate([constants[None], pulled.T, -doubled[:, None] * precisions[:, rows, columns].T])


def monomials(colours: NDArray[np.floating]) -> NDArray[np.floating]:
    """(..., 10) 1, the channels, and their products, of colours (..., 3)."""
    rows, columns = np.triu_indices(CHANNELS)
    ones = np.ones((*colours.shape[:-1], 1), colours.dtype)
    return np.concatenate([ones, colours, colours[..., rows] * colours[..., columns]], axis=-1)


def log_sum(log_densities: FloatArray) -> FloatArray:
    """Log of the sum of exponentials over the last axis."""
    highest = log_densities.max(axis=-1, keepdims=True)
    return np.asarray(highest[..., 0] + np.log(np.exp(log_densities - highest).sum(axis=-1)))


def fit_mixture(colours: FloatArray, components: int) -> Mixture:
    """The mixture under which ``colours`` (N, 3) are most likely, starting from parts of equal size by brightness.

    The start depends on the colours alone, so that the same colours give the same mixture.
    Raises InputError for fewer colours than would determine the components.
    """
    if len(colours) < components * _FEATURES:
        raise InputError(
            f"a mixture of {components} needs at least {components * _FEATURES} colours, not {len(colours)}"
        )
    order = np.argsort(colours.sum(axis=1), kind="stable")
    shares = np.zeros((len(colours), components))
    for k, part in enumerate(np.array_split(order, components)):
        shares[part, k] = 1.0
    mixture, likelihood = _maximised(colours, shares), -np.inf
    for _ in range(MOST_ROUNDS):
        log_densities = mixture.log_densities(colours)
        total = log_sum(log_densities)
        gain, likelihood = float(total.mean()) - likelihood, float(total.mean())
        if gain < SETTLED:
            break
        mixture = _maximised(colours, np.exp(log_densities - total[:, None]))
    return mixture


def _maximised(colours: FloatArray, shares: FloatArray) -> Mixture:
    """The components as their ``shares`` (N, K) of the colours say."""
    counts = np.maximum(shares.sum(axis=0), 1e-9)
    means = shares.T @ colours / counts[:, None]
    apart = colours[:, None] - means  # (N, K, 3)
    covariances = np.einsum("nk,nki,nkj->kij", shares, apart, apart) / counts[:, None, None]
    return Mixture(counts / counts.sum(), means, covariances + LEAST_VARIANCE * np.eye(CHANNELS))
