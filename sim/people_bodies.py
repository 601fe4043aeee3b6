"""People on foot, in mid-stride."""

from dataclasses import dataclass
from functools import partial

from sim.body_pieces import Builder, Material, Piece, Size, ball, block, limb, loft

_ADULT: Size = (0.40, 0.50, 1.72)  # everybody is built of this size, and scaled to their own
_HEAD_M = 0.235  # from chin to crown


@dataclass(frozen=True)
class Outfit:
    """What somebody wears and carries.

    skirt: to the knees, legs bare. coat: to below the knees. long_hair: down to the shoulders.
    carries: ``backpack``, ``bag``, or nothing. pushes: with both hands ahead, instead of swinging them.
    head: its size, that of a grown-up being 1.
    """

    skirt: bool = False
    coat: bool = False
    long_hair: bool = False
    carries: str = ""
    pushes: bool = False
    head: float = 1.0


def person(outfit: Outfit, size: Size = _ADULT) -> list[Piece]:
    """Somebody about the origin."""
    chin = _ADULT[2] - outfit.head * _HEAD_M
    pieces = [
        *_legs(Material.SKIN if outfit.skirt else Material.TROUSERS),
        *_clothes(outfit, chin),
        *_arms(chin - 0.10, pushes=outfit.pushes),
        *head(0.0, _ADULT[2], size=outfit.head, long_hair=outfit.long_hair),
        *_luggage(outfit.carries, chin - 0.10),
    ]
    scale = (size[0] / _ADULT[0], size[1] / _ADULT[1], size[2] / _ADULT[2])
    return [piece.placed(scale=scale) for piece in pieces]


def head(x: float, top: float, *, size: float = 1.0, long_hair: bool = False) -> list[Piece]:
    """Neck, face and hair, the face looking ahead."""
    chin = top - size * _HEAD_M
    pieces = [
        limb(Material.SKIN, (x - 0.01, 0.0, chin - 0.08), (x, 0.0, chin + 0.06), 0.11, 0.10),
        ball(Material.SKIN, (x + 0.025, 0.0, 0.5 * (chin + top) - 0.005), (0.09 * size, 0.075 * size, 0.115 * size)),
        ball(Material.HAIR, (x - 0.025, 0.0, top - 0.075 * size), (0.10 * size, 0.09 * size, 0.075 * size)),
    ]
    if long_hair:
        crown = [(x - 0.12, top - 0.10, 0.07), (x - 0.01, top - 0.08, 0.10)]
        pieces.append(loft(Material.HAIR, [*crown, (x - 0.14, chin - 0.08, 0.09), (x - 0.07, chin - 0.08, 0.10)]))
    return pieces


def _legs(cloth: Material) -> list[Piece]:
    """One step: the left foot ahead, the right one behind, on its toes."""
    bent, stretched = (0.07, 0.09, 0.48), (-0.01, -0.09, 0.47)
    return [
        limb(cloth, (0.0, 0.09, 0.90), bent, 0.17, 0.13),
        limb(cloth, bent, (0.09, 0.09, 0.05), 0.12, 0.09),
        limb(cloth, (0.0, -0.09, 0.90), stretched, 0.17, 0.13),
        limb(cloth, stretched, (-0.13, -0.09, 0.09), 0.12, 0.09),
        block(Material.TRIM, (-0.02 + 0.04, 0.20), (0.04, 0.14), (0.0, 0.08)),
        block(Material.TRIM, (-0.20, 0.0), (-0.14, -0.04), (0.02, 0.10)),
    ]


def _clothes(outfit: Outfit, chin: float) -> list[Piece]:
    trunk = _symmetric(((0.86, 0.10, 0.155), (1.28, 0.115, 0.195), (chin - 0.03, 0.07, 0.12)))
    pieces = [loft(Material.CLOTH, trunk)]
    if outfit.coat:
        pieces.append(loft(Material.CLOTH, _symmetric(((0.40, 0.19, 0.19), (1.0, 0.115, 0.165)))))
    if outfit.skirt:
        pieces.append(loft(Material.TROUSERS, _symmetric(((0.54, 0.18, 0.19), (0.98, 0.11, 0.16)))))
    return pieces


def _symmetric(levels: tuple[tuple[float, float, float], ...]) -> list[tuple[float, float, float]]:
    """Sections of something as deep ahead as behind, each (z, half its depth, half its width)."""
    return [(side * deep, z, half) for z, deep, half in levels for side in (-1.0, 1.0)]


def _arms(shoulder: float, *, pushes: bool) -> list[Piece]:
    """Sleeves and hands; each arm swings against its leg, or both reach for a handle."""
    pieces = []
    for side in (-1.0, 1.0):
        (x, z) = (0.40, 1.06) if pushes else (-side * 0.13, 0.84)
        wrist = (0.8 * x, side * 0.21, 0.2 * shoulder + 0.8 * z)
        pieces += [
            limb(Material.CLOTH, (0.0, side * 0.20, shoulder), wrist, 0.10, 0.08),
            limb(Material.SKIN, wrist, (x, side * 0.21, z), 0.06, 0.07),
        ]
    return pieces


def _luggage(carries: str, shoulder: float) -> list[Piece]:
    if carries == "backpack":
        return [block(Material.BAG, (-0.21, -0.09), (-0.15, 0.15), (0.98, shoulder))]
    if carries == "bag":
        return [block(Material.BAG, (-0.05, 0.19), (-0.25, -0.15), (0.56, 0.84))]
    return []


_CHILD_HEAD = 1.22
_ADULTS = {
    "walker": Outfit(),
    "with_backpack": Outfit(carries="backpack"),
    "with_bag": Outfit(long_hair=True, carries="bag"),
    "in_coat": Outfit(coat=True),
    "in_long_coat": Outfit(coat=True, long_hair=True, carries="bag"),
    "in_skirt": Outfit(skirt=True, long_hair=True),
}
_CHILDREN = {
    "walker": Outfit(head=_CHILD_HEAD),
    "with_satchel": Outfit(carries="backpack", head=_CHILD_HEAD),
    "in_skirt": Outfit(skirt=True, long_hair=True, head=_CHILD_HEAD),
}
PEOPLE: dict[str, dict[str, Builder]] = {
    "adult": {name: partial(person, outfit) for name, outfit in _ADULTS.items()},
    "child": {name: partial(person, outfit) for name, outfit in _CHILDREN.items()},
}
"""Builders of bodies by kind and name."""
