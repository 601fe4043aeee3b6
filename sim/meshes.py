"""Triangle meshes of things that lie along a track or on the floor; vertices are not shared, so shading stays flat."""

from dataclasses import dataclass

import numpy as np

from contracts import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices (V, 3) in metres, world, and triangles (F, 3), counter-clockwise seen from outside."""

    vertices_m: FloatArray
    faces: IntArray


def merged(meshes: list[Mesh]) -> Mesh:
    """All meshes as one."""
    offsets = np.cumsum([0] + [len(mesh.vertices_m) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.vertices_m for mesh in meshes]),
        np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets, strict=True)]),
    )


def ribbon(line_m: FloatArray, *, left_m: float, right_m: float, bottom_m: float, top_m: float) -> Mesh:
    """A bar along ``line_m`` (N, 2) between its parallels ``left_m`` and ``right_m`` to the left; no underside."""
    tangent = np.gradient(line_m, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    left = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    outer, inner = line_m + left_m * left, line_m + right_m * left  # (N, 2) each

    def edge(points: FloatArray, z_m: float) -> FloatArray:
        return np.column_stack([points, np.full(len(points), z_m)])

    strips = [
        _strip(edge(outer, top_m), edge(inner, top_m)),
        _strip(edge(inner, top_m), edge(inner, bottom_m)),
        _strip(edge(outer, bottom_m), edge(outer, top_m)),
    ]
    return merged(strips)


def boxes(centres_m: FloatArray, headings_rad: FloatArray, size_m: FloatArray, *, bottom_m: float = 0.0) -> Mesh:
    """Equal boxes (length, width, height) that stand at ``centres_m`` (N, 2), turned by ``headings_rad``."""
    length, width, height = np.asarray(size_m) / (2, 2, 1)
    corners = np.array([[x, y] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]) * (length, width)  # (4, 2)
    cos, sin = np.cos(headings_rad), np.sin(headings_rad)
    turn = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)  # (N, 2, 2)
    ground = np.einsum("nij,kj->nki", turn, corners) + np.asarray(centres_m)[:, None]  # (N, 4, 2)
    n = len(ground)
    low = np.concatenate([ground, np.full((n, 4, 1), bottom_m)], axis=-1)
    high = np.concatenate([ground, np.full((n, 4, 1), bottom_m + height)], axis=-1)
    sides = [np.stack([low[:, k], low[:, k - 3], high[:, k - 3], high[:, k]], axis=1) for k in range(4)]
    return quads(np.concatenate([high, *sides]))


def prism(outline_m: FloatArray, *, bottom_m: float, top_m: float) -> Mesh:
    """An upright prism over a convex outline (C, 2), counter-clockwise, closed."""
    n = len(outline_m)
    low = np.column_stack([outline_m, np.full(n, bottom_m)])
    high = np.column_stack([outline_m, np.full(n, top_m)])
    fan = np.array([[0, k, k + 1] for k in range(1, n - 1)])
    sides = quads(np.stack([low, np.roll(low, -1, 0), np.roll(high, -1, 0), high], axis=1))
    return merged([Mesh(high, fan), Mesh(low, fan[:, ::-1]), sides])


def discs(centres_m: FloatArray, radius_m: float, *, slices: int = 32) -> Mesh:
    """Flat discs, seen from above, with centres (N, 3)."""
    angle = np.arange(slices) * (2 * np.pi / slices)
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(slices)]) * radius_m
    centres = np.asarray(centres_m, dtype=np.float64)
    vertices = np.concatenate([centres[:, None], centres[:, None] + rim], axis=1)  # (N, slices + 1, 3)
    around = np.arange(slices)
    fan = np.column_stack([np.zeros(slices, int), 1 + around, 1 + (around + 1) % slices])  # (slices, 3)
    faces = fan + (np.arange(len(centres)) * (slices + 1))[:, None, None]
    return Mesh(vertices.reshape(-1, 3), faces.reshape(-1, 3))


def _strip(first: FloatArray, second: FloatArray) -> Mesh:
    """The surface between two lines (N, 3); its front is where ``first`` lies to the left of ``second``."""
    return quads(np.stack([first[:-1], second[:-1], second[1:], first[1:]], axis=1))


def quads(corners_m: FloatArray) -> Mesh:
    """Quadrilaterals (Q, 4, 3), corners counter-clockwise seen from outside."""
    first = 4 * np.arange(len(corners_m))[:, None]
    faces = np.concatenate([first + np.array(half) for half in ((0, 1, 2), (0, 2, 3))])
    return Mesh(corners_m.reshape(-1, 3), faces)
