"""Vans and trucks: vans in one volume with a short nose, trucks with their cab over the engine and a load behind it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

from sim.body_pieces import Builder, Line, Material, Piece, Size, across, around, block, line, loft, pair
from sim.coachwork import PROUD_M, Coachwork, axle, open_axle, pane, wrapped

_BED_M = 1.0  # height of a truck's loading floor
Load = Callable[[Size, float], list[Piece]]  # of a size, ahead to some x


@dataclass(frozen=True)
class _VanLines(Coachwork):
    """A van's lines in metres; half widths are functions of z, points are (x, z)."""

    low: float = 0.28
    waist: float = 0.80

    @cached_property
    def flank(self) -> Line:
        """Half the width above the waist."""
        return line((self.waist, self.half), (self.size[2], 0.86 * self.half))

    @cached_property
    def face(self) -> Line:
        """The front of the nose: x by z."""
        return line((0.62, self.end), (0.98, self.end - 0.08))

    @cached_property
    def cowl(self) -> tuple[float, float]:
        """The foot of the windscreen."""
        return self.end - 0.85, 0.50 * self.size[2]

    @cached_property
    def brow(self) -> tuple[float, float]:
        """The top of the windscreen's slope."""
        return self.end - 1.60, self.size[2] - 0.06

    @cached_property
    def top(self) -> float:
        """Height of the windows' upper edge."""
        return self.size[2] - 0.42

    @cached_property
    def post(self) -> float:
        """Where the front doors' windows end."""
        return self.brow[0] - 0.55


def van(size: Size, *, glazed: bool = False, liveried: bool = False) -> list[Piece]:
    """A panel van. glazed: with windows all along; liveried: with a second colour on its flanks."""
    lines = _VanLines(size)
    x, z = lines.cowl
    pieces = [
        _van_hold(lines),
        _van_nose(lines),
        *_van_glass(lines),
        *_van_lamps(lines),
        block(Material.TRIM, (x - 0.42, x - 0.28), (-size[1] / 2, size[1] / 2), (z, z + 0.26)),
        _van_skirt(lines),
        *axle(0.31 * size[0], 0.34, lines.low, lines.half),
        *axle(-0.29 * size[0], 0.34, lines.low, lines.half),
    ]
    if glazed:
        pieces.append(
            _on_flank(Material.GLASS, (0.25 - lines.end, lines.post - 0.10), (z - 0.06, lines.top), lines.flank)
        )
    if liveried:
        pieces.append(
            _on_flank(Material.SECOND_PAINT, (0.35 - lines.end, lines.post - 0.25), (1.05, 1.75), lines.flank)
        )
    return pieces


def _less(half: Line, by: float) -> Line:
    return lambda z: half(z) - by


def _on_flank(material: Material, x: tuple[float, float], z: tuple[float, float], flank: Line) -> Piece:
    return across(material, [(along, height) for along in x for height in z], flank, proud=PROUD_M)


def _van_hold(lines: _VanLines) -> Piece:
    height, rear = lines.size[2], -lines.end
    below = [(x, z, lines.half) for x in (lines.cowl[0], rear) for z in (lines.low, lines.waist)]
    above = [(x, z, lines.flank(z)) for x, z in (lines.cowl, lines.brow, (rear + 0.03, height - 0.10))]
    roof = [(x, height, 0.9 * lines.flank(height)) for x in (lines.brow[0] - 0.25, rear + 0.10)]
    return loft(Material.PAINT, [*below, *above, *roof])


def _van_nose(lines: _VanLines) -> Piece:
    low, half = lines.low, lines.half
    front = [(lines.end - 0.04, low, 0.74 * half), *((lines.face(z), z, 0.75 * half) for z in (0.62, 0.98))]
    corner, foot = lines.end - 0.28, lines.cowl[0] - 0.10
    sides = [(x, z, half) for x in (corner, foot) for z in (low, lines.waist)]
    return loft(Material.PAINT, [*front, *sides, (corner, 1.05, lines.flank(1.05)), (*lines.cowl, 0.96 * half)])


def _van_glass(lines: _VanLines) -> list[Piece]:
    """The windscreen, the front doors' windows, and two in the rear doors."""
    (x, z), top, post, half = lines.cowl, lines.top, lines.post, lines.half
    slope = line(lines.cowl[::-1], lines.brow[::-1])
    low, high = z + 0.03, top + 0.14
    door = [(x - 0.18, z), (slope(top) - 0.10, top), (post, top), (post, z - 0.06)]
    rear = -lines.end
    return [
        pane((slope(low), low), (slope(high), high), _less(lines.flank, 0.10), front=True),
        across(Material.GLASS, door, lines.flank, proud=PROUD_M),
        block(Material.GLASS, (rear - PROUD_M, rear + 0.2), (-0.70 * half, 0.70 * half), (z + 0.08, top)),
        block(Material.PAINT, (rear - 2 * PROUD_M, rear + 0.2), (-0.05, 0.05), (z, top + 0.05)),
    ]


