"""People on foot and on two wheels, strollers with whoever pushes them, and delivery robots, in metres."""

from sim.body_pieces import Material, Piece, ball, block, limb, loft, pair, wheel
from sim.vehicle_bodies import Builder, Size

_HEAD_M, _NECK_M = 0.23, 0.05


def person(size: Size, *, at: float = 0.0, coat: bool = False, bag: bool = False, pushes: bool = False) -> list[Piece]:
    """Somebody in mid-stride, ``at`` metres ahead of the middle. coat: a long one; pushes: with both arms ahead."""
    _, width, height = size
    hip, shoulder = 0.50 * height, height - _HEAD_M - _NECK_M
    reach, side = 0.17 * height / 1.72, width / 2
    legs = [
        limb(Material.TROUSERS, (at, 0.09, hip), (at + reach, 0.09, 0.0), 0.16, 0.11),
        limb(Material.TROUSERS, (at, -0.09, hip), (at - reach, -0.09, 0.0), 0.16, 0.11),
    ]
    torso = loft(
        Material.CLOTH,
        [
            (at - 0.09, hip - 0.05, 0.15),
            (at + 0.09, hip - 0.05, 0.15),
            (at - 0.10, shoulder, 0.19),
            (at + 0.08, shoulder, 0.19),
        ],
    )
    hem = (
        [
            loft(
                Material.CLOTH,
                [
                    (at - 0.19, 0.45 * hip, 0.2),
                    (at + 0.19, 0.45 * hip, 0.2),
                    (at - 0.09, hip, 0.14),
                    (at + 0.09, hip, 0.14),
                ],
            )
        ]
        if coat
        else []
    )
    hand = 0.95 * hip
    swing = (0.38, 0.38) if pushes else (-0.16, 0.16)
    hands_z = (1.05, 1.05) if pushes else (hand, hand)
    arms = [
        limb(
            Material.CLOTH,
            (at - 0.01, s * (side - 0.07), shoulder - 0.04),
            (at + ahead, s * (side - 0.05), z),
            0.11,
            0.09,
        )
        for s, ahead, z in zip((1.0, -1.0), swing, hands_z, strict=True)
    ]
    head = ball(Material.SKIN, (at + 0.02, 0.0, shoulder + _NECK_M + _HEAD_M / 2 - 0.02), (0.10, 0.085, _HEAD_M / 2))
    hair = ball(Material.HAIR, (at - 0.01, 0.0, height - 0.085), (0.115, 0.10, 0.085))
    neck = limb(Material.SKIN, (at, 0.0, shoulder - 0.02), (at, 0.0, shoulder + 0.10), 0.1, 0.1)
    pack = [block(Material.BAG, (at - 0.26, at - 0.09), (-0.15, 0.15), (hip + 0.1, shoulder - 0.03))] if bag else []
    return [*legs, torso, *hem, *arms, neck, head, hair, *pack]


def _rider(
    seat: tuple[float, float], bar: tuple[float, float], pedal_x: float, top: float, *, helmet: bool
) -> list[Piece]:
    """Somebody who sits at ``seat`` (x, z) and holds a bar at (x, z)."""
    shoulder = (0.45 * seat[0] + 0.55 * bar[0] - 0.05, top - _HEAD_M - 0.06)
    torso = limb(Material.CLOTH, (seat[0], 0.0, seat[1] - 0.02), (shoulder[0], 0.0, shoulder[1]), 0.30, 0.34)
    arms = [
        limb(Material.CLOTH, (shoulder[0], s * 0.20, shoulder[1] - 0.05), (bar[0], s * 0.25, bar[1]), 0.10, 0.08)
        for s in (-1.0, 1.0)
    ]
    knees = [(pedal_x + 0.20, s * 0.13, 0.62 * seat[1] + 0.12) for s in (-1.0, 1.0)]
    legs = [limb(Material.TROUSERS, (seat[0], 0.6 * knee[1], seat[1]), knee, 0.17, 0.13) for knee in knees]
    legs += [
        limb(Material.TROUSERS, knee, (pedal_x, knee[1], 0.25 + 0.12 * k), 0.12, 0.10) for k, knee in enumerate(knees)
    ]
    middle = (shoulder[0] + 0.06, 0.0, top - _HEAD_M / 2)
    cap = Material.SECOND_PAINT if helmet else Material.HAIR
    head = ball(Material.SKIN, (middle[0] + 0.02, 0.0, middle[2] - 0.02), (0.10, 0.085, 0.11))
    hat = ball(
        cap,
        (middle[0] - 0.01, 0.0, top - 0.08 * (1.4 if helmet else 1.0)),
        (0.135 if helmet else 0.115, 0.12 if helmet else 0.10, 0.08 * (1.4 if helmet else 1.0)),
    )
    return [torso, *arms, *legs, head, hat]


