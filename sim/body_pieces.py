"""Convex pieces that bodies are put together from, in metres: x ahead, y to the left, z up, ground at 0."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from scipy.spatial import ConvexHull

from contracts import FloatArray
from sim.meshes import Mesh


class Material(StrEnum):
    """What a piece is made of; pieces of one material are of one colour."""

    PAINT = "paint"
    SECOND_PAINT = "second_paint"
    GLASS = "glass"
    TYRE = "tyre"
    TRIM = "trim"
    HEADLAMP = "headlamp"
    TAIL_LAMP = "tail_lamp"
    SKIN = "skin"
    HAIR = "hair"
    CLOTH = "cloth"
    TROUSERS = "trousers"
    BAG = "bag"


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex, closed mesh of one material."""

    material: Material
    mesh: Mesh


def solid(material: Material, points: Iterable[tuple[float, float, float]] | FloatArray) -> Piece:
    """The convex hull of points (N, 3)."""
    corners = np.array(list(points), np.float64)
    hull = ConvexHull(corners)
    a, b, c = (corners[hull.simplices[:, k]] for k in range(3))
    outwards = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) > 0
    faces = np.where(outwards[:, None], hull.simplices, hull.simplices[:, ::-1])
    return Piece(material, Mesh(corners[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3)))


def loft(material: Material, sections: Iterable[tuple[float, float, float]], *, y: float = 0.0) -> Piece:
    """The hull of level strips across the body, each (x, z, half its width), about the plane at ``y``."""
    return solid(material, [(x, y + side * half, z) for x, z, half in sections for side in (-1.0, 1.0)])


def block(material: Material, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Piece:
    """A box between these bounds."""
    return solid(material, [(a, b, c) for a in x for b in y for c in z])


def pair(material: Material, x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> list[Piece]:
    """The box and its mirror image on the right."""
    return [block(material, x, y, z), block(material, x, (-y[1], -y[0]), z)]


def wheel(x: float, radius: float, y: tuple[float, float], *, sides: int = 10) -> Piece:
    """A wheel that stands on the ground; one of its corners touches it."""
    angles = -np.pi / 2 + 2 * np.pi * np.arange(sides) / sides
    rim = [(x + radius * np.cos(a), radius + radius * np.sin(a)) for a in angles]
    return solid(Material.TYRE, [(u, v, w) for u, w in rim for v in y])


def limb(
    material: Material, a: tuple[float, float, float], b: tuple[float, float, float], thick: float, thin: float
) -> Piece:
    """A tapered bar of square section from ``a`` to ``b``, which are inside of it at its ends."""
    ends = [
        (x + dx, y + dy, z)
        for (x, y, z), half in ((a, thick / 2), (b, thin / 2))
        for dx in (-half, half)
        for dy in (-half, half)
    ]
    return solid(material, ends)


def ball(material: Material, centre: tuple[float, float, float], radii: tuple[float, float, float]) -> Piece:
    """An octagonal ball with flattened poles."""
    angles = np.pi / 8 + np.pi / 4 * np.arange(8)
    rings = [(0.55, -1.0), (1.0, -0.35), (1.0, 0.35), (0.55, 1.0)]
    points = [
        (centre[0] + radii[0] * share * np.cos(t), centre[1] + radii[1] * share * np.sin(t), centre[2] + radii[2] * z)
        for share, z in rings
        for t in angles
    ]
    return solid(material, points)
