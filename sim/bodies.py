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
from sim.gait import Bone
from sim.lights import Rgb
from sim.meshes import Mesh, merged
from sim.people_bodies import PEOPLE
from sim.road_users import KINDS
from sim.streams import stream
from sim.truck_bodies import TRUCKS


@dataclass(frozen=True, eq=False)
class Part:
    """What of a design is of one material and moves as one.

    pieces: convex and closed, in the unit box. bone: what moves them, in the unit box; None where nothing does.
    """

    material: Material
    pieces: tuple[Mesh, ...]
    bone: Bone | None = None

    @cached_property
    def mesh(self) -> Mesh:
        """All pieces as one."""
        return merged(list(self.pieces))


@dataclass(frozen=True, eq=False)
class Design:
    """A body in the unit box: x ahead and y to the left in [-0.5, 0.5], z in [0, 1], in every phase of a stride."""

    name: str
    parts: tuple[Part, ...]

    @property
    def materials(self) -> tuple[Material, ...]:
        """All that there are, each once."""
        return tuple(dict.fromkeys(part.material for part in self.parts))


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
    return Appearance(design, {material: colour_of(kind, material, rng) for material in design.materials})


def _design(name: str, pieces: list[Piece]) -> Design:
    """Stretched a little to touch all faces of the unit box."""
    corners = np.concatenate([piece.mesh.vertices_m for piece in pieces])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = 1.0 / (high - low)
    unit = [piece.moved(scale, -low * scale - (0.5, 0.5, 0.0)) for piece in pieces]
    parts: list[Part] = []
    for material in dict.fromkeys(piece.material for piece in pieces):
        own = [piece for piece in unit if piece.material is material]
        still = tuple(piece.mesh for piece in own if piece.bone is None)
        parts += [Part(material, still)] if still else []
        parts += [Part(material, (piece.mesh,), piece.bone) for piece in own if piece.bone is not None]
    return Design(name, tuple(parts))


BUILDERS = CARS | TRUCKS | BUSES | CYCLES | PEOPLE | CARTS
"""What builds a design of a kind's size, by kind and name."""

DESIGNS: dict[str, tuple[Design, ...]] = {
    kind: tuple(_design(f"{kind}/{name}", build(KINDS[kind].size_m)) for name, build in builders.items())
    for kind, builders in BUILDERS.items()
}
"""Designs by the kind of road user."""