def _van_lamps(lines: _VanLines) -> list[Piece]:
    """Headlamps around the front, the grille in their middle; upright tail lamps on the rear corners."""
    half, rear = lines.half, -lines.end
    face, corner = _less(lines.face, -PROUD_M), _less(lines.face, 0.10)
    grille = [(face(z) + ahead, z, 0.46 * half) for z in (0.45, 0.92) for ahead in (PROUD_M, -0.3)]
    return [
        wrapped(Material.HEADLAMP, (face, 0.74 * half), (corner, 0.92 * half), (0.72, 0.92), -0.2),
        loft(Material.TRIM, grille),
        *pair(Material.TAIL_LAMP, (rear - PROUD_M, rear + 0.07), (0.86 * half, half + PROUD_M), (0.72, 1.20)),
    ]


def _van_skirt(lines: _VanLines) -> Piece:
    half = lines.half + 0.5 * PROUD_M
    plan = [(lines.end, 0.75 * half), (lines.end - 0.28, half), (-lines.end - 0.5 * PROUD_M, half)]
    return around(Material.TRIM, plan, (lines.low - 0.05, lines.low + 0.14))


def truck(size: Size, *, load: Load, cab_m: float, rear_axles: tuple[float, ...], deflector: bool) -> list[Piece]:
    """A truck with its cab over the engine. deflector: whether the cab is lower than its load and leads the air."""
    length, width, height = size
    end, half = length / 2 - 2 * PROUD_M, width / 2 - 0.03
    back, roof = end - cab_m, (0.80 if deflector else 0.88) * height
    radius = 0.40 if length < 7.0 else 0.48
    return [
        *_cab(end, back, half, roof),
        block(Material.TRIM, (end - 0.34, end - 0.22), (-width / 2, width / 2), (0.56 * roof, 0.80 * roof)),
        *([_deflector(end, back, half, roof, height)] if deflector else []),
        *_chassis(end, back, half, length),
        *axle(end - 0.52 * cab_m - 0.15, radius, 0.42, half),
        *(piece for x in rear_axles for piece in open_axle(x * length, radius, half, 0.42)),
        *load(size, back - 0.10),
    ]


def _cab(end: float, back: float, half: float, roof: float) -> list[Piece]:
    low, belt, top = 0.42, 0.50 * roof, roof - 0.24
    flank = line((belt, half), (roof, 0.90 * half))
    face = line((belt, end), (roof, end - 0.26))
    front = [(end - 0.03, low, 0.88 * half), (end, belt, 0.88 * half), (face(roof), roof, 0.80 * half)]
    sides = [(x, z) for x in (end - 0.16, back) for z in (low, belt)] + [(end - 0.42, roof), (back, roof)]
    shell = loft(Material.PAINT, [*front, *((x, z, min(half, flank(z))) for x, z in sides)])
    windows = [(end - 0.24, belt + 0.04), (end - 0.44, top), (back + 0.28, top), (back + 0.28, belt + 0.04)]
    return [
        shell,
        pane((face(belt + 0.02), belt + 0.02), (face(top), top), _less(flank, 0.14 * half), front=True),
        across(Material.GLASS, windows, flank, proud=PROUD_M),
        block(Material.HEADLAMP, (end - 0.2, end + PROUD_M), (-0.86 * half, 0.86 * half), (0.64, 0.78)),
        block(Material.TRIM, (end - 0.2, end + 2 * PROUD_M), (-0.52 * half, 0.52 * half), (0.62, belt - 0.14)),
        around(Material.TRIM, [(end + PROUD_M, 0.86 * half), (end - 0.3, 0.99 * half)], (0.30, 0.60)),
    ]


def _deflector(end: float, back: float, half: float, roof: float, height: float) -> Piece:
    foot = [(x, roof - 0.02, share * half) for x, share in ((end - 0.55, 0.55), (back, 0.72))]
    return loft(Material.PAINT, [*foot, (back + 0.20, height - 0.08, 0.66 * half), (back, height - 0.08, 0.70 * half)])


def _chassis(end: float, back: float, half: float, length: float) -> list[Piece]:
    """Frame, tanks between the axles, and the tail's lamps left and right of its number plate."""
    return [
        block(Material.TRIM, (0.1 - end, back + 0.3), (-0.45, 0.45), (0.52, 0.88)),
        block(Material.METAL, (-0.10 * length, back - 0.50), (-0.90 * half, 0.90 * half), (0.42, 0.86)),
        block(Material.TAIL_LAMP, (-end - PROUD_M, 0.1 - end), (-0.88 * half, 0.88 * half), (0.68, 0.82)),
        block(Material.TRIM, (-end - 2 * PROUD_M, 0.1 - end), (-0.55 * half, 0.55 * half), (0.62, 0.86)),
    ]


def _floor(size: Size, ahead: float) -> Piece:
    half = size[1] / 2 - 0.02
    return block(Material.TRIM, (-size[0] / 2 + 0.02, ahead), (-half, half), (_BED_M - 0.14, _BED_M + 0.06))


