"""The bodies of all road users at one moment: their convex pieces where they truly are."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from contracts import FloatArray
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
        unit = _corners(self.appearance(state.kinds[row], state.ids[row]).design)
        world_from_unit = affine(state, row)
        return [corners @ world_from_unit.T + state.positions_m[row] for corners in unit]


def affine(state: Truth, row: int) -> FloatArray:
    """From the unit box of a design to a user's true box, but for its position; (3, 3)."""
    cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
    return np.asarray(np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) * state.sizes_m[row])


@cache
def _appearance(kind: str, id_: str, seed: int) -> Appearance:
    return appearance_of(kind, id_, seed)


@cache
def _corners(design: Design) -> Sequence[FloatArray]:
    """Different corners of each piece, in the unit box."""
    return [np.unique(piece.vertices_m, axis=0) for part in design.parts for piece in part.pieces]
