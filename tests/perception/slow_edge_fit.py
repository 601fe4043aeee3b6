"""The edge model of ``perception.edge_profile``, fitted the long way: the oracle of its fast fit.

Damped Gauss-Newton (Levenberg 1944) over all six parameters of a side with the whole Jacobian, from three starts.
"""

import numpy as np
from scipy.special import ndtr

from contracts import FloatArray
from perception.edge_profile import (
    BLUR_PX,
    LEAST_SHADE,
    LEAST_SIGMA,
    REACH_SIGMA_PX,
    ROOF_T_PX,
    SHADE,
    SHADE_SIGMA,
    SIGMA_SHARE,
    EdgeFits,
)

WALL_STARTS_PX = (0.0, 1.0, 4.0)
_ITERATIONS = 40
_LARGEST_STEP = np.array([1.0, 1.0, 0.2, 200.0, 200.0, 200.0])
_DAMPING = 1e-3
_SETTLED_PX = 0.005


def slow_fit_edges(profiles: FloatArray, t_px: FloatArray) -> EdgeFits:
    """Fit S profiles by damped Gauss-Newton (Levenberg 1944), all at once.

    profiles: (S, T, 3) mean BGR at the offsets ``t_px`` (T,), which grow outwards; the roof ends near 0.
    """
    starts = len(WALL_STARTS_PX)
    wall_start = np.repeat(WALL_STARTS_PX, len(profiles))  # (K S,)
    parameters, costs = _fit(np.tile(profiles, (starts, 1, 1)), t_px, wall_start)
    parameters, costs = parameters.reshape(starts, -1, 6), costs.reshape(starts, -1)
    best = 1 + np.argmin(costs[1:], axis=0)  # (S,)
    pick = np.stack([np.zeros_like(best), best]), np.arange(len(profiles))
    edges, walls, shades = np.moveaxis(parameters[pick][..., :3], -1, 0)
    roofs = profiles[:, t_px <= ROOF_T_PX].mean(axis=1)
    return EdgeFits(edges, walls, shades, costs[pick], roofs, parameters[pick][..., 3:])


def _fit(profiles: FloatArray, t_px: FloatArray, wall_start_px: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Parameters (S, 6): edge, wall, shade, background (3), and costs (S,). A wall that starts at 0 stays 0."""
    roof = profiles[:, t_px <= ROOF_T_PX].mean(axis=1)  # (S, 3)
    background = profiles[:, t_px >= t_px[-1] - 2].mean(axis=1)  # (S, 3)
    shade = np.full_like(wall_start_px, SHADE)
    lengths = np.stack([np.zeros_like(wall_start_px), wall_start_px, shade], axis=1)
    parameters = np.concatenate([lengths, background], axis=1)  # (S, 6)
    sigma = np.maximum(SIGMA_SHARE * np.linalg.norm(roof - background, axis=1), LEAST_SIGMA)  # (S,)
    weights = np.exp(-((t_px / REACH_SIGMA_PX) ** 2) / 2)[None, :] / sigma[:, None]  # (S, T)
    free = np.ones_like(parameters)
    free[wall_start_px == 0, 1:3] = 0
    low, high = (np.array(limits) for limits in zip(*_limits(t_px), strict=True))
    moving = np.ones(len(parameters), np.bool_)  # (S,) each profile stops by itself, whatever the others do
    for _ in range(_ITERATIONS):
        residuals, jacobian = _residuals(profiles, t_px, roof, weights, parameters)
        jacobian *= free[:, None, :]
        transposed = jacobian.transpose(0, 2, 1)
        step = np.linalg.solve(transposed @ jacobian + _DAMPING * np.eye(6), transposed @ residuals[..., None])
        step = np.clip(step[..., 0], -_LARGEST_STEP, _LARGEST_STEP) * moving[:, None]
        parameters = np.clip(parameters - step, low, high)
        moving &= np.abs(step[:, :2]).max(axis=1) >= _SETTLED_PX
        if not moving.any():
            break
    residuals, _ = _residuals(profiles, t_px, roof, weights, parameters)
    return parameters, np.asarray((residuals**2).sum(axis=1) / 2)


def _limits(t_px: FloatArray) -> list[tuple[float, float]]:
    return [(t_px[0], t_px[-1]), (0.0, t_px[-1]), (LEAST_SHADE, np.inf)] + [(-np.inf, np.inf)] * 3


def _residuals(
    profiles: FloatArray, t_px: FloatArray, roof: FloatArray, weights: FloatArray, parameters: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Weighted residuals (S, 3 T + 1), the last one the prior of the shade, and their Jacobian (S, 3 T + 1, 6)."""
    sides, count = weights.shape
    edge, wall, shade = parameters[:, :3].T[..., None]  # (S, 1) each
    background = parameters[:, None, 3:]  # (S, 1, 3)
    colour = roof[:, None, :]
    past_edge, edge_slope = _step((t_px - edge) / BLUR_PX)  # (S, T)
    past_wall, wall_slope = _step((t_px - edge - wall) / BLUR_PX)
    share = (1 - past_edge) + shade * (past_edge - past_wall)  # (S, T) of the roof's colour
    model = share[..., None] * colour + past_wall[..., None] * background  # (S, T, 3)
    by_wall = wall_slope[..., None] * (shade[..., None] * colour - background)
    by_edge = (edge_slope * (1 - shade))[..., None] * colour + by_wall
    by_shade = (past_edge - past_wall)[..., None] * colour
    by_background = past_wall[..., None, None] * np.eye(3)  # (S, T, 3, 3)
    jacobian = np.concatenate([np.stack([by_edge, by_wall, by_shade], axis=-1), by_background], axis=-1)
    residuals = (model - profiles) * weights[..., None]
    jacobian = jacobian * weights[..., None, None]
    prior = np.zeros((sides, 1, 6))
    prior[:, 0, 2] = 1 / SHADE_SIGMA
    return (
        np.concatenate([residuals.reshape(sides, 3 * count), (shade - SHADE) / SHADE_SIGMA], axis=1),
        np.concatenate([jacobian.reshape(sides, 3 * count, 6), prior], axis=1),
    )


def _step(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A blurred unit step at ``z`` standard deviations past it, and its slope per pixel."""
    return ndtr(z), np.exp(-(z**2) / 2) / (BLUR_PX * np.sqrt(2 * np.pi))
