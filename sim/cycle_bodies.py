"""Bicycles and motorcycles, with their riders."""

from cmath import rect
from dataclasses import dataclass, replace
from functools import partial
from math import pi

from sim.body_pieces import Builder, Material, Piece, Size, ball, block, disc, limb, loft, wheel
from sim.gait import Bone, Joint, Place, carried, fixed
from sim.people_bodies import head


@dataclass(frozen=True)
class Posture:
    """Where a rider sits, holds on and has the feet: points (x, z). helmet: ``none``, ``open`` or ``full``."""

    seat: tuple[float, float]
    bar: tuple[float, float]
    feet: tuple[tuple[float, float], tuple[float, float]]
    helmet: str
    long_hair: bool = False

    def pedal(self, foot: Place) -> Joint:
        """Where one of the feet is: on a circle about the middle of both, ahead at its top."""
        middle = 0.5 * (complex(*self.feet[0]) + complex(*self.feet[1]))

        def turned(phase: float) -> Place:
            place = middle + (complex(*foot) - middle) * rect(1.0, -phase)
            return place.real, place.imag

        return turned


def rider(posture: Posture, top: float) -> list[Piece]:
    """Somebody who rides, the crown or helmet at height ``top``."""
    (seat_x, seat_z), (bar_x, bar_z) = posture.seat, posture.bar
    neck = (0.55 * seat_x + 0.45 * bar_x, top - 0.30)
    pieces = [limb(Material.CLOTH, (seat_x, 0.0, seat_z - 0.04), (neck[0], 0.0, neck[1]), 0.28, 0.32)]
    for side, foot in zip((-1.0, 1.0), posture.feet, strict=True):
        pieces.append(
            limb(Material.CLOTH, (neck[0], side * 0.20, neck[1] - 0.07), (bar_x, side * 0.25, bar_z), 0.12, 0.08)
        )
        pieces += _leg(posture.seat, posture.pedal(foot), side)
    return [*pieces, *_headgear(neck[0] + 0.06, top, posture)]


def _leg(hip: Place, foot: Joint, side: float) -> list[Piece]:
    """The knee ahead of both; feet that stay do not move the leg."""

    def knee(phase: float) -> Place:
        x, z = foot(phase)
        return max(hip[0], x) + 0.24, 0.5 * (hip[1] + z) + 0.12

    (knee_x, knee_z), (x, z), y = knee(0.0), foot(0.0), side * 0.13
    ankle, bend = (x, y, z), (knee_x, 1.1 * y, knee_z)
    thigh = limb(Material.TROUSERS, (hip[0], side * 0.09, hip[1]), bend, 0.18, 0.14)
    shin = limb(Material.TROUSERS, bend, ankle, 0.13, 0.09)
    shoe = block(Material.TRIM, (x - 0.08, x + 0.16), (y - 0.05, y + 0.05), (z - 0.06, z + 0.03))
    if foot(0.0) == foot(pi):
        return [thigh, shin, shoe]
    return [thigh.on(Bone(fixed(hip), knee)), shin.on(Bone(knee, foot)), shoe.on(carried(foot))]


def _headgear(x: float, top: float, posture: Posture) -> list[Piece]:
    if posture.helmet == "none":
        return head(x, top, long_hair=posture.long_hair)
    if posture.helmet == "open":
        return [*head(x, top - 0.02), ball(Material.SECOND_PAINT, (x, 0.0, top - 0.075), (0.135, 0.105, 0.075))]
    visor = [(x + 0.02, z, 0.095) for z in (top - 0.17, top - 0.09)] + [
        (x + 0.15, z, 0.05) for z in (top - 0.17, top - 0.10)
    ]
    return [ball(Material.SECOND_PAINT, (x, 0.0, top - 0.135), (0.13, 0.115, 0.135)), loft(Material.GLASS, visor)]


def bicycle(posture: Posture, size: Size) -> list[Piece]:
    """A bicycle and its rider."""
    length, width, height = size
    radius = 0.34
    axle, (seat_x, seat_z), (bar_x, bar_z) = length / 2 - radius, posture.seat, posture.bar
    crank, neck = (-0.08, 0.0, 0.29), (bar_x + 0.06, 0.0, bar_z - 0.20)
    return [
        *(wheel(x, radius, (-0.02, 0.02), sides=12) for x in (-axle, axle)),
        *(disc(Material.METAL, (x, radius), 0.84 * radius, (-0.024, 0.024), 6) for x in (-axle, axle)),
        limb(Material.PAINT, (-axle, 0.0, radius), crank, 0.08, 0.06),
        limb(Material.PAINT, crank, (seat_x, 0.0, seat_z - 0.06), 0.05, 0.05),
        limb(Material.PAINT, crank, neck, 0.06, 0.06),
        limb(Material.PAINT, (seat_x + 0.03, 0.0, seat_z - 0.16), neck, 0.05, 0.05),
        limb(Material.TRIM, (axle, 0.0, radius), (bar_x, 0.0, bar_z), 0.07, 0.05),
        block(Material.TRIM, (bar_x - 0.025, bar_x + 0.025), (-width / 2, width / 2), (bar_z - 0.025, bar_z + 0.025)),
        block(Material.TRIM, (seat_x - 0.15, seat_x + 0.11), (-0.07, 0.07), (seat_z - 0.06, seat_z)),
        *rider(posture, height),
    ]


def cargo_bicycle(posture: Posture, size: Size) -> list[Piece]:
    """A bicycle with a crate behind its rider."""
    crate = block(Material.BAG, (-0.80, -0.40), (-0.22, 0.22), (0.74, 1.10))
    return [*bicycle(posture, size), crate]