def bicycle(size: Size, *, upright: bool = True) -> list[Piece]:
    """A bicycle and its rider."""
    length, width, height = size
    radius, axle = 0.33, length / 2 - 0.33
    seat, bar = (-0.22, 0.92), (0.33 if upright else 0.45, 1.02 if upright else 0.90)
    frame = [
        limb(Material.PAINT, (-axle, 0.0, radius), (-0.08, 0.0, 0.30), 0.05, 0.05),
        limb(Material.PAINT, (-0.22, 0.0, 0.88), (-0.08, 0.0, 0.28), 0.05, 0.06),
        limb(Material.PAINT, (-0.08, 0.0, 0.30), (bar[0] + 0.04, 0.0, 0.80), 0.06, 0.06),
        limb(Material.PAINT, (-0.20, 0.0, 0.78), (bar[0] + 0.02, 0.0, 0.84), 0.05, 0.05),
        limb(Material.TRIM, (axle, 0.0, radius), (bar[0], 0.0, bar[1]), 0.05, 0.05),
    ]
    bars = block(Material.TRIM, (bar[0] - 0.03, bar[0] + 0.03), (-width / 2, width / 2), (bar[1] - 0.03, bar[1] + 0.03))
    wheels = [wheel(x, radius, (-0.025, 0.025)) for x in (-axle, axle)]
    saddle = block(Material.TRIM, (seat[0] - 0.14, seat[0] + 0.10), (-0.07, 0.07), (seat[1] - 0.04, seat[1] + 0.02))
    lamp = block(Material.HEADLAMP, (bar[0] + 0.05, bar[0] + 0.11), (-0.04, 0.04), (0.84, 0.92))
    return [*frame, bars, *wheels, saddle, lamp, *_rider(seat, bar, -0.05, height, helmet=not upright)]


def motorcycle(size: Size, *, scooter: bool = False) -> list[Piece]:
    """A motorcycle or a scooter, with its rider."""
    length, width, height = size
    radius = 0.25 if scooter else 0.31
    axle = length / 2 - radius
    seat, bar = (-0.28, 0.78), (0.40, 1.02)
    wheels = [wheel(x, radius, (-0.07, 0.07)) for x in (-axle, axle)]
    tail = loft(
        Material.PAINT,
        [(-axle - 0.05, 0.62, 0.14), (-0.05, 0.50, 0.18), (-axle - 0.1, 0.82, 0.12), (-0.05, 0.78, 0.17)],
    )
    shield = (
        loft(Material.PAINT, [(0.38, 0.25, 0.22), (0.50, 0.25, 0.20), (0.42, 0.95, 0.20), (0.55, 0.90, 0.14)])
        if scooter
        else loft(Material.PAINT, [(-0.1, 0.72, 0.15), (0.42, 0.70, 0.16), (0.0, 0.95, 0.13), (0.34, 0.98, 0.15)])
    )
    engine = block(Material.TRIM, (-0.38, 0.32), (-0.17, 0.17), (0.22, 0.55 if not scooter else 0.32))
    fork = limb(Material.TRIM, (axle, 0.0, radius), (bar[0], 0.0, bar[1]), 0.14, 0.10)
    bars = block(Material.TRIM, (bar[0] - 0.03, bar[0] + 0.04), (-width / 2, width / 2), (bar[1] - 0.03, bar[1] + 0.03))
    lamps = [
        block(Material.HEADLAMP, (bar[0] + 0.10, bar[0] + 0.20), (-0.09, 0.09), (0.80, 0.96)),
        block(Material.TAIL_LAMP, (-axle - 0.12, -axle - 0.05), (-0.10, 0.10), (0.70, 0.80)),
    ]
    box = [block(Material.BAG, (-axle - 0.12, -0.52), (-0.22, 0.22), (0.84, 1.24))] if scooter else []
    return [*wheels, tail, shield, engine, fork, bars, *lamps, *box, *_rider(seat, bar, -0.02, height, helmet=True)]


