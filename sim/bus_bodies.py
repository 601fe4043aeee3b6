"""City buses and coaches: a box with a band of windows, doors on the right, and what stands on its roof."""

from dataclasses import dataclass
from functools import partial

from sim.body_pieces import Builder, Material, Piece, Size, across, around, block, line, loft, pair
from sim.coachwork import PROUD_M, axle, pane


@dataclass(frozen=True)
class BusShape:
    """Heights in metres, doors from the front.

    sill: of the windows. roof_unit_m: height of what stands on the roof. fairing: whether that runs all along.
    doors_m: where each door begins. posts: between the windows. wave: whether the second paint rises to the rear.
    """

    sill: float
    roof_unit_m: float
    fairing: bool
    doors_m: tuple[float, ...]
    posts: int
    wave: bool
    low: float = 0.30


_SHAPES = {
    "diesel": BusShape(1.10, 0.26, fairing=False, doors_m=(0.55, 5.0), posts=5, wave=False),
    "electric": BusShape(1.05, 0.30, fairing=True, doors_m=(0.55, 3.9, 9.15), posts=4, wave=True),
    "coach": BusShape(1.55, 0.14, fairing=False, doors_m=(0.45,), posts=6, wave=True, low=0.34),
}


def bus(shape: BusShape, size: Size) -> list[Piece]:
    """A bus of 11 m or so."""
    length, width, height = size
    end, half = length / 2 - 3 * PROUD_M, width / 2 - 3 * PROUD_M
    top = height - shape.roof_unit_m
    head = top - 0.32
    return [
        _shell(shape, end, half, top, head),
        _livery(shape, end, half, head),
        *_windows(shape, end, half, head),
        *(piece for x in shape.doors_m for piece in _door(end - x, half, shape.low, head)),
        *_front(shape, end, half, top, head),
        *_rear(shape, end, half, head),
        *_roof(shape, end, half, top, height),
        block(Material.TRIM, (end - 0.42, end - 0.28), (-width / 2, width / 2), (head - 0.75, head - 0.20)),
        *axle(end - 2.75, 0.48, shape.low, half),
        *axle(2.55 - end, 0.48, shape.low, half),
    ]


def _shell(shape: BusShape, end: float, half: float, top: float, head: float) -> Piece:
    low = shape.low
    flanks = [(x, z, half) for x in (end - 0.22, 0.10 - end) for z in (low, head)]
    roof = [(x, top, 0.90 * half) for x in (end - 0.35, 0.20 - end)]
    front = [(end - 0.03, low, 0.88 * half), (end, 1.0, 0.89 * half), (end - 0.14, top - 0.08, 0.80 * half)]
    rear = [(-end, low, 0.92 * half), (-end, head, 0.92 * half)]
    return loft(Material.PAINT, [*flanks, *roof, *front, *rear])


def _livery(shape: BusShape, end: float, half: float, head: float) -> Piece:
    """The second paint: a low band all along, or a wave that fills the rear."""
    if shape.wave:
        profile = [(0.12 - end, shape.low), (0.12 - end, head - 0.02), (2.0 - end, head - 0.02), (0.1 * end, shape.low)]
    else:
        profile = [(x, z) for x in (0.12 - end, end - 0.24) for z in (shape.low, shape.sill - 0.28)]
    return across(Material.SECOND_PAINT, profile, lambda _: half, proud=0.5 * PROUD_M)


def _windows(shape: BusShape, end: float, half: float, head: float) -> list[Piece]:
    rear, front = 0.55 - end, end - 0.30
    band = block(Material.GLASS, (rear, front), (-half - PROUD_M, half + PROUD_M), (shape.sill, head - 0.06))
    gap = (front - rear) / (shape.posts + 1)
    side = half + 1.5 * PROUD_M
    posts = [
        block(Material.TRIM, (rear + k * gap - 0.05, rear + k * gap + 0.05), (-side, side), (shape.sill, head - 0.06))
        for k in range(1, shape.posts + 1)
    ]
    return [band, *posts]


def _door(x: float, half: float, low: float, head: float) -> list[Piece]:
    """On the right: a dark frame that begins at ``x``, and glass in it."""
    frame, leaves = -half - 2 * PROUD_M, -half - 2.5 * PROUD_M
    return [
        block(Material.METAL, (x - 1.25, x), (frame, -0.8 * half), (low + 0.02, head)),
        block(Material.GLASS, (x - 1.17, x - 0.08), (leaves, -0.8 * half), (low + 0.14, head - 0.08)),
    ]


def _front(shape: BusShape, end: float, half: float, top: float, head: float) -> list[Piece]:
    face = line((1.0, end), (top - 0.08, end - 0.14))
    low, high = 1.02, top - 0.14
    sign = [(face(z) + back, z, 0.62 * half) for z in (head, head + 0.16) for back in (2 * PROUD_M, -0.1)]
    lamps = pair(Material.HEADLAMP, (end - 0.2, end + PROUD_M), (0.56 * half, 0.84 * half), (0.62, 0.78))
    return [
        pane((face(low), low), (face(high), high), line((low, 0.84 * half), (high, 0.76 * half)), front=True),
        loft(Material.HEADLAMP, sign),
        *lamps,
        around(Material.TRIM, [(end + PROUD_M, 0.88 * half), (end - 0.22, half + 0.5 * PROUD_M)], (shape.low, 0.48)),
    ]


def _rear(shape: BusShape, end: float, half: float, head: float) -> list[Piece]:
    x = (-end - PROUD_M, 0.15 - end)
    return [
        block(Material.GLASS, x, (-0.76 * half, 0.76 * half), (shape.sill + 0.25, head - 0.06)),
        block(Material.TRIM, x, (-0.66 * half, 0.66 * half), (0.50, 1.05)),
        *pair(Material.TAIL_LAMP, x, (0.76 * half, 0.92 * half), (0.62, 1.25)),
    ]


def _roof(shape: BusShape, end: float, half: float, top: float, height: float) -> list[Piece]:
    """Batteries under a fairing, or an air conditioner and hatches."""
    foot = top - 0.05
    if shape.fairing:
        low = [(x, foot, 0.80 * half) for x in (0.5 - end, end - 1.4)]
        return [loft(Material.METAL, [*low, *((x, height, 0.72 * half) for x in (0.7 - end, end - 1.9))])]
    low, high = [(x, foot, 0.62 * half) for x in (-0.5, 2.3)], [(x, height, 0.52 * half) for x in (-0.2, 1.9)]
    hatch = block(Material.METAL, (-0.55 * end, -0.40 * end), (-0.36 * half, 0.36 * half), (foot, top + 0.06))
    return [loft(Material.METAL, [*low, *high]), hatch]


BUSES: dict[str, dict[str, Builder]] = {"city_bus": {name: partial(bus, shape) for name, shape in _SHAPES.items()}}
"""Builders of bodies by kind and name."""
