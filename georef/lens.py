"""Brown's lens: radial and tangential distortion of normalised image points, its derivatives and its inverse.

Normalised points are (x / z, y / z) in camera axes, before K; the model is Brown 1971 in OpenCV's order k1 k2 p1 p2 k3:

    x' = x (1 + k1 r2 + k2 r4 + k3 r6) + 2 p1 x y + p2 (r2 + 2 x2)
    y' = y (1 + k1 r2 + k2 r4 + k3 r6) + p1 (r2 + 2 y2) + 2 p2 x y

Far from the axis the polynomial may turn back ("fold"): beyond that radius two rays share one pixel and the model means
nothing.
"""

from functools import lru_cache

import numpy as np

from contracts import BoolArray, FloatArray

_TOLERANCE = 1e-13  # normalised; 1e-10 px at any focal length in use
_MAX_STEPS = 50
_FAR = 1e6  # normalised radius that no ray in use reaches; keeps the arithmetic finite
_FOLD_MARGIN = 0.999  # share of the fold's radius that is used: at the fold itself the inverse has no derivative


def distort(distortion: FloatArray, points: FloatArray) -> FloatArray:
    """Bend normalised ``points`` (..., 2) as the lens does; (..., 2)."""
    k1, k2, p1, p2, k3 = distortion
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    return np.stack(
        [
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        ],
        axis=-1,
    )


def distort_by_point(distortion: FloatArray, points: FloatArray) -> FloatArray:
    """Derivative of ``distort`` with respect to the point: (..., 2, 2)."""
    k1, k2, p1, p2, k3 = distortion
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))  # d radial / d x = slope x
    across = slope * x * y + 2 * p1 * x + 2 * p2 * y
    jacobian = np.empty((*x.shape, 2, 2))
    jacobian[..., 0, 0] = radial + slope * x * x + 2 * p1 * y + 6 * p2 * x
    jacobian[..., 0, 1] = across
    jacobian[..., 1, 0] = across
    jacobian[..., 1, 1] = radial + slope * y * y + 6 * p1 * y + 2 * p2 * x
    return jacobian


def distort_by_lens(points: FloatArray) -> FloatArray:
    """Derivative of ``distort`` with respect to k1, k2, p1, p2, k3: (..., 2, 5). The model is linear in them."""
    x, y = points[..., 0], points[..., 1]
    r2 = x * x + y * y
    jacobian = np.empty((*x.shape, 2, 5))
    jacobian[..., 0, :] = np.stack([x * r2, x * r2**2, 2 * x * y, r2 + 2 * x * x, x * r2**3], axis=-1)
    jacobian[..., 1, :] = np.stack([y * r2, y * r2**2, r2 + 2 * y * y, 2 * x * y, y * r2**3], axis=-1)
    return jacobian


def fold_radius(distortion: FloatArray) -> float:
    """Normalised radius at which the radial polynomial turns back; infinity if it never does.

    The smallest positive root of d/dr [r (1 + k1 r2 + k2 r4 + k3 r6)] = 1 + 3 k1 r2 + 5 k2 r4 + 7 k3 r6; solved for
    1 / r2, in which the polynomial is monic however small the coefficients are.
    """
    k1, k2, _, _, k3 = (float(number) for number in distortion)
    return _fold_radius(k1, k2, k3)


@lru_cache(maxsize=256)
def _fold_radius(k1: float, k2: float, k3: float) -> float:
    roots = np.roots(np.array([1.0, 3 * k1, 5 * k2, 7 * k3]))
    real = roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots.real)].real
    largest = float(real.max(initial=0.0))
    return 1.0 / np.sqrt(largest) if largest > 0 else float("inf")


def before_fold(distortion: FloatArray, points: FloatArray) -> BoolArray:
    """Where the lens maps ``points`` (..., 2) one to one: inside the fold, orientation kept; NaN is not."""
    inside: BoolArray = np.hypot(points[..., 0], points[..., 1]) <= _FOLD_MARGIN * fold_radius(distortion)
    kept: BoolArray = _determinant(distort_by_point(distortion, points)) > 0
    return inside & kept


def undistort(distortion: FloatArray, bent: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Invert ``distort`` by Newton's method.

    bent: (..., 2) normalised points as the lens left them.
    Returns the straight points (..., 2), exact to 1e-13, and valid (...): False, with NaN, where no point before the
    fold is mapped there.
    """
    points = bent.copy()
    limit = min(_FOLD_MARGIN * fold_radius(distortion), _FAR)
    for _ in range(_MAX_STEPS):
        radius = np.hypot(points[..., 0], points[..., 1])[..., None]
        points = np.where(radius > limit, points * (limit / np.maximum(radius, limit)), points)  # never past the fold
        step = _solve(distort_by_point(distortion, points), distort(distortion, points) - bent)
        points = points - step
        if np.abs(np.nan_to_num(step)).max(initial=0.0) <= _TOLERANCE:
            break
    error = np.abs(distort(distortion, points) - bent).max(axis=-1)
    valid = before_fold(distortion, points) & (error < 1e-12 * (1 + np.abs(bent).max(axis=-1)))
    return np.where(valid[..., None], points, np.nan), valid


def _determinant(matrices: FloatArray) -> FloatArray:
    """Of 2 x 2 matrices (..., 2, 2)."""
    determinant: FloatArray = matrices[..., 0, 0] * matrices[..., 1, 1] - matrices[..., 0, 1] * matrices[..., 1, 0]
    return determinant


def _solve(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Solve 2 x 2 systems; singular ones give NaN, which the caller reports as invalid."""
    (a, b), (c, d) = np.moveaxis(matrices, (-2, -1), (0, 1))
    determinant = _determinant(matrices)
    determinant = np.where(np.abs(determinant) > 1e-12, determinant, np.nan)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([(d * x - b * y) / determinant, (a * y - c * x) / determinant], axis=-1)
