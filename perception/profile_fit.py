"""The edge model of ``edge_profile`` on the four sides of a roof that is followed: fitted, and linearised."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray
from perception.edge_profile import (
    BLUR_PX,
    LEAST_SIGMA,
    REACH_SIGMA_PX,
    SHADE_SIGMA,
    SIGMA_SHARE,
    fit_edges,
    step,
)
from perception.roof import REACH_PX, WALL_EVIDENCE
from perception.roof_window import SIDE_OF_ROW, WindowPlan

_NONE = np.zeros(4, np.bool_)
_DAMPING = 1e-3
_PRIOR = np.diag([_DAMPING, _DAMPING, 1 / SHADE_SIGMA**2, _DAMPING, _DAMPING, _DAMPING])
_FIRST_ROW, _LAST_ROW = np.array([0, 2, 3, 5]), np.array([1, 2, 4, 5])  # of each side
_LONG_ROWS, _LONG_SIDES = np.array([0, 1, 3, 4]), np.array([0, 0, 2, 2])
_TURNS_BY = np.array([0.5, -0.5, -0.5, 0.5])  # outward shift of these rows when the roof turns, of their distance
_ROOF_SAMPLES = 3  # of each profile show nothing but the roof
NARROW_PX = 2.5  # what lies farther from the edge moves the linear model less: the ground is seldom even


@dataclass(frozen=True, eq=False)
class ProfileFit:
    """The four sides; the model that is believed of each.

    edges_px: (4,) outwards from where they were expected. turn_rad: from the long towards the short axis.
    walled: (4,) whether there is a wall. walls_px, shades: (4,) of the models with a wall.
    roof, background: (4, 3) BGR. costs: (4,) half the sum of squared, weighted residuals.
    """

    edges_px: FloatArray
    turn_rad: float
    walled: BoolArray
    walls_px: FloatArray
    shades: FloatArray
    roof: FloatArray
    background: FloatArray
    costs: FloatArray


def fit_profiles(
    rows: FloatArray, plan: WindowPlan, walls_px: FloatArray | None = None, hidden: BoolArray = _NONE
) -> ProfileFit:
    """Fit the profiles ``rows`` (6, T, 3) of a window; ``walls_px`` (4,) are about as wide, if that is known.

    hidden: (4,) sides that are not there, so that the other long one alone tells the turn.
    """
    fits = fit_edges(_of_sides(rows), plan.t_px[_FIRST_ROW], walls_px)
    walled = fits.costs[0] - fits.costs[1] > WALL_EVIDENCE
    pick = walled.astype(np.intp), np.arange(4)
    return ProfileFit(
        edges_px=fits.edges_px[pick],
        turn_rad=_turn_rad(rows, plan, ~hidden[[0, 2]]),
        walled=walled,
        walls_px=np.minimum(fits.walls_px[1], REACH_PX),
        shades=fits.shades[1],
        roof=fits.roofs,
        background=fits.backgrounds[pick],
        costs=fits.costs[pick],
    )


@dataclass(frozen=True, eq=False)
class LinearModel:
    """The fitted model with its edges where they are expected, and what small departures from it mean.

    model: (6, T, 3) of the profiles. jacobian: (4, 3 T, 6), solution: (4, 6, 3 T) and root: (4, 3 T) of the weights, of
    all that a side can do. turn: (4, 3 T) turn in radians per departure of the long sides' halves.
    """

    model: NDArray[np.float32]
    jacobian: FloatArray
    solution: FloatArray
    root: FloatArray
    turn: FloatArray

    @classmethod
    def of(cls, fit: ProfileFit, plan: WindowPlan) -> "LinearModel":
        """The model near a fit."""
        t_px = plan.t_px[_FIRST_ROW]
        wall = np.where(fit.walled, fit.walls_px, 0.0)[:, None]
        shade = np.where(fit.walled, fit.shades, 0.0)[:, None]
        past_edge, edge_slope = step(t_px / BLUR_PX)  # (4, T)
        past_wall, wall_slope = step((t_px - wall) / BLUR_PX)
        roof, background = fit.roof[:, None], fit.background[:, None]  # (4, 1, 3)
        share = 1 - past_edge + shade * (past_edge - past_wall)
        model = share[..., None] * roof + past_wall[..., None] * background
        by_wall = wall_slope[..., None] * (shade[..., None] * roof - background)
        jacobian = np.zeros((4, *model.shape[1:], 6))
        jacobian[..., 0] = (edge_slope * (1 - shade))[..., None] * roof + by_wall
        jacobian[..., 1] = by_wall * fit.walled[:, None, None]
        jacobian[..., 2] = (past_edge - past_wall)[..., None] * roof * fit.walled[:, None, None]
        jacobian[..., 3:] = past_wall[..., None, None] * np.eye(3)
        jacobian = jacobian.reshape(4, -1, 6)
        narrow = np.exp(-((t_px / NARROW_PX) ** 2))
        weights = np.repeat(_weights(model, fit.roof, t_px) * narrow, 3, axis=1)  # (4, 3 T)
        weighted = (jacobian * weights[..., None]).transpose(0, 2, 1)
        solution = np.linalg.solve(weighted @ jacobian + _PRIOR, weighted)
        by_turn = jacobian[_LONG_SIDES, :, 0] * _TURNS_BY[:, None] * plan.apart_px
        power = weights[_LONG_SIDES] * by_turn
        turn = power / max(float((power * by_turn).sum()), _DAMPING)
        return cls(model[SIDE_OF_ROW].astype(np.float32), jacobian, solution, np.sqrt(weights), turn)

    def read(self, profiles: NDArray[np.float32]) -> tuple[FloatArray, float, FloatArray]:
        """Edges (4,) outwards, turn, and half the squared, weighted rest (4,) that no parameter explains.

        The halves of a long side depart alike when it moves and unlike when it turns: each is read without the other.
        """
        seen, known = profiles[:, :_ROOF_SAMPLES].ravel(), self.model[:, :_ROOF_SAMPLES].ravel()
        gain = np.dot(known, known) / max(float(np.dot(seen, known)), 1.0)  # the light's strength is no motion
        departure = (profiles * gain - self.model).reshape(6, -1).astype(np.float64)
        sides = _of_sides(departure)
        found = self.solution @ sides[..., None]  # (4, 6, 1)
        rest = (sides - (self.jacobian @ found)[..., 0]) * self.root
        turn_rad = float((departure[_LONG_ROWS] * self.turn).sum())
        return found[:, 0, 0], turn_rad, (rest * rest).sum(axis=1) / 2


def _of_sides(rows: FloatArray) -> FloatArray:
    """(4, ...) the halves of the long sides put together."""
    return np.asarray((rows[_FIRST_ROW] + rows[_LAST_ROW]) / 2)


def _weights(profiles: FloatArray, roof: FloatArray, t_px: FloatArray) -> FloatArray:
    """(S, T) one over the variance by which each sample may depart."""
    contrast = np.linalg.norm(roof - profiles[:, -3:].mean(axis=1), axis=1, keepdims=True)
    sigma = np.maximum(SIGMA_SHARE * contrast, LEAST_SIGMA)
    return np.asarray(np.exp(-((t_px / REACH_SIGMA_PX) ** 2)) / sigma**2)


def _turn_rad(rows: FloatArray, plan: WindowPlan, seen: BoolArray) -> float:
    """By how much the long sides that are ``seen`` (2,) lie askew, from their halves' shift against each other."""
    halves = rows[[0, 1, 3, 4]].reshape(2, 2, -1, 3)
    slope = np.gradient(halves.mean(axis=1), axis=1)  # (2, T, 3) colour per pixel outwards
    near = (seen[:, None] & (np.abs(plan.t_px[[0, 3]]) <= REACH_PX / 2))[..., None]
    farther = ((halves[:, 0] - halves[:, 1]) * slope * near).sum(axis=(1, 2))  # after the middle than before it
    power = (slope**2 * near).sum()
    return float((farther[1] - farther[0]) / max(power, 1.0) / plan.apart_px)
