"""The bodies of all road users at one moment: their convex pieces where they truly are."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from contracts import FloatArray, IntArray
from contracts.truth import Truth
from sim.bodies import Appearance, Design, appearance_of


@dataclass(frozen=True)
class Wardrobe:
    """How road users look, always the same; ``seed`` decides it."""

    seed: int

    def appearance(self, kind: str, id_: str) -> Appearance:
        """Of one user."""
        return _appearance(kind, id_, self.seed)

    def pieces(self, state: Truth, row: int) -> list[FloatArray]:
        """Corners (P, 3), world, of every convex piece of one user's body."""
        unit, starts = _corners(self.appearance(state.kinds[row], state.ids[row]).design)
        return np.split(unit @ affine(state, row).T + state.positions_m[row], starts)


def affine(state: Truth, row: int) -> FloatArray:
    """From the unit box of a design to a user's true box, but for its position; (3, 3)."""
    cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
    return np.asarray(np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) * state.sizes_m[row])


@cache
def _appearance(kind: str, id_: str, seed: int) -> Appearance:
    return appearance_of(kind, id_, seed)


@cache
def _corners(design: Design) -> tuple[FloatArray, IntArray]:
    """Different corners (N, 3) of each piece, in the unit box, and where those of the second and further ones start."""
    corners = [np.unique(piece.vertices_m, axis=0) for part in design.parts for piece in part.pieces]
    return np.concatenate(corners), np.cumsum([len(piece) for piece in corners])[:-1]