def motorcycle(posture: Posture, size: Size) -> list[Piece]:
    """A motorcycle and its rider."""
    length, width, height = size
    radius = 0.31
    axle, (bar_x, bar_z) = length / 2 - radius, posture.bar
    tail = [(-axle - 0.18, 0.74, 0.10), (-axle - 0.14, 0.84, 0.08), (-0.10, 0.52, 0.16), (-0.10, 0.80, 0.15)]
    tank = [(-0.14, 0.70, 0.13), (0.34, 0.66, 0.17), (-0.04, 0.92, 0.10), (0.30, 0.98, 0.15)]
    fairing = [
        (bar_x - 0.02, 0.62, 0.17),
        (bar_x + 0.16, 0.70, 0.12),
        (bar_x, bar_z + 0.06, 0.14),
        (bar_x + 0.10, 0.98, 0.12),
    ]
    return [
        *(piece for x in (-axle, axle) for piece in _fat_wheel(x, radius)),
        limb(Material.METAL, (axle, 0.0, radius), (bar_x, 0.0, bar_z - 0.05), 0.20, 0.12),
        loft(Material.PAINT, tail),
        loft(Material.PAINT, tank),
        loft(Material.PAINT, fairing),
        block(Material.METAL, (-0.34, 0.30), (-0.17, 0.17), (0.22, 0.60)),
        block(Material.TRIM, (-axle, -0.30), (-0.06, 0.06), (0.24, 0.40)),
        *_handlebar(bar_x, bar_z, width),
        block(Material.HEADLAMP, (bar_x + 0.05, bar_x + 0.17), (-0.09, 0.09), (0.76, 0.90)),
        block(Material.TAIL_LAMP, (-axle - 0.21, -axle - 0.12), (-0.08, 0.08), (0.72, 0.81)),
        *rider(posture, height),
    ]


def scooter(posture: Posture, size: Size) -> list[Piece]:
    """A scooter, its rider, and a box for what they deliver."""
    length, width, height = size
    radius = 0.25
    axle, (bar_x, bar_z) = length / 2 - radius - 0.03, posture.bar
    rear = [
        (-axle - 0.20, 0.62, 0.14),
        (-axle - 0.16, 0.78, 0.12),
        (-0.12, 0.28, 0.17),
        (-0.12, 0.74, 0.15),
        (-axle, 0.34, 0.12),
    ]
    shield = [
        (bar_x - 0.02, 0.24, 0.20),
        (bar_x + 0.14, 0.34, 0.14),
        (bar_x - 0.06, 0.96, 0.20),
        (bar_x + 0.06, 0.94, 0.12),
    ]
    return [
        *(piece for x in (-axle, axle) for piece in _fat_wheel(x, radius)),
        limb(Material.PAINT, (axle, 0.0, radius), (bar_x, 0.0, bar_z), 0.22, 0.12),
        loft(Material.PAINT, rear),
        loft(Material.PAINT, shield),
        block(Material.TRIM, (-0.20, bar_x + 0.02), (-0.16, 0.16), (0.22, 0.32)),
        *_handlebar(bar_x, bar_z, width),
        block(Material.HEADLAMP, (bar_x + 0.02, bar_x + 0.14), (-0.09, 0.09), (0.80, 0.92)),
        block(Material.TAIL_LAMP, (-axle - 0.22, -axle - 0.12), (-0.10, 0.10), (0.66, 0.75)),
        block(Material.BAG, (-axle - 0.25, -axle + 0.20), (-0.23, 0.23), (0.80, 1.24)),
        *rider(posture, height),
    ]


def _fat_wheel(x: float, radius: float) -> list[Piece]:
    rim = disc(Material.METAL, (x, radius), 0.6 * radius, (-0.075, 0.075), 6)
    return [wheel(x, radius, (-0.065, 0.065)), rim]


def _handlebar(x: float, z: float, width: float) -> list[Piece]:
    """The bar between the hands, and two mirrors."""
    bar = block(Material.TRIM, (x - 0.03, x + 0.03), (-0.32, 0.32), (z - 0.03, z + 0.03))
    mirrors = [
        limb(Material.TRIM, (x, side * 0.28, z), (x + 0.04, side * (width / 2 - 0.05), z + 0.14), 0.04, 0.10)
        for side in (-1.0, 1.0)
    ]
    return [bar, *mirrors]


_UPRIGHT = Posture((-0.28, 0.92), (0.30, 1.04), ((-0.06, 0.14), (-0.10, 0.42)), "none")
_HELMETED = replace(_UPRIGHT, helmet="open")
_LONG_HAIRED = replace(_UPRIGHT, long_hair=True)
_RACING = Posture((-0.26, 0.96), (0.46, 0.92), ((-0.06, 0.14), (-0.10, 0.42)), "open")
_ASTRIDE = Posture((-0.34, 0.80), (0.38, 1.00), ((-0.16, 0.32), (-0.16, 0.32)), "full")
_SEATED = Posture((-0.34, 0.76), (0.34, 1.00), ((0.10, 0.38), (0.10, 0.38)), "full")
_SEATED_OPEN = replace(_SEATED, helmet="open")

CYCLES: dict[str, dict[str, Builder]] = {
    "bicycle": {
        "city_bicycle": partial(bicycle, _UPRIGHT),
        "ladies_bicycle": partial(bicycle, _LONG_HAIRED),
        "racing_bicycle": partial(bicycle, _RACING),
        "cargo_bicycle": partial(cargo_bicycle, _HELMETED),
    },
    "motorcycle": {
        "motorcycle": partial(motorcycle, _ASTRIDE),
        "delivery_scooter": partial(scooter, _SEATED),
        "scooter": partial(scooter, _SEATED_OPEN),
    },
}
"""Builders of bodies by kind and name."""
