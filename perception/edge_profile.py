r"""Where exactly a roof ends: a model of the colours met on the way out across one of its sides.

::

    roof ______
               \
                \_______ wall
                        \
                         \_______ background
    ------------+--------+----------------> t, pixels outwards
              edge   edge + wall

The profile is the mean over many parallel calipers, as in the slanted-edge method (ISO 12233), so that noise and
texture average out. The wall has the roof's colour, ``shade`` times as bright: what pulls the profile off the straight
line from the roof's to the background's colour is a wall, even one narrower than the blur.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from contracts import BoolArray, FloatArray

BLUR_PX = 0.8  # standard deviation of lens, antialiasing and sampling together
SHADE = 0.5  # a wall faces the horizon and gets about half of the roof's light ...
SHADE_SIGMA = 0.2  # ... more or less
ROOF_T_PX = -3.5  # inside of this the profile shows the roof alone
REACH_SIGMA_PX = 4.0  # what lies farther out than this matters little
SIGMA_SHARE = 0.045  # of the contrast, by which a profile may depart from its model: light must not decide on walls
LEAST_SIGMA = 0.5  # grey levels; what rounding to whole levels leaves
LEAST_SHADE = 0.05
WALL_STARTS_PX = (1.0, 4.0)  # the fit may find another minimum from each
_ITERATIONS = 10
_LARGEST_STEP = np.array([1.0, 1.0, 0.2])
_DAMPING = 1e-3
_OVERSHOT = 0.5  # of the last step, taken back
_SETTLED_PX = 0.01
_SETTLED_COST = 0.02


@dataclass(frozen=True, eq=False)
class EdgeFits:
    """The model fitted to S profiles, without a wall (row 0) and with one (row 1).

    edges_px, walls_px: (2, S) where the roof ends, and the width of the wall behind it. shades: (2, S) of the wall.
    costs: (2, S) half the sum of squared residuals, each over its standard deviation; priors included.
    roofs: (S, 3) and backgrounds: (2, S, 3) BGR.
    """

    edges_px: FloatArray
    walls_px: FloatArray
    shades: FloatArray
    costs: FloatArray
    roofs: FloatArray
    backgrounds: FloatArray


def fit_edges(profiles: FloatArray, t_px: FloatArray, walls_px: FloatArray | None = None) -> EdgeFits:
    """Fit S profiles, all at once.

    profiles: (S, T, 3) mean BGR at the offsets ``t_px`` (T,) or (S, T), which grow outwards; the roof ends near 0.
    walls_px: (S,) about how wide the walls are, where that is known; if not, the fit starts from several widths.
    """
    sides, t_px = len(profiles), np.broadcast_to(t_px, profiles.shape[:2])
    reach = float(t_px[:, -1].min())
    starts = [np.full(sides, start) for start in WALL_STARTS_PX] if walls_px is None else [walls_px]
    ends = np.concatenate([np.zeros(sides), *(np.clip(start, WALL_STARTS_PX[0], reach) for start in starts)])
    copies = 1 + len(starts)
    profile = _Profiles.of(np.tile(profiles, (copies, 1, 1)), np.tile(t_px, (copies, 1)), ends > 0)
    parameters = _fit(profile, ends)  # (K, 3)
    costs, backgrounds = profile.costs(parameters)
    best = 1 + np.argmin(costs.reshape(copies, sides)[1:], axis=0)  # (S,)
    pick = np.stack([np.zeros_like(best), best]) * sides + np.arange(sides)  # (2, S)
    edges, outer, shades = np.moveaxis(parameters[pick], -1, 0)
    return EdgeFits(edges, outer - edges, shades, costs[pick], profile.roof[:sides], backgrounds[pick])


def _fit(profile: "_Profiles", ends_px: FloatArray) -> FloatArray:
    """(K, 3) edges, outer ends of the walls and shades. A wall that starts at 0 stays 0."""
    low, high = profile.t_px[:, 0], profile.t_px[:, -1]
    parameters = np.stack([np.zeros_like(ends_px), ends_px, np.full_like(ends_px, SHADE)], axis=1)  # (K, 3)
    plain = ~profile.walled
    moving = np.ones((len(ends_px), 1), np.bool_)  # each profile stops by itself, whatever the others do
    pace, last = np.ones_like(parameters[:, :1]), np.zeros(len(ends_px))
    for _ in range(_ITERATIONS):
        wanted, gain = profile.newton_step(parameters)
        step = np.clip(wanted, -_LARGEST_STEP, _LARGEST_STEP) * moving
        back_and_forth = step[:, 0] * last < -_OVERSHOT * last**2
        pace[back_and_forth] *= 0.5  # beyond the minimum and back again, where the model is far from linear
        step, last = step * pace, step[:, 0]
        parameters += step
        edge = parameters[:, 0] = np.clip(parameters[:, 0], low, high)
        parameters[:, 1] = np.where(plain, edge, np.clip(parameters[:, 1], edge, edge + high))
        parameters[:, 2] = np.maximum(parameters[:, 2], LEAST_SHADE)
        moving &= (np.abs(step[:, :1]) >= _SETTLED_PX) | (gain[:, None] >= _SETTLED_COST)
        if not moving.any():
            break
    return parameters


@dataclass(frozen=True, eq=False)
class _Profiles:
    """K profiles (K, T, 3) at (K, T), their roofs (K, 3), weights (K, T), and which are fitted with a wall (K,).

    The parameters (K, 3) are the edge, the outer end of the wall and its shade. The model is linear in the background's
    colour, which is eliminated: variable projection (Golub and Pereyra 1973), in Kaufman's (1975) approximation. Each
    derivative is a function of t times a colour, so the normal equations are products of small Gram matrices.
    """

    profiles: FloatArray
    t_px: FloatArray
    roof: FloatArray
    weights: FloatArray
    walled: BoolArray

    @classmethod
    def of(cls, profiles: FloatArray, t_px: FloatArray, walled: BoolArray) -> "_Profiles":
        roof = _mean_where(profiles, t_px <= ROOF_T_PX)  # (K, 3)
        background = _mean_where(profiles, t_px >= t_px[:, -1:] - 2)
        sigma = np.maximum(SIGMA_SHARE * np.linalg.norm(roof - background, axis=1), LEAST_SIGMA)
        weights = np.exp(-((t_px / REACH_SIGMA_PX) ** 2)) / sigma[:, None] ** 2
        return cls(profiles, t_px, roof, weights, walled)

    def newton_step(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(K, 3) Gauss-Newton step, the best background follows each; and (K,) by how much it should lower the cost."""
        shapes, background, residuals = self._linearised(parameters)
        shade = parameters[:, 2:]
        face = np.where(self.walled[:, None], shade * self.roof, background)  # (K, 3) what follows the roof
        colours = np.stack([self.roof - face, face - background, self.roof * self.walled[:, None]], axis=1)
        weighted = shapes * self.weights[:, None]  # (K, 4, T)
        gram = weighted @ shapes.transpose(0, 2, 1)  # (K, 4, 4)
        spent = gram[:, :3, 3:] * gram[:, 3:, :3] / np.maximum(gram[:, 3:, 3:], 1e-9)
        normal = (gram[:, :3, :3] - spent) * (colours @ colours.transpose(0, 2, 1))
        right = np.einsum("kpc,kpc->kp", weighted[:, :3] @ residuals, colours)
        normal[:, _DIAGONAL, _DIAGONAL] += _DAMPING
        normal[:, 2, 2] += 1 / SHADE_SIGMA**2
        right[:, 2] += (SHADE - shade[:, 0]) / SHADE_SIGMA**2
        wanted = np.linalg.solve(normal, right[..., None])[..., 0]
        return np.asarray(wanted), np.asarray((wanted * right).sum(axis=1) / 2)

    def costs(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(K,) half the weighted sum of squared residuals, the prior of the shade included; backgrounds (K, 3)."""
        _, background, residuals = self._linearised(parameters)
        prior = ((parameters[:, 2] - SHADE) / SHADE_SIGMA) ** 2
        return (np.einsum("ktc,ktc,kt->k", residuals, residuals, self.weights) + prior) / 2, background

    def _linearised(self, parameters: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """How edge, end, shade and background shape it (K, 4, T); best background (K, 3); residuals (K, T, 3)."""
        past, slope = step((self.t_px[:, None] - parameters[:, :2, None]) / BLUR_PX)  # (K, 2, T): past edge, past wall
        shapes = np.empty((len(past), 4, self.t_px.shape[1]))
        shapes[:, :2], shapes[:, 2], shapes[:, 3] = slope, past[:, 0] - past[:, 1], past[:, 1]
        share = 1 - past[:, 0] + parameters[:, 2:] * shapes[:, 2]  # (K, T) of the roof's colour
        rest = self.profiles - share[..., None] * self.roof[:, None]
        weighted = self.weights * past[:, 1]
        power = np.maximum(np.einsum("kt,kt->k", weighted, past[:, 1]), 1e-9)
        background = (weighted[:, None] @ rest)[:, 0] / power[:, None]
        return shapes, background, rest - past[:, 1, :, None] * background[:, None]


_DIAGONAL = np.arange(3)


def _mean_where(profiles: FloatArray, counted: BoolArray) -> FloatArray:
    """(K, 3) mean colours of the samples (K, T) that count."""
    return np.asarray((counted[:, None] @ profiles)[:, 0] / counted.sum(axis=1, keepdims=True))


def step(z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A blurred unit step at ``z`` standard deviations past it, and its slope per pixel."""
    return ndtr(z), np.exp(-(z**2) / 2) / (BLUR_PX * np.sqrt(2 * np.pi))
