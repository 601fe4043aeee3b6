"""The bodies of all road users at one moment: their convex pieces where they truly are."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from contracts import FloatArray, IntArray
from contracts.truth import Truth
from sim.bodies import Appearance, Design, Part, appearance_of
from sim.gait import phase_rad

_UNMOVED = np.eye(3), np.zeros(3)


@dataclass(frozen=True)
class Wardrobe:
    """How road users look, always the same; ``seed`` decides it."""

    seed: int

    def appearance(self, kind: str, id_: str) -> Appearance:
        """Of one user."""
        return _appearance(kind, id_, self.seed)

    def pieces(self, state: Truth, row: int) -> list[FloatArray]:
        """Corners (P, 3), world, of every convex piece of one user's body."""
        design = self.appearance(state.kinds[row], state.ids[row]).design
        unit, starts, owned = _corners(design)
        if any(part.bone for part in design.parts):
            unit = unit.copy()
            for part, own in zip(design.parts, owned, strict=True):
                turn, shift = pose_of(part, state, row)
                unit[own] = unit[own] @ turn.T + shift
        return np.split(unit @ affine(state, row).T + state.positions_m[row], starts)


def affine(state: Truth, row: int) -> FloatArray:
    """From the unit box of a design to a user's true box, but for its position; (3, 3)."""
    cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
    return np.asarray(np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) * state.sizes_m[row])


def pose_of(part: Part, state: Truth, row: int) -> tuple[FloatArray, FloatArray]:
    """How a part of a user's design is moved within the unit box: turned by (3, 3), then shifted by (3,)."""
    if part.bone is None:
        return _UNMOVED
    return part.bone.pose(phase_rad(state, row), state.sizes_m[row])


@cache
def _appearance(kind: str, id_: str, seed: int) -> Appearance:
    return appearance_of(kind, id_, seed)


@cache
def _corners(design: Design) -> tuple[FloatArray, IntArray, list[slice]]:
    """Different corners (N, 3) of each piece, in the unit box; where those of the second and further ones start.

    Also which of them each part owns.
    """
    corners = [[np.unique(piece.vertices_m, axis=0) for piece in part.pieces] for part in design.parts]
    pieces = [piece for own in corners for piece in own]
    ends = np.cumsum([sum(map(len, own)) for own in corners]).tolist()
    owned = [slice(start, end) for start, end in zip([0, *ends], ends, strict=False)]
    return np.concatenate(pieces), np.cumsum([len(piece) for piece in pieces])[:-1], owned
