"""Coachwork: what cars, vans, trucks and buses have in common, made of the pieces of ``sim.body_pieces``."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sim.body_pieces import Line, Material, Piece, Size, across, disc, loft, wheel

PROUD_M = 0.008  # by which glass, lamps and wheels stand out of the paint: more than a depth buffer confuses at 100 m


@dataclass(frozen=True)
class Coachwork:
    """A body in paint, from which glass, mirrors, lamps and wheels stand out. size: the whole body's, metres."""

    size: Size

    @cached_property
    def end(self) -> float:
        """From the middle to the paint's front and rear end."""
        return self.size[0] / 2 - 2 * PROUD_M

    @cached_property
    def half(self) -> float:
        """Half of the paint's greatest width: mirrors and wheels stand out of it."""
        return self.size[1] / 2 - 0.02


def pane(low: tuple[float, float], high: tuple[float, float], half: Line, *, front: bool) -> Piece:
    """Glass across the body, in front or behind, on the slope from ``low`` to ``high`` (x, z)."""
    (x0, z0), (x1, z1) = low, high
    outwards = np.array([z1 - z0, x0 - x1]) / np.hypot(x1 - x0, z1 - z0) * (1.0 if front else -1.0)
    out, back = PROUD_M * outwards, -0.06 * outwards
    return loft(Material.GLASS, [(x + dx, z + dz, half(z)) for x, z in (low, high) for dx, dz in (out, back)])


def wrapped(
    material: Material, ends: tuple[Line, float], corners: tuple[Line, float], z: tuple[float, float], depth: float
) -> Piece:
    """A band around a front or rear end, between two heights.

    ends, corners: x by height, and half the width, of the band in the middle and where it ends on the flanks.
    depth: from the corners to its hidden back, negative in front.
    """
    strips = ((ends, 0.0), (corners, 0.0), (corners, depth))
    return loft(material, [(x_at(height) + shift, height, half) for height in z for (x_at, half), shift in strips])


def hubs(x: float, radius: float, half: float, *, share: float = 0.62) -> Piece:
    """The rims of both wheels with the axle between them, ``share`` of the wheels' radius."""
    return disc(Material.METAL, (x, radius), share * radius, (-half, half), 6)


def axle(x: float, radius: float, low: float, half: float) -> list[Piece]:
    """Wheels in dark arches that begin at ``low``; the body, of ``half`` a width, hides the middle of each piece."""
    foot, top = 1.3 * radius, 0.75 * radius
    outline = ((-foot, low), (-top, 2.18 * radius), (top, 2.18 * radius), (foot, low))
    arch = across(Material.TRIM, [(x + along, z) for along, z in outline], lambda _: half, proud=0.5 * PROUD_M)
    tyres = wheel(x, radius, (-half - PROUD_M, half + PROUD_M))
    return [arch, tyres, hubs(x, radius, half + 2 * PROUD_M)]


def open_axle(x: float, radius: float, half: float, tread: float) -> list[Piece]:
    """Wheels under an open chassis: two, of this tread, and their hubs."""
    tyres = [wheel(x, radius, (side * half, side * (half - tread))) for side in (-1.0, 1.0)]
    return [*tyres, hubs(x, radius, half + PROUD_M, share=0.5)]
