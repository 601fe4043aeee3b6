"""Cars, vans, trucks and buses, in metres, in the proportions of their kinds."""

from collections.abc import Callable
from dataclasses import dataclass

from sim.body_pieces import Material, Piece, block, loft, pair, wheel

Size = tuple[float, float, float]
Builder = Callable[[Size], list[Piece]]
_PROUD = 0.015  # by which glass, lamps and doors stand out of the paint


@dataclass(frozen=True)
class CarShape:
    """The side view of a car, in shares of length and height.

    bonnet, belt: heights of the bonnet's front edge and of the windows' lower edge.
    screen, roof_front, roof_rear, rear: where the windscreen begins, the roof, where it ends, and the rear window,
        from the middle, ahead being positive. tail: height of the rear end.
    wheel_m: radius. ground_m: below the body.
    """

    bonnet: float
    belt: float
    screen: float
    roof_front: float
    roof_rear: float
    rear: float
    tail: float
    wheel_m: float = 0.32
    ground_m: float = 0.20


_CARS: dict[str, dict[str, CarShape]] = {
    "city_car": {
        "hatchback": CarShape(0.50, 0.60, 0.25, 0.06, -0.36, -0.49, 0.60, 0.29),
        "one_box": CarShape(0.47, 0.58, 0.36, 0.14, -0.38, -0.49, 0.58, 0.29),
        "three_door": CarShape(0.49, 0.61, 0.20, 0.02, -0.24, -0.47, 0.62, 0.29),
    },
    "saloon": {
        "saloon": CarShape(0.50, 0.62, 0.20, 0.05, -0.20, -0.36, 0.66, 0.32),
        "estate": CarShape(0.50, 0.62, 0.20, 0.05, -0.42, -0.49, 0.62, 0.32),
        "fastback": CarShape(0.47, 0.60, 0.22, 0.04, -0.12, -0.44, 0.64, 0.33),
        "coupe": CarShape(0.46, 0.60, 0.14, -0.04, -0.18, -0.38, 0.66, 0.33),
    },
    "suv": {
        "suv": CarShape(0.57, 0.64, 0.22, 0.08, -0.38, -0.48, 0.64, 0.37, 0.25),
        "crossover": CarShape(0.55, 0.63, 0.25, 0.08, -0.24, -0.46, 0.66, 0.36, 0.25),
        "off_roader": CarShape(0.60, 0.63, 0.20, 0.15, -0.46, -0.49, 0.63, 0.39, 0.28),
    },
    "minivan": {
        "minivan": CarShape(0.46, 0.55, 0.34, 0.17, -0.42, -0.49, 0.55, 0.34),
        "people_carrier": CarShape(0.50, 0.54, 0.30, 0.18, -0.46, -0.49, 0.54, 0.34),
    },
}


def car(shape: CarShape, size: Size) -> list[Piece]:
    """A passenger car."""
    length, width, height = size
    front, rear, half = length / 2, -length / 2, width / 2 - _PROUD
    belt, bonnet, tail = shape.belt * height, shape.bonnet * height, shape.tail * height
    screen, roof_front, roof_rear, window = (
        share * length for share in (shape.screen, shape.roof_front, shape.roof_rear, shape.rear)
    )
    low, sill, waist = shape.ground_m, half * 0.94, half
    axle = 0.30 * length
    roof = height - 0.06
    body = loft(
        Material.PAINT,
        [
            (front - 0.10, low + 0.02, sill * 0.90),
            (front, low + 0.22, sill * 0.86),
            (front - 0.08, bonnet, sill * 0.84),
            (screen, belt, waist * 0.96),
            (0.0, 0.6 * belt, waist),
            (max(window, rear + 0.05), belt, waist * 0.94),
            (rear + 0.04, tail, sill * 0.86),
            (rear, low + 0.25, sill * 0.90),
            (rear + 0.10, low + 0.02, sill * 0.92),
        ],
    )
    cabin = loft(
        Material.GLASS,
        [
            (screen - 0.02, belt - 0.03, waist * 0.92),
            (max(window, rear + 0.07), belt - 0.03, waist * 0.90),
            (roof_front, roof, waist * 0.74),
            (roof_rear, roof, waist * 0.74),
        ],
    )
    top = loft(
        Material.PAINT,
        [
            (roof_front + 0.06, roof - 0.02, waist * 0.755),
            (roof_rear - 0.06, roof - 0.02, waist * 0.755),
            (roof_front - 0.05, height, waist * 0.66),
            (roof_rear + 0.05, height, waist * 0.66),
        ],
    )
    pillars = [
        loft(
            Material.PAINT,
            [
                (x - 0.05, belt - 0.04, 0.015),
                (x + 0.05, belt - 0.04, 0.015),
                (x - 0.05 + lean, roof, 0.015),
                (x + 0.05 + lean, roof, 0.015),
            ],
            y=side * waist * 0.84,
        )
        for x, lean in ((-0.02 * length, -0.01 * length),)
        for side in (-1.0, 1.0)
    ]
    mirrors = pair(Material.TRIM, (screen - 0.32, screen - 0.18), (half * 0.93, width / 2), (belt - 0.02, belt + 0.10))
    bumpers = [
        block(Material.TRIM, (front - 0.25, front - 0.015), (-sill * 0.8, sill * 0.8), (low, low + 0.16)),
        block(Material.TRIM, (rear + 0.015, rear + 0.25), (-sill * 0.8, sill * 0.8), (low, low + 0.16)),
    ]
    lamp = min(bonnet - 0.14, low + 0.42)
    lamps = pair(Material.HEADLAMP, (front - 0.22, front - 0.02), (sill * 0.52, sill * 0.83), (lamp, lamp + 0.12))
    lamps += pair(
        Material.TAIL_LAMP, (rear + 0.008, rear + 0.2), (sill * 0.60, sill * 0.87), (tail - 0.24, tail - 0.08)
    )
    wheels = _wheels((axle, -axle), shape.wheel_m, width)
    return [body, cabin, top, *pillars, *mirrors, *bumpers, *lamps, *wheels]


