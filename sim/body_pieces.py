"""Convex pieces that bodies are put together from, in metres: x ahead, y to the left, z up, ground at 0.

What is in front and behind, or left and right of a body, is often one piece that goes through it: nobody sees inside.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from scipy.spatial import ConvexHull

from contracts import FloatArray
from sim.gait import Bone
from sim.meshes import Mesh

Size = tuple[float, float, float]
Point = tuple[float, float, float]
Line = Callable[[float], float]


class Material(StrEnum):
    """What a piece is made of; pieces of one material are of one colour."""

    PAINT = "paint"
    SECOND_PAINT = "second_paint"
    GLASS = "glass"
    TYRE = "tyre"
    METAL = "metal"
    TRIM = "trim"
    HEADLAMP = "headlamp"
    TAIL_LAMP = "tail_lamp"
    SKIN = "skin"
    HAIR = "hair"
    CLOTH = "cloth"
    TROUSERS = "trousers"
    BAG = "bag"
    CARGO = "cargo"


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex, closed mesh of one material, as a stride begins. bone: what moves it, if anything does."""

    material: Material
    mesh: Mesh
    bone: Bone | None = None

    def placed(self, *, scale: Size = (1.0, 1.0, 1.0), x: float = 0.0) -> "Piece":
        """The piece scaled about the origin, then so much further ahead."""
        return self.moved(np.array(scale), np.array([x, 0.0, 0.0]))

    def moved(self, scale: FloatArray, shift: FloatArray) -> "Piece":
        """The piece scaled about the origin by (3,), then shifted by (3,)."""
        bone = None if self.bone is None else self.bone.moved(scale, shift)
        return Piece(self.material, Mesh(self.mesh.vertices_m * scale + shift, self.mesh.faces), bone)

    def on(self, bone: Bone) -> "Piece":
        """The piece, moved by a bone."""
        return replace(self, bone=bone)


Builder = Callable[[Size], list[Piece]]


def line(a: tuple[float, float], b: tuple[float, float]) -> Line:
    """The straight line through two points, as a function of their first coordinate."""
    return lambda t: a[1] + (t - a[0]) * (b[1] - a[1]) / (b[0] - a[0])


def solid(material: Material, points: Iterable[Point] | FloatArray) -> Piece:
    """The convex hull of points (N, 3)."""
    corners = np.array(list(points), np.float64)
    hull = ConvexHull(corners)
    a, b, c = (corners[hull.simplices[:, k]] for k in range(3))
    outwards = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) > 0
    faces = np.where(outwards[:, None], hull.simplices, hull.simplices[:, ::-1])
    return Piece(material, Mesh(corners[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)))


def loft(material: Material, sections: Iterable[Point], *, y: float = 0.0) -> Piece:
    """The hull of level strips across the body, each (x, z, half its width), about the plane at ``y``."""
    return solid(material, [(x, y + side * half, z) for x, z, half in sections for side in (-1.0, 1.0)])


def block(material: Material, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Piece:
    """A box between these bounds."""
    return solid(material, [(a, b, c) for a in x for b in y for c in z])


def pair(material: Material, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> list[Piece]:
    """The box and its mirror image on the right."""
    return [block(material, x, y, z), block(material, x, (-y[1], -y[0]), z)]


def across(material: Material, profile: Iterable[tuple[float, float]], half: Line, *, proud: float = 0.0) -> Piece:
    """A side view (x, z) through the whole width; ``half`` of it by height, and ``proud`` more."""
    return loft(material, [(x, z, half(z) + proud) for x, z in profile])


def around(material: Material, plan: Iterable[tuple[float, float]], z: tuple[float, float]) -> Piece:
    """A plan, each (x, half the width), between two heights."""
    return loft(material, [(x, height, half) for x, half in plan for height in z])


def disc(material: Material, centre: tuple[float, float], radius: float, y: tuple[float, float], sides: int) -> Piece:
    """An upright disc about ``centre`` (x, z), on a flat side; as wide as high if ``sides`` is 4, 8, 12, ..."""
    angles = -np.pi / 2 + np.pi * (2 * np.arange(sides) + 1) / sides
    rim = radius / np.cos(np.pi / sides) * np.column_stack([np.cos(angles), np.sin(angles)]) + centre
    return solid(material, [(u, v, w) for u, w in rim.tolist() for v in y])


def wheel(x: float, radius: float, y: tuple[float, float], *, sides: int = 8) -> Piece:
    """A wheel that stands on the ground."""
    return disc(Material.TYRE, (x, radius), radius, y, sides)


def limb(material: Material, a: Point, b: Point, thick: float, thin: float) -> Piece:
    """A tapered bar of square section between two points, ``thick`` at ``a`` and ``thin`` at ``b``."""
    along = np.subtract(b, a)
    level = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    level /= np.linalg.norm(level)
    upright = np.cross(along, level) / np.linalg.norm(along)
    signs = np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)])
    section = signs @ np.array([level, upright])  # (4, 3)
    return solid(material, np.concatenate([a + 0.5 * thick * section, b + 0.5 * thin * section]))


def ball(material: Material, centre: Point, radii: Size) -> Piece:
    """A hexagonal ball with flattened poles."""
    angles = np.pi / 6 + np.pi / 3 * np.arange(6)
    points = [
        (centre[0] + radii[0] * share * np.cos(t), centre[1] + radii[1] * share * np.sin(t), centre[2] + radii[2] * z)
        for share, z in ((0.6, -1.0), (1.1, -0.1), (0.65, 1.0))
        for t in angles
    ]
    return solid(material, points)
