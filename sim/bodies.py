"""How road users look: designs of convex pieces in a unit box, and colours drawn from the seed.

A design is scaled to its user's true box, all six faces of which it touches: the box of the truth is the body's own.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim.body_colours import colour_of
from sim.body_pieces import Material, Piece
from sim.bus_bodies import BUSES
from sim.car_bodies import CARS
from sim.cart_bodies import CARTS
from sim.cycle_bodies import CYCLES
from sim.lights import Rgb
from sim.meshes import Mesh, merged
from sim.people_bodies import PEOPLE
from sim.road_users import KINDS
from sim.streams import stream
from sim.truck_bodies import TRUCKS


@dataclass(frozen=True, eq=False)
class Part:
    """What of a design is of one material. pieces: convex and closed, in the unit box."""

    material: Material
    pieces: tuple[Mesh, ...]

    @cached_property
    def mesh(self) -> Mesh:
        """All pieces as one."""
        return merged(list(self.pieces))


@dataclass(frozen=True, eq=False)
class Design:
    """A body in the unit box: x ahead and y to the left in [-0.5, 0.5], z in [0, 1]; one part per material."""

    name: str
    parts: tuple[Part, ...]


@dataclass(frozen=True, eq=False)
class Appearance:
    """One user's look: a design, and a colour for each of its materials."""

    design: Design
    colours: dict[Material, Rgb]


def appearance_of(kind: str, id_: str, seed: int) -> Appearance:
    """The look of one user, always the same; ``kind`` is one of ``sim.road_users.KINDS``."""
    rng = stream(seed, f"appearance/{id_}")
    designs = DESIGNS[kind]
    design = designs[rng.integers(len(designs))]
    return Appearance(design, {part.material: colour_of(kind, part.material, rng) for part in design.parts})


def _design(name: str, pieces: list[Piece]) -> Design:
    """Stretched a little to touch all faces of the unit box."""
    corners = np.concatenate([piece.mesh.vertices_m for piece in pieces])
    low, high = corners.min(axis=0), corners.max(axis=0)

    def unit(mesh: Mesh) -> Mesh:
        return Mesh((mesh.vertices_m - low) / (high - low) - (0.5, 0.5, 0.0), mesh.faces)

    materials = dict.fromkeys(piece.material for piece in pieces)
    parts = (Part(m, tuple(unit(piece.mesh) for piece in pieces if piece.material is m)) for m in materials)
    return Design(name, tuple(parts))


BUILDERS = CARS | TRUCKS | BUSES | CYCLES | PEOPLE | CARTS
"""What builds a design of a kind's size, by kind and name."""

DESIGNS: dict[str, tuple[Design, ...]] = {
    kind: tuple(_design(f"{kind}/{name}", build(KINDS[kind].size_m)) for name, build in builders.items())
    for kind, builders in BUILDERS.items()
}
"""Designs by the kind of road user."""