def _wheels(axles: tuple[float, ...], radius: float, width: float, tread: float = 0.20) -> list[Piece]:
    outer = width / 2 - 0.04
    return [wheel(x, radius, (side * outer, side * (outer - tread))) for x in axles for side in (-1.0, 1.0)]


def delivery_van(size: Size, *, glazed: bool = False) -> list[Piece]:
    """A van with a short nose: a panel van, or one with windows all along."""
    length, width, height = size
    front, rear, half = length / 2, -length / 2, width / 2 - _PROUD
    nose, belt, cowl, brow = 0.42 * height, 0.50 * height, front - 0.70, front - 1.25
    bonnet = loft(
        Material.PAINT,
        [
            (front - 0.06, 0.30, half * 0.88),
            (front, 0.55, half * 0.90),
            (front - 0.06, nose, half * 0.88),
            (cowl - 0.1, belt, half * 0.96),
            (cowl - 0.3, 0.28, half * 0.98),
        ],
    )
    body = loft(
        Material.PAINT,
        [
            (cowl, 0.28, half * 0.98),
            (cowl, belt, half * 0.97),
            (brow, height, half * 0.84),
            (rear + 0.05, height, half * 0.86),
            (rear, 0.30, half * 0.98),
            (0.0, 0.26, half),
            (0.0, belt, half),
        ],
    )
    screen = loft(Material.GLASS, [(x, z, half * share) for x, z, share in _on_slope((cowl, belt), (brow, height))])
    doors = pair(Material.GLASS, (brow - 0.85, brow - 0.02), (half * 0.88, half * 0.975), (belt, height - 0.42))
    trim = [block(Material.TRIM, (rear + 0.01, front - 0.05), (-half * 0.95, half * 0.95), (0.22, 0.36))]
    mirrors = pair(Material.TRIM, (cowl - 0.30, cowl - 0.15), (half * 0.95, width / 2), (belt, belt + 0.25))
    lamps = pair(Material.HEADLAMP, (front - 0.3, front - 0.015), (half * 0.6, half * 0.84), (nose - 0.28, nose - 0.10))
    lamps += pair(Material.TAIL_LAMP, (rear + 0.0, rear + 0.1), (half * 0.82, half * 0.95), (0.6, 1.1))
    if glazed:
        doors += pair(Material.GLASS, (rear + 0.3, brow - 1.0), (half * 0.88, half * 0.975), (belt, height - 0.42))
        doors.append(block(Material.GLASS, (rear + 0.01, rear + 0.2), (-half * 0.7, half * 0.7), (belt, height - 0.42)))
    wheels = _wheels((0.31 * length, -0.30 * length), 0.34, width)
    return [bonnet, body, screen, *doors, *trim, *mirrors, *lamps, *wheels]


