"""The edge model of ``edge_profile`` fitted to the four sides of a roof that is followed.

Model, priors and the test that decides on walls are those of ``fit_edges``. The way to the minimum is shorter: the
last fit's walls are near, and the background's colour, in which the model is linear, is eliminated (variable
projection, Golub and Pereyra 1973), which leaves three unknowns to a side.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray
from perception.edge_profile import (
    BLUR_PX,
    LEAST_SHADE,
    LEAST_SIGMA,
    REACH_SIGMA_PX,
    ROOF_T_PX,
    SHADE,
    SHADE_SIGMA,
    SIGMA_SHARE,
    step,
)
from perception.roof import REACH_PX, WALL_EVIDENCE
from perception.roof_window import SIDE_OF_ROW, WindowPlan

ITERATIONS = 5
SETTLED_PX = 0.02
_LARGEST_STEP = np.array([1.0, 1.0, 0.2])
_LEAST_START_PX = 1.0  # of a wall: from none at all the fit would not find one
_DAMPING = 1e-3
_PRIOR = np.diag([_DAMPING, _DAMPING, 1 / SHADE_SIGMA**2, _DAMPING, _DAMPING, _DAMPING])
_WALLED = np.repeat([False, True], 4)  # each side is fitted without a wall, then with one
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


def fit_profiles(rows: FloatArray, plan: WindowPlan, walls_px: FloatArray, shades: FloatArray) -> ProfileFit:
    """Fit the profiles ``rows`` (6, T, 3) of a window, from walls and shades (4,) that are near."""
    profiles, t_px = _of_sides(rows), plan.t_px[_FIRST_ROW]
    roof = _mean_where(profiles, t_px <= ROOF_T_PX)
    twice = _Twice(*(np.concatenate([a, a]) for a in (profiles, t_px, roof, _weights(profiles, roof, t_px))))
    parameters = np.zeros((8, 3))  # edge, end of the wall, shade
    parameters[4:, 1], parameters[:, 2] = np.maximum(walls_px, _LEAST_START_PX), np.concatenate([shades, shades])
    for _ in range(ITERATIONS):
        change = np.clip(twice.newton_step(parameters), -_LARGEST_STEP, _LARGEST_STEP)
        parameters += change
        parameters[:4, 1] = parameters[:4, 0]
        parameters[4:, 1] = np.maximum(parameters[4:, 1], parameters[4:, 0])
        parameters[:, 2] = np.maximum(parameters[:, 2], LEAST_SHADE)
        if np.abs(change[:, 0]).max() < SETTLED_PX:
            break
    costs, background = twice.costs(parameters)
    walled = costs[:4] - costs[4:] > WALL_EVIDENCE
    pick = np.arange(4) + 4 * walled
    return ProfileFit(
        edges_px=parameters[pick, 0],
        turn_rad=_turn_rad(rows, plan),
        walled=walled,
        walls_px=np.minimum(parameters[4:, 1] - parameters[4:, 0], REACH_PX),
        shades=parameters[4:, 2],
        roof=roof,
        background=background[pick],
        costs=costs[pick],
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


def _mean_where(profiles: FloatArray, counted: BoolArray) -> FloatArray:
    weights = counted / np.maximum(counted.sum(axis=1, keepdims=True), 1)
    return np.asarray((weights[:, None] @ profiles)[:, 0])


def _weights(profiles: FloatArray, roof: FloatArray, t_px: FloatArray) -> FloatArray:
    """(S, T) one over the variance by which each sample may depart."""
    contrast = np.linalg.norm(roof - profiles[:, -3:].mean(axis=1), axis=1, keepdims=True)
    sigma = np.maximum(SIGMA_SHARE * contrast, LEAST_SIGMA)
    return np.asarray(np.exp(-((t_px / REACH_SIGMA_PX) ** 2)) / sigma**2)


def _turn_rad(rows: FloatArray, plan: WindowPlan) -> float:
    """By how much the long sides lie askew in the window, from their halves' shift against each other."""
    halves = rows[[0, 1, 3, 4]].reshape(2, 2, -1, 3)
    slope = np.gradient(halves.mean(axis=1), axis=1)  # (2, T, 3) colour per pixel outwards
    near = (np.abs(plan.t_px[[0, 3]]) <= REACH_PX / 2)[..., None]
    farther = ((halves[:, 0] - halves[:, 1]) * slope * near).sum(axis=(1, 2))  # after the middle than before it
    power = (slope**2 * near).sum()
    return float((farther[1] - farther[0]) / max(power, 1.0) / plan.apart_px)


@dataclass(frozen=True, eq=False)
class _Twice:
    """Each side's profile for the model without a wall, then for the one with a wall.

    profiles: (8, T, 3). t_px, weights: (8, T). roof: (8, 3).
    """

    profiles: FloatArray
    t_px: FloatArray
    roof: FloatArray
    weights: FloatArray

    def newton_step(self, parameters: FloatArray) -> FloatArray:
        """(8, 3) Gauss-Newton step in edge, end of the wall and shade; the best background follows each."""
        basis, background, residuals = self._linearised(parameters)
        shade = parameters[:, 2:]
        face = shade * self.roof  # (8, 3) the wall's colour
        colours = np.empty((8, 3, 3))  # parameter, channel
        colours[:4, 0] = (self.roof - background)[:4]
        colours[4:, 0] = (self.roof - face)[4:]
        colours[:4, 1:] = 0.0
        colours[4:, 1] = (face - background)[4:]
        colours[4:, 2] = self.roof[4:]
        weighted = basis * self.weights[:, None]  # (8, 4, T)
        gram = weighted @ basis.transpose(0, 2, 1)  # (8, 4, 4)
        spent = gram[:, :3, 3:] * gram[:, 3:, :3] / np.maximum(gram[:, 3:, 3:], 1e-9)
        normal = (gram[:, :3, :3] - spent) * (colours @ colours.transpose(0, 2, 1)) + _DAMPING * np.eye(3)
        right = ((weighted[:, :3] @ residuals) * colours).sum(axis=-1)  # (8, 3)
        normal[4:, 2, 2] += 1 / SHADE_SIGMA**2
        right[4:, 2] += (SHADE - shade[4:, 0]) / SHADE_SIGMA**2
        return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])

    def costs(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(8,) half the sum of squared residuals, the shade's prior included; and the best backgrounds (8, 3)."""
        _, background, residuals = self._linearised(parameters)
        prior = np.where(_WALLED, (parameters[:, 2] - SHADE) / SHADE_SIGMA, 0.0)
        return ((residuals**2).sum(axis=-1) * self.weights).sum(axis=-1) / 2 + prior**2 / 2, background

    def _linearised(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Basis (8, 4, T) of the derivatives, best background (8, 3), residuals (8, T, 3)."""
        past_edge, edge_slope = step((self.t_px - parameters[:, 0:1]) / BLUR_PX)
        past_wall, wall_slope = step((self.t_px - parameters[:, 1:2]) / BLUR_PX)
        on_wall = past_edge - past_wall
        share = 1 - past_edge + parameters[:, 2:] * on_wall  # (8, T) of the roof's colour
        rest = self.profiles - share[..., None] * self.roof[:, None]
        power = np.maximum((self.weights * past_wall**2).sum(axis=1), 1e-9)
        background = ((self.weights * past_wall)[:, None] @ rest)[:, 0] / power[:, None]
        residuals = rest - past_wall[..., None] * background[:, None]
        return np.stack([edge_slope, wall_slope, on_wall, past_wall], axis=1), background, residuals