def stroller(size: Size, *, twin: bool = False) -> list[Piece]:
    """A stroller and whoever pushes it."""
    length, width, height = size
    grown_up = person((0.4, 0.5, height), at=-length / 2 + 0.24, coat=twin, pushes=True)
    front, half = length / 2, width / 2
    seat = loft(
        Material.PAINT,
        [
            (0.02, 0.40, half * 0.75),
            (front - 0.12, 0.42, half * 0.75),
            (-0.10, 0.95, half * 0.7),
            (front - 0.05, 0.62, half * 0.7),
        ],
    )
    hood = loft(
        Material.SECOND_PAINT,
        [(-0.14, 0.75, half * 0.8), (0.30, 0.92, half * 0.8), (-0.02, 1.08, half * 0.75), (0.26, 1.10, half * 0.7)],
    )
    handle = limb(Material.TRIM, (0.0, 0.0, 0.55), (-0.22, 0.0, 1.05), 0.06, 0.10)
    wheels = [
        wheel(x, 0.13, (s * half, s * (half - 0.06)), sides=8) for x in (-0.02, front - 0.13) for s in (-1.0, 1.0)
    ]
    return [*grown_up, seat, hood, handle, *wheels]


def robot(size: Size, *, flag: bool = False) -> list[Piece]:
    """A delivery robot on six wheels."""
    length, width, height = size
    front, half = length / 2, width / 2
    top = height - (0.12 if flag else 0.0)
    body = loft(
        Material.PAINT,
        [
            (-front, 0.18, half * 0.8),
            (front, 0.18, half * 0.8),
            (-front + 0.04, top - 0.08, half * 0.75),
            (front - 0.10, top - 0.08, half * 0.7),
        ],
    )
    lid = loft(
        Material.SECOND_PAINT,
        [
            (-front + 0.06, top - 0.10, half * 0.72),
            (front - 0.13, top - 0.10, half * 0.68),
            (-front + 0.10, top, half * 0.6),
            (front - 0.2, top, half * 0.55),
        ],
    )
    wheels = [wheel(x, 0.11, (s * half, s * (half - 0.08)), sides=8) for x in (-0.22, 0.0, 0.22) for s in (-1.0, 1.0)]
    lamps = pair(Material.HEADLAMP, (front - 0.06, front - 0.008), (0.08, 0.16), (0.30, 0.36))
    lamps.append(block(Material.TAIL_LAMP, (-front, -front + 0.04), (-0.12, 0.12), (0.28, 0.33)))
    mast = [block(Material.TRIM, (-front + 0.06, -front + 0.09), (-0.015, 0.015), (0.3, height))] if flag else []
    return [body, lid, *wheels, *lamps, *mast]


PEOPLE: dict[str, dict[str, Builder]] = {
    "adult": {
        "walker": person,
        "in_coat": lambda size: person(size, coat=True),
        "with_backpack": lambda size: person(size, bag=True),
    },
    "child": {"child": person, "with_satchel": lambda size: person(size, bag=True)},
    "bicycle": {"city_bicycle": bicycle, "racing_bicycle": lambda size: bicycle(size, upright=False)},
    "motorcycle": {"motorcycle": motorcycle, "scooter": lambda size: motorcycle(size, scooter=True)},
    "stroller": {"stroller": stroller, "in_coat": lambda size: stroller(size, twin=True)},
    "robot": {"robot": robot, "with_flag": lambda size: robot(size, flag=True)},
}
