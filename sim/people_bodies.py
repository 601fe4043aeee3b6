"""People on foot, who stride."""

from dataclasses import dataclass
from functools import partial
from math import cos, pi, sin

from sim.body_pieces import Builder, Material, Piece, Size, ball, block, limb, loft
from sim.gait import Bone, Place, carried, fixed, later

_ADULT: Size = (0.40, 0.50, 1.72)  # everybody is built of this size, and scaled to their own
_HEAD_M = 0.235  # from chin to crown
_HIP, _HANDLE = (0.0, 0.90), (0.40, 1.06)


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
    """At the beginning of a stride the left foot is ahead, the right one behind, on its toes."""
    return [piece for side in (1.0, -1.0) for piece in _leg(cloth, side)]


def _leg(cloth: Material, side: float) -> list[Piece]:
    ankle, knee = (later(joint, _behind(side)) for joint in (_ankle, _knee))
    (hip_x, hip_z), (knee_x, knee_z), (x, z), y = _HIP, knee(0.0), ankle(0.0), side * 0.09
    return [
        limb(cloth, (hip_x, y, hip_z), (knee_x, y, knee_z), 0.17, 0.13).on(Bone(fixed(_HIP), knee)),
        limb(cloth, (knee_x, y, knee_z), (x, y, z), 0.12, 0.09).on(Bone(knee, ankle)),
        block(Material.TRIM, (x - 0.07, x + 0.11), (y - 0.05, y + 0.05), (z - 0.05, z + 0.03)).on(carried(ankle)),
    ]


def _behind(side: float) -> float:
    """The right leg (side -1) is half a stride behind the left one, and the left arm behind the right one."""
    return 0.0 if side > 0 else pi


def _ankle(phase: float) -> Place:
    """Back along the ground, the heel rising, and ahead through the air."""
    lifted = max(0.0, -sin(phase))
    return 0.11 * cos(phase) - 0.02, 0.06 - 0.01 * cos(phase) + 0.08 * lifted


def _knee(phase: float) -> Place:
    """Ahead of the line from hip to ankle, most where the foot is in the air."""
    x, z = _ankle(phase)
    bent = 0.04 - 0.015 * cos(phase) + 0.08 * max(0.0, -sin(phase))
    return 0.5 * (_HIP[0] + x) + bent, 0.5 * (_HIP[1] + z)


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
        hand = fixed(_HANDLE) if pushes else later(_hand, _behind(-side))
        (x, z), y = hand(0.0), side * 0.21
        wrist = (0.8 * x, y, 0.2 * shoulder + 0.8 * z)
        arm = [
            limb(Material.CLOTH, (0.0, side * 0.20, shoulder), wrist, 0.10, 0.08),
            limb(Material.SKIN, wrist, (x, y, z), 0.06, 0.07),
        ]
        pieces += arm if pushes else [piece.on(Bone(fixed((0.0, shoulder)), hand)) for piece in arm]
    return pieces


def _hand(phase: float) -> Place:
    return 0.13 * cos(phase), 0.84


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
