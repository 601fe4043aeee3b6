"""Cars and minivans: one set of lines, many shapes."""

from dataclasses import dataclass
from functools import cached_property, partial

from sim.body_pieces import Builder, Line, Material, Piece, Size, across, around, block, line, loft
from sim.coachwork import PROUD_M, Coachwork, axle, pane, wrapped

_PILLAR_M = 0.07


@dataclass(frozen=True)
class CarShape:
    """The side view of a car, in shares of its height and length.

    nose, belt, tail: heights of the bonnet's front edge, of the flanks below the windscreen, and of the rear end.
    cowl, roof_front, roof_rear, rear: where the windscreen begins, the roof, where it ends, and the foot of the rear
        window; from the middle, ahead being positive.
    middle: where the pillar between the doors stands. quarter: width of the pillar behind the side windows.
    axle: where the wheels are, from the middle.
    light_bar: whether the tail lamps are one band.
    """

    nose: float
    belt: float
    tail: float
    cowl: float
    roof_front: float
    roof_rear: float
    rear: float
    middle: float = -0.03
    quarter: float = 0.03
    axle: float = 0.30
    wheel_m: float = 0.32
    ground_m: float = 0.17
    light_bar: bool = False


_SHAPES: dict[str, dict[str, CarShape]] = {
    "city_car": {
        "hatchback": CarShape(0.49, 0.59, 0.63, 0.24, 0.06, -0.37, -0.47, -0.06, axle=0.33, wheel_m=0.29),
        "one_box": CarShape(0.47, 0.57, 0.60, 0.34, 0.13, -0.40, -0.48, 0.0, axle=0.34, wheel_m=0.29, light_bar=True),
        "three_door": CarShape(0.50, 0.60, 0.64, 0.19, 0.01, -0.26, -0.46, -0.14, 0.06, axle=0.32, wheel_m=0.30),
    },
    "saloon": {
        "saloon": CarShape(0.49, 0.60, 0.66, 0.19, 0.04, -0.19, -0.34, -0.05),
        "estate": CarShape(0.49, 0.60, 0.64, 0.19, 0.05, -0.41, -0.47, -0.05),
        "fastback": CarShape(0.46, 0.59, 0.66, 0.21, 0.04, -0.13, -0.41, -0.05, wheel_m=0.33, light_bar=True),
        "coupe": CarShape(0.46, 0.59, 0.66, 0.13, -0.04, -0.17, -0.36, -0.15, 0.05, wheel_m=0.33),
    },
    "suv": {
        "suv": CarShape(0.56, 0.62, 0.64, 0.21, 0.07, -0.38, -0.47, -0.05, wheel_m=0.36, ground_m=0.22),
        "crossover": CarShape(
            0.54, 0.62, 0.66, 0.23, 0.07, -0.24, -0.45, -0.05, wheel_m=0.36, ground_m=0.22, light_bar=True
        ),
        "off_roader": CarShape(0.59, 0.62, 0.63, 0.20, 0.14, -0.455, -0.475, 0.0, wheel_m=0.39, ground_m=0.26),
    },
    "minivan": {
        "minivan": CarShape(0.45, 0.53, 0.56, 0.33, 0.15, -0.42, -0.48, 0.03, wheel_m=0.34, ground_m=0.18),
        "people_carrier": CarShape(
            0.49, 0.53, 0.55, 0.29, 0.17, -0.455, -0.48, 0.05, wheel_m=0.34, ground_m=0.20, light_bar=True
        ),
    },
}


