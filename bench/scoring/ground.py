"""How far from the truth the positions are, in metres, and whether they say so themselves."""

import numpy as np

from bench.scores import Score
from bench.scoring.population import Hits
from contracts import FloatArray

ELLIPSE_90 = 4.605170185988091  # 90 % quantile of chi-square with two degrees of freedom: -2 ln 0.1


def error_scores(prefix: str, errors_m: FloatArray) -> list[Score]:
    """Summaries of position errors; none is valid without a hit.

    errors_m: (K, 2) estimate minus truth, x east and y north; rows of NaN (not known) are left out.
    Per axis: root mean square, mean (the signed bias), mean square (how paper R prints its error).
    Of the distance: mean, median, 95 % quantile, largest.
    """
    errors_m = known_rows(errors_m)
    n = len(errors_m)
    distances_m = np.linalg.norm(errors_m, axis=1)  # (K,)
    figures = [
        *((f"rms_{axis}_m", rms(errors_m[:, k]), "m") for k, axis in enumerate("xy")),
        *((f"mean_{axis}_m", _mean(errors_m[:, k]), "m") for k, axis in enumerate("xy")),
        *((f"mse_{axis}_m2", _mean(errors_m[:, k] ** 2), "m2") for k, axis in enumerate("xy")),
        ("mean_m", _mean(distances_m), "m"),
        ("median_m", _quantile(distances_m, 0.5), "m"),
        ("p95_m", _quantile(distances_m, 0.95), "m"),
        ("max_m", _quantile(distances_m, 1.0), "m"),
    ]
    return [Score.of(f"{prefix}.{name}", value, unit, n) for name, value, unit in figures]


def consistency_scores(prefix: str, hits: Hits) -> list[Score]:
    """Does the stated covariance describe the error? Over the hits whose covariance is positive definite.

    ``coverage_90``: share of positions inside their own 90 % ellipse; 0.9 if the covariance is right.
    ``nees``: mean normalised estimation error squared, e^T P^-1 e; 2 if the covariance is right
    (Bar-Shalom, Li & Kirubarajan 2001, eq. 5.4.2-1).
    """
    squares = normalised_squares(hits)
    squares = squares[np.isfinite(squares)]
    return [
        Score.of(f"{prefix}.coverage_90", _mean((squares <= ELLIPSE_90).astype(np.float64)), "1", len(squares)),
        Score.of(f"{prefix}.nees", _mean(squares), "1", len(squares)),
    ]


def normalised_squares(hits: Hits) -> FloatArray:
    """Squared Mahalanobis distance of each hit's error, (K,); NaN where its covariance is not positive definite."""
    covs, errors = hits.covs_m2, hits.errors_m  # (K, 2, 2), (K, 2)
    determinants = covs[:, 0, 0] * covs[:, 1, 1] - covs[:, 0, 1] * covs[:, 1, 0]  # (K,)
    proper = (determinants > 0) & (covs[:, 0, 0] > 0)
    squares = np.full(len(hits), np.nan)
    solved = np.linalg.solve(covs[proper], errors[proper][:, :, None])[:, :, 0]  # (P, 2)
    squares[proper] = (errors[proper] * solved).sum(axis=1)
    return squares


def known_rows(errors: FloatArray) -> FloatArray:
    """The rows of (K, 2) that are finite."""
    return errors[np.isfinite(errors).all(axis=1)]


def rms(values: FloatArray) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(_mean(values**2)))


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _quantile(values: FloatArray, share: float) -> float:
    return float(np.quantile(values, share)) if len(values) else float("nan")