def _on_slope(low: tuple[float, float], high: tuple[float, float]) -> list[tuple[float, float, float]]:
    """A windscreen on a slope between two points (x, z): its sections (x, z, share of the half width)."""
    (x0, z0), (x1, z1) = low, high
    rise = [(0.06, 0.93), (0.86, 0.84)]
    return [
        (x0 + at * (x1 - x0) + ahead, z0 + at * (z1 - z0) + 0.5 * ahead, share)
        for at, share in rise
        for ahead in (0.02, -0.10)
    ]


def truck(size: Size, *, load: str, axles: tuple[float, ...], cab_m: float) -> list[Piece]:
    """A truck with its cab over the engine. load: ``box``, ``tarpaulin``, ``tipper`` or ``flatbed``."""
    length, width, height = size
    front, rear, half = length / 2, -length / 2, width / 2 - _PROUD
    back, roof = front - cab_m, 0.80 * height if load in ("box", "tarpaulin") else height
    cab = loft(
        Material.PAINT,
        [
            (front, 0.45, half * 0.94),
            (front, 0.50 * roof, half * 0.96),
            (front - 0.22, roof, half * 0.84),
            (back + 0.12, roof, half * 0.84),
            (back, 0.55 * roof, half * 0.96),
            (back, 0.45, half * 0.96),
        ],
    )
    windscreen = loft(
        Material.GLASS,
        [
            (front + 0.0, 0.53 * roof, half * 0.86),
            (front - 0.12, 0.50 * roof, half * 0.86),
            (front - 0.155, 0.86 * roof, half * 0.80),
            (front - 0.27, 0.86 * roof, half * 0.80),
        ],
    )
    windows = pair(Material.GLASS, (back + 0.35, front - 0.32), (half * 0.80, half * 0.965), (0.55 * roof, 0.84 * roof))
    chassis = block(Material.TRIM, (rear, back + 0.3), (-0.45, 0.45), (0.55, 0.90))
    skirt = block(Material.TRIM, (front - 0.3, front - 0.01), (-half * 0.9, half * 0.9), (0.30, 0.60))
    mirrors = pair(Material.TRIM, (front - 0.25, front - 0.10), (half * 0.97, width / 2), (0.55 * roof, 0.78 * roof))
    lamps = pair(Material.HEADLAMP, (front - 0.1, front + 0.0), (half * 0.62, half * 0.88), (0.62, 0.80))
    lamps += pair(Material.TAIL_LAMP, (rear, rear + 0.08), (half * 0.70, half * 0.92), (0.62, 0.80))
    wheels = _wheels(tuple(share * length for share in axles), 0.40 if length < 7 else 0.48, width, 0.30)
    return [
        cab,
        windscreen,
        windows[0],
        windows[1],
        chassis,
        skirt,
        *mirrors,
        *lamps,
        *wheels,
        *_load(load, size, back - 0.12),
    ]


def _load(load: str, size: Size, front: float) -> list[Piece]:
    length, width, height = size
    rear, half, bed = -length / 2, width / 2, 1.0
    if load == "box":
        return [
            block(Material.SECOND_PAINT, (rear, front), (-half, half), (bed, height)),
            block(Material.TRIM, (rear, front), (-half * 0.98, half * 0.98), (bed - 0.12, bed)),
        ]
    if load == "tarpaulin":
        ridge = [(x, height, 0.6 * half) for x in (rear, front)]
        sides = [(x, z, half) for x in (rear, front) for z in (bed + 0.35, height - 0.18)]
        return [
            loft(Material.SECOND_PAINT, [*sides, *ridge]),
            block(Material.TRIM, (rear, front), (-half, half), (bed - 0.12, bed + 0.35)),
        ]
    walls = [
        *pair(
            Material.SECOND_PAINT, (rear, front), (half - 0.06, half), (bed, bed + (0.9 if load == "tipper" else 0.4))
        ),
        block(
            Material.SECOND_PAINT, (rear, rear + 0.06), (-half, half), (bed, bed + (0.8 if load == "tipper" else 0.4))
        ),
        block(Material.SECOND_PAINT, (front - 0.06, front), (-half, half), (bed, bed + 1.0)),
        block(Material.TRIM, (rear, front), (-half * 0.98, half * 0.98), (bed - 0.1, bed + 0.05)),
    ]
    if load == "tipper":
        heap = [
            (rear + 0.2, bed + 0.5, half * 0.9),
            (front - 0.2, bed + 0.5, half * 0.9),
            (0.4 * (rear + front), bed + 1.15, half * 0.4),
        ]
        walls.append(loft(Material.BAG, heap))
    else:
        walls.append(
            block(Material.BAG, (rear + 0.4, rear + 0.55 * (front - rear)), (-half * 0.7, half * 0.7), (bed, bed + 0.7))
        )
    return walls