@dataclass(frozen=True)
class _Lines(Coachwork):
    """A shape's lines in metres. Heights of points on them are functions of x; half widths and ends those of z."""

    shape: CarShape

    @cached_property
    def waist(self) -> float:
        """The height at which the flanks stand out most."""
        return 0.41 * self.size[2]

    @cached_property
    def corner_front(self) -> float:
        """Where the flanks begin to turn into the front."""
        return self.end - 0.30

    @cached_property
    def corner_rear(self) -> float:
        """Where the flanks begin to turn into the rear."""
        return 0.22 - self.end

    @cached_property
    def cowl(self) -> tuple[float, float]:
        """The foot of the windscreen (x, z)."""
        return self.shape.cowl * self.size[0], self.shape.belt * self.size[2]

    @cached_property
    def brow(self) -> tuple[float, float]:
        """The top of the windscreen (x, z)."""
        return self.shape.roof_front * self.size[0], self.size[2] - 0.04

    @cached_property
    def hatch(self) -> tuple[float, float]:
        """The top of the rear window (x, z)."""
        return self.shape.roof_rear * self.size[0], self.size[2] - 0.05

    @cached_property
    def deck(self) -> tuple[float, float]:
        """The foot of the rear window (x, z)."""
        x = self.shape.rear * self.size[0]
        return x, self.shoulder(x)

    @cached_property
    def nose(self) -> tuple[float, float]:
        """The bonnet's front edge (x, z)."""
        return self.end - 0.08, self.shape.nose * self.size[2]

    @cached_property
    def tail(self) -> tuple[float, float]:
        """The upper edge of the rear end (x, z)."""
        return 0.05 - self.end, self.shape.tail * self.size[2]

    @cached_property
    def bonnet(self) -> Line:
        """Height of the flanks beside the bonnet."""
        return line(self.nose, self.cowl)

    @cached_property
    def shoulder(self) -> Line:
        """Height of the flanks below the windows."""
        return line(self.cowl, (self.corner_rear, self.tail[1]))

    @cached_property
    def face(self) -> Line:
        """The front above the waist."""
        return line((self.waist, self.end), (self.nose[1], self.nose[0]))

    @cached_property
    def back(self) -> Line:
        """The rear above the waist."""
        return line((self.waist, -self.end), (self.tail[1], self.tail[0]))

    @cached_property
    def screen(self) -> Line:
        """The windscreen."""
        return line(self.cowl[::-1], self.brow[::-1])

    @cached_property
    def window(self) -> Line:
        """The rear window."""
        return line(self.deck[::-1], self.hatch[::-1])

    @cached_property
    def cabin(self) -> Line:
        """Half the cabin's width."""
        return line((self.cowl[1], 0.87 * self.half), (self.size[2], 0.66 * self.half))

    def flank(self, z: float) -> float:
        """Half the body's width."""
        if z < self.waist:
            return line((self.shape.ground_m, 0.95 * self.half), (self.waist, self.half))(z)
        return line((self.waist, self.half), (self.cowl[1], 0.93 * self.half))(z)


def car(shape: CarShape, size: Size) -> list[Piece]:
    """A passenger car."""
    lines = _Lines(size, shape)
    return [
        _body(lines),
        _cabin(lines),
        *_windows(lines),
        *_front(lines),
        *_rear(lines),
        _mirrors(lines),
        _skirt(lines),
        *axle(shape.axle * size[0], shape.wheel_m, shape.ground_m, lines.half),
        *axle(-shape.axle * size[0], shape.wheel_m, shape.ground_m, lines.half),
    ]


def _body(lines: _Lines) -> Piece:
    low, waist = lines.shape.ground_m, lines.waist
    flanks = [
        *((x, z) for x in (lines.corner_front, lines.corner_rear) for z in (low, waist)),
        (lines.corner_front, lines.bonnet(lines.corner_front)),
        lines.cowl,
        (lines.corner_rear, lines.tail[1]),
    ]
    ends = [
        (lines.end - 0.05, low, 0.70),
        (lines.end, waist, 0.72),
        (*lines.nose, 0.68),
        (0.04 - lines.end, low, 0.82),
        (-lines.end, waist, 0.84),
        (*lines.tail, 0.82),
    ]
    sections = [(x, z, share * lines.flank(z)) for x, z, share in ends]
    return loft(Material.PAINT, [*sections, *((x, z, lines.flank(z)) for x, z in flanks)])


def _cabin(lines: _Lines) -> Piece:
    """Crowned: the roof is highest in its middle."""
    crown = (0.5 * (lines.brow[0] + lines.hatch[0]), lines.size[2])
    feet = [(x, z - 0.03) for x, z in (lines.cowl, lines.deck)]
    return across(Material.PAINT, [*feet, lines.brow, crown, lines.hatch], lines.cabin)