def box(size: Size, ahead: float) -> list[Piece]:
    """A closed body."""
    length, width, height = size
    walls = block(Material.SECOND_PAINT, (-length / 2, ahead), (-width / 2, width / 2), (_BED_M, height))
    return [walls, _floor(size, ahead)]


def container(size: Size, ahead: float) -> list[Piece]:
    """A ribbed steel container."""
    length, width, height = size
    rear, half, ribs, deep = -length / 2, width / 2, 5, 0.02
    along, inner = (rear + deep, ahead - deep), half - deep
    walls = block(Material.SECOND_PAINT, along, (-inner, inner), (_BED_M, height - deep))
    step = (ahead - rear - 0.12) / (ribs - 1)
    starts = [rear + k * step for k in range(ribs)]
    frame = [block(Material.SECOND_PAINT, (x, x + 0.12), (-half, half), (_BED_M, height)) for x in starts]
    return [walls, *frame, _floor(size, ahead)]


def tarpaulin(size: Size, ahead: float) -> list[Piece]:
    """A tarpaulin over a frame: a low gable, and side boards below."""
    length, width, height = size
    rear, half = -length / 2, width / 2
    edges = [(x, z, half - 0.01) for x in (rear, ahead) for z in (_BED_M + 0.3, height - 0.16)]
    cover = loft(Material.SECOND_PAINT, [*edges, *((x, height, 0.55 * half) for x in (rear, ahead))])
    boards = block(Material.METAL, (rear + 0.01, ahead + 0.01), (-half, half), (_BED_M, _BED_M + 0.45))
    return [cover, boards, _floor(size, ahead)]


def tipper(size: Size, ahead: float) -> list[Piece]:
    """A tipper with a heap of sand, whose front board reaches above the cab."""
    length, width, height = size
    rear, half, rim = -length / 2, width / 2, _BED_M + 1.0
    heap = [(rear + 0.05, rim - 0.35, half - 0.05), (ahead - 0.05, rim - 0.20, half - 0.05)]
    ridge = [(x, rim + 0.45, 0.25 * half) for x in (0.35 * rear + 0.65 * ahead, 0.6 * rear + 0.4 * ahead)]
    return [
        *pair(Material.SECOND_PAINT, (rear + 0.02, ahead), (half - 0.06, half), (_BED_M, rim)),
        block(Material.SECOND_PAINT, (rear, rear + 0.06), (-half, half), (_BED_M, rim)),
        block(Material.SECOND_PAINT, (ahead - 0.06, ahead), (0.01 - half, half - 0.01), (_BED_M, height)),
        block(Material.SECOND_PAINT, (ahead - 0.06, ahead + 0.9), (-0.8 * half, 0.8 * half), (height - 0.08, height)),
        loft(Material.CARGO, [*heap, *ridge]),
        _floor(size, ahead),
    ]


def flatbed(size: Size, ahead: float) -> list[Piece]:
    """Drop sides, a rack behind the cab, and crates."""
    length, width, height = size
    rear, half, rim = -length / 2, width / 2, _BED_M + 0.38
    span = ahead - rear
    return [
        *pair(Material.SECOND_PAINT, (rear + 0.02, ahead), (half - 0.05, half), (_BED_M, rim)),
        block(Material.SECOND_PAINT, (rear, rear + 0.05), (-half, half), (_BED_M, rim)),
        block(Material.METAL, (ahead - 0.06, ahead), (0.02 - half, half - 0.02), (_BED_M, height)),
        block(Material.CARGO, (rear + 0.3, rear + 0.42 * span), (-0.75 * half, 0.3 * half), (_BED_M, _BED_M + 0.75)),
        block(Material.CARGO, (rear + 0.5 * span, ahead - 0.3), (-0.6 * half, 0.75 * half), (_BED_M, _BED_M + 0.55)),
        _floor(size, ahead),
    ]


def _truck(load: Load, *, cab_m: float, rear_axles: tuple[float, ...], deflector: bool = False) -> Builder:
    return partial(truck, load=load, cab_m=cab_m, rear_axles=rear_axles, deflector=deflector)


TRUCKS: dict[str, dict[str, Builder]] = {
    "delivery_van": {
        "panel_van": van,
        "liveried_van": partial(van, liveried=True),
        "glazed_van": partial(van, glazed=True),
    },
    "light_truck": {
        "box": _truck(box, cab_m=1.65, rear_axles=(-0.27,), deflector=True),
        "flatbed": _truck(flatbed, cab_m=1.65, rear_axles=(-0.27,)),
        "tarpaulin": _truck(tarpaulin, cab_m=1.65, rear_axles=(-0.27,), deflector=True),
    },
    "lorry": {
        "box": _truck(box, cab_m=2.0, rear_axles=(-0.28,), deflector=True),
        "container": _truck(container, cab_m=2.0, rear_axles=(-0.20, -0.35), deflector=True),
        "tarpaulin": _truck(tarpaulin, cab_m=2.0, rear_axles=(-0.28,), deflector=True),
        "tipper": _truck(tipper, cab_m=2.0, rear_axles=(-0.20, -0.35)),
    },
}
"""Builders of bodies by kind and name."""