def bus(size: Size, *, articulated_look: bool = False) -> list[Piece]:
    """A low-floor city bus; one livery has a second colour below, the other on its roof."""
    length, width, height = size
    front, rear, half = length / 2, -length / 2, width / 2
    inner = half - _PROUD
    low, sill, head = 0.32, 1.15, height - 0.62
    shell = loft(
        Material.PAINT,
        [
            (front - 0.04, low, inner * 0.97),
            (front, sill, inner * 0.97),
            (front - 0.14, height - 0.28, inner * 0.93),
            (rear, low, inner),
            (rear, height - 0.28, inner * 0.95),
            (0.0, sill, inner),
            (0.0, head, inner),
        ],
    )
    band = pair(Material.GLASS, (rear + 0.5, front - 0.25), (inner * 0.9, half - 0.004), (sill, head))
    posts = [
        piece
        for k in range(1, 6)
        for piece in pair(
            Material.TRIM, (rear + 0.5 + k * 1.65, rear + 0.62 + k * 1.65), (inner * 0.9, half), (sill, head)
        )
    ]
    doors = [
        block(Material.TRIM, (x, x + 1.2), (-half, -inner * 0.9), (low + 0.05, head + 0.1)) for x in (front - 1.9, -0.6)
    ]
    windscreen = loft(
        Material.GLASS,
        [
            (front - 0.01, sill - 0.1, inner * 0.9),
            (front - 0.3, sill - 0.1, inner * 0.9),
            (front - 0.09, head + 0.2, inner * 0.88),
            (front - 0.4, head + 0.2, inner * 0.88),
        ],
    )
    sign = block(Material.HEADLAMP, (front - 0.3, front - 0.10), (-0.7, 0.7), (head + 0.22, head + 0.40))
    back = block(Material.GLASS, (rear - 0.0, rear + 0.1), (-inner * 0.8, inner * 0.8), (sill + 0.2, head))
    skirt = pair(Material.SECOND_PAINT, (rear + 0.02, front - 0.10), (inner * 0.9, half - 0.006), (low, sill - 0.25))
    roof = [
        block(Material.SECOND_PAINT, (rear + 0.6, 0.1 * length), (-inner * 0.7, inner * 0.7), (height - 0.3, height)),
        block(
            Material.SECOND_PAINT,
            (0.2 * length, 0.36 * length),
            (-inner * 0.6, inner * 0.6),
            (height - 0.3, height - 0.06),
        ),
    ]
    lamps = pair(Material.HEADLAMP, (front - 0.15, front - 0.008), (inner * 0.65, inner * 0.9), (0.55, 0.75))
    lamps += pair(Material.TAIL_LAMP, (rear, rear + 0.08), (inner * 0.80, inner * 0.95), (0.7, 1.1))
    fit = [*skirt, *roof] if not articulated_look else roof
    return [
        shell,
        *band,
        *posts,
        *doors,
        windscreen,
        sign,
        back,
        *fit,
        *lamps,
        *_wheels((0.27 * length, -0.22 * length), 0.48, width, 0.30),
    ]


def _car_builder(shape: CarShape) -> Builder:
    return lambda size: car(shape, size)


VEHICLES: dict[str, dict[str, Builder]] = {
    **{kind: {name: _car_builder(shape) for name, shape in shapes.items()} for kind, shapes in _CARS.items()},
    "delivery_van": {
        "panel_van": delivery_van,
        "glazed_van": lambda size: delivery_van(size, glazed=True),
    },
    "light_truck": {
        "box": lambda size: truck(size, load="box", axles=(0.33, -0.28), cab_m=1.75),
        "flatbed": lambda size: truck(size, load="flatbed", axles=(0.33, -0.28), cab_m=1.75),
        "tarpaulin": lambda size: truck(size, load="tarpaulin", axles=(0.33, -0.28), cab_m=1.75),
    },
    "lorry": {
        "box": lambda size: truck(size, load="box", axles=(0.35, -0.20, -0.35), cab_m=2.1),
        "tipper": lambda size: truck(size, load="tipper", axles=(0.35, -0.20, -0.35), cab_m=2.1),
        "tarpaulin": lambda size: truck(size, load="tarpaulin", axles=(0.35, -0.26), cab_m=2.1),
    },
    "city_bus": {"two_tone": bus, "plain": lambda size: bus(size, articulated_look=True)},
}
