"""What rolls among pedestrians: strollers with whoever pushes them, and delivery robots."""

from functools import partial

from sim.body_pieces import Builder, Material, Piece, Size, block, limb, loft, pair, wheel
from sim.people_bodies import Outfit, person


def stroller(size: Size, *, outfit: Outfit, carrycot: bool = False) -> list[Piece]:
    """A stroller and whoever pushes it. carrycot: the child lies rather than sits."""
    length, width, height = size
    front, half = length / 2, width / 2
    parent = [piece.placed(x=0.22 - front) for piece in person(outfit, (0.40, 0.50, height))]
    radius, axles = 0.13, (0.06, front - 0.13)
    return [
        *parent,
        *(_carrycot(half) if carrycot else _seat(front, half)),
        *(wheel(x, radius, (s * half, s * (half - 0.06))) for x in axles for s in (-1.0, 1.0)),
        block(Material.METAL, (axles[0], axles[1]), (0.06 - half, half - 0.06), (0.11, 0.15)),
        *(
            limb(Material.METAL, (0.45, s * (half - 0.09), 0.14), (-0.10, s * 0.22, 1.06), 0.04, 0.04)
            for s in (-1.0, 1.0)
        ),
        block(Material.TRIM, (-0.13, -0.08), (-0.24, 0.24), (1.02, 1.07)),
    ]


def _seat(front: float, half: float) -> list[Piece]:
    back = [
        (0.10, 0.42, 0.7 * half),
        (front - 0.20, 0.40, 0.7 * half),
        (0.02, 0.86, 0.7 * half),
        (front - 0.24, 0.58, 0.7 * half),
    ]
    hood = [(0.00, 0.70, 0.76 * half), (0.04, 1.00, 0.72 * half), (0.30, 1.04, 0.72 * half), (0.42, 0.84, 0.76 * half)]
    rest = [
        (front - 0.26, 0.42, 0.6 * half),
        (front - 0.06, 0.26, 0.6 * half),
        (front - 0.24, 0.50, 0.6 * half),
        (front - 0.04, 0.34, 0.6 * half),
    ]
    return [loft(Material.PAINT, back), loft(Material.SECOND_PAINT, hood), loft(Material.PAINT, rest)]


def _carrycot(half: float) -> list[Piece]:
    tub = [(0.06, 0.46, 0.6 * half), (0.56, 0.46, 0.6 * half), (-0.02, 0.78, 0.76 * half), (0.66, 0.78, 0.76 * half)]
    hood = [(-0.03, 0.74, 0.8 * half), (0.06, 1.02, 0.74 * half), (0.22, 1.02, 0.74 * half), (0.34, 0.76, 0.8 * half)]
    blanket = [
        (0.30, 0.74, 0.72 * half),
        (0.64, 0.74, 0.72 * half),
        (0.32, 0.84, 0.66 * half),
        (0.58, 0.83, 0.66 * half),
    ]
    return [loft(Material.PAINT, tub), loft(Material.PAINT, hood), loft(Material.SECOND_PAINT, blanket)]


def robot(size: Size, *, flag: bool = False) -> list[Piece]:
    """A delivery robot on six wheels, its lid in a second colour."""
    length, width, height = size
    end, half, top = length / 2, width / 2, height - 0.16
    tub = [
        (-end + 0.01, 0.16, 0.78),
        (end - 0.03, 0.16, 0.78),
        (-end, 0.34, 0.86),
        (end - 0.01, 0.34, 0.86),
        (-end + 0.05, top - 0.06, 0.80),
        (end - 0.10, top - 0.06, 0.80),
    ]
    lid = [
        (-end + 0.05, top - 0.07, 0.80),
        (end - 0.11, top - 0.07, 0.80),
        (-end + 0.12, top, 0.62),
        (end - 0.22, top, 0.62),
    ]
    return [
        loft(Material.PAINT, [(x, z, share * half) for x, z, share in tub]),
        loft(Material.SECOND_PAINT, [(x, z, share * half) for x, z, share in lid]),
        *_eyes(end, height, top, mast=flag),
        *(wheel(x, 0.11, (-half, half)) for x in (-0.24, 0.0, 0.24)),
        *pair(Material.HEADLAMP, (end - 0.06, end), (0.12, 0.20), (0.30, 0.36)),
        block(Material.TRIM, (end - 0.1, end - 0.006), (-0.09, 0.09), (0.28, 0.38)),
        block(Material.TAIL_LAMP, (-end - 0.008, 0.06 - end), (-0.16, 0.16), (0.30, 0.35)),
    ]


def _eyes(end: float, height: float, top: float, *, mast: bool) -> list[Piece]:
    if not mast:
        dome = [
            (0.05 + x, z, half)
            for z, x_s, half in ((top - 0.02, (-0.11, 0.11), 0.11), (height, (-0.07, 0.07), 0.07))
            for x in x_s
        ]
        return [loft(Material.TRIM, dome)]
    pole = block(Material.TRIM, (0.08 - end, 0.11 - end), (-0.015, 0.015), (top - 0.10, height))
    pennant = block(Material.SECOND_PAINT, (0.09 - end, 0.25 - end), (-0.006, 0.006), (height - 0.10, height - 0.005))
    return [pole, pennant]


CARTS: dict[str, dict[str, Builder]] = {
    "stroller": {
        "stroller": partial(stroller, outfit=Outfit(pushes=True)),
        "stroller_and_long_hair": partial(stroller, outfit=Outfit(pushes=True, long_hair=True)),
        "carrycot_and_coat": partial(stroller, outfit=Outfit(pushes=True, coat=True, long_hair=True), carrycot=True),
        "carrycot_and_backpack": partial(stroller, outfit=Outfit(pushes=True, carries="backpack"), carrycot=True),
    },
    "robot": {"with_dome": robot, "with_flag": partial(robot, flag=True)},
}
"""Builders of bodies by kind and name."""