def _windows(lines: _Lines) -> list[Piece]:
    """The windscreen, the rear window, and two on each side; between them the paint of the pillars shows."""

    def glass(slope: Line, low: float, high: float, *, front: bool) -> Piece:
        return pane((slope(low), low), (slope(high), high), lambda z: lines.cabin(z) - _PILLAR_M, front=front)

    return [
        glass(lines.screen, lines.cowl[1] + 0.03, lines.brow[1] - 0.04, front=True),
        glass(lines.window, lines.deck[1] + 0.05, lines.hatch[1] - 0.05, front=False),
        *_side_windows(lines),
    ]


def _side_windows(lines: _Lines) -> list[Piece]:
    """Each through both sides."""
    length, height = lines.size[0], lines.size[2]
    top, middle = height - 0.13, lines.shape.middle * length
    first = min(lines.screen(lines.cowl[1] + 0.04) - _PILLAR_M, lines.cowl[0] - 0.05)
    last = lines.window(lines.deck[1] + 0.04) + lines.shape.quarter * length
    ahead, behind = lines.screen(top) - _PILLAR_M, lines.window(top) + lines.shape.quarter * length
    panes = ((first, ahead, middle + 0.5 * _PILLAR_M), (last, behind, middle - 0.5 * _PILLAR_M))
    return [
        across(
            Material.GLASS,
            [(foot, lines.shoulder(foot) + 0.035), (head, top), (post, top), (post, lines.shoulder(post) + 0.035)],
            lines.cabin,
            proud=PROUD_M,
        )
        for foot, head, post in panes
    ]


def _front(lines: _Lines) -> list[Piece]:
    """Headlamps: one band around the front, in the middle of which the grille stands."""
    bottom, top = lines.waist + 0.01, lines.nose[1] - 0.02
    half = lines.flank(bottom)

    def face(z: float) -> float:
        return lines.face(z) + PROUD_M

    def corner(z: float) -> float:
        return lines.face(z) - 0.12

    lamps = wrapped(Material.HEADLAMP, (face, 0.66 * half), (corner, 0.88 * half), (bottom, top), -0.1)
    grille = [(face(z) + PROUD_M + back, z, 0.40 * half) for z in (bottom - 0.14, top) for back in (0.0, -0.2)]
    return [lamps, loft(Material.TRIM, grille)]


def _rear(lines: _Lines) -> list[Piece]:
    """Tail lamps: one band around the rear, before which the boot lid stands unless it is a bar of light."""
    bottom, top = lines.tail[1] - 0.20, lines.tail[1] - 0.06
    half = lines.flank(bottom)

    def back(z: float) -> float:
        return lines.back(z) - PROUD_M

    def corner(z: float) -> float:
        return lines.back(z) + 0.08

    if lines.shape.light_bar:
        bottom += 0.05
    lamps = wrapped(Material.TAIL_LAMP, (back, 0.78 * half), (corner, 0.94 * half), (bottom, top), 0.1)
    lid = [(back(z) - PROUD_M + ahead, z, 0.56 * half) for z in (bottom - 0.1, top + 0.02) for ahead in (0.0, 0.2)]
    return [lamps] if lines.shape.light_bar else [lamps, loft(Material.PAINT, lid)]


def _mirrors(lines: _Lines) -> Piece:
    x, z = lines.cowl
    half = lines.size[1] / 2
    return block(Material.TRIM, (x - 0.44, x - 0.30), (-half, half), (z + 0.01, z + 0.13))


def _skirt(lines: _Lines) -> Piece:
    """Dark bumpers and sills all around."""
    low = lines.shape.ground_m
    half = lines.flank(low + 0.05) + PROUD_M
    plan = [
        (lines.end - 0.012, 0.71 * half),
        (lines.corner_front, half),
        (lines.corner_rear, half),
        (0.012 - lines.end, 0.83 * half),
    ]
    return around(Material.TRIM, plan, (low - 0.03, low + 0.10))


CARS: dict[str, dict[str, Builder]] = {
    kind: {name: partial(car, shape) for name, shape in shapes.items()} for kind, shapes in _SHAPES.items()
}
"""Builders of bodies by kind and name."""
