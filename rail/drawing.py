"""A plant drawn to scale, as SVG: millimetres on the ground, east to the right, north up."""

from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from math import ceil, cos, degrees, floor

import numpy as np

from contracts import FloatArray
from rail.curves import Pose2
from rail.plant import Balise, BufferStop, Plant, Section, Switch

TILE_M = 0.4
MARGIN_M = 0.3
SPOT_DIAMETER_M = 0.01
_PIXELS_PER_M = 400.0
_MAX_PIXELS = 6000.0

_STYLE = """
.floor { fill: #f4f1ea } .tile { stroke: #ddd6c8; stroke-width: 2 }
.bed { fill: none; stroke: #cfc6b4; stroke-width: 44; stroke-linecap: butt }
.rail { fill: none; stroke: #454a52; stroke-width: 10 }
.straight { fill: none; stroke: #2a7f4f; stroke-width: 10 } .diverging { fill: none; stroke: #c8641e; stroke-width: 10 }
.machine { fill: #33373d } .spot { fill: #ffffff } .balise { fill: #1f5fae } .buffer { fill: #b3261e }
.crossing { fill: none; stroke: #7a3fa0; stroke-width: 5 }
text { font-family: sans-serif; fill: #33373d; text-anchor: middle; dominant-baseline: central;
  paint-order: stroke; stroke: #f4f1ea; stroke-width: 8 }
.name { font-weight: bold } .section { fill: #7c7466 }
.vehicle { stroke: #222222; stroke-width: 3 }
"""


@dataclass(frozen=True)
class VehicleMark:
    """A vehicle to draw: its pose at the footprint's centre, its size and a CSS colour."""

    label: str
    pose: Pose2
    length_m: float
    width_m: float
    colour: str


def plant_svg(plant: Plant, *, vehicles: Iterable[VehicleMark] = ()) -> str:
    """The whole plant as an SVG document: tiles, sections, switches with their spot, balises, buffers, a scale bar.

    vehicles: drawn on top. A switch's straight branch begins green, its diverging one orange.
    """
    x0, y0, x1, y1 = _page(plant)
    text_mm = min(max(34.0, (x1 - x0) * 1000.0 / 260.0), 44.0)  # fits between tracks 11 cm apart
    pixels_per_m = min(_PIXELS_PER_M, _MAX_PIXELS / (x1 - x0))
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{_mm(x0)} {_mm(-y1)} {_mm(x1 - x0)} {_mm(y1 - y0)}" '
        f'width="{(x1 - x0) * pixels_per_m:.0f}" height="{(y1 - y0) * pixels_per_m:.0f}">',
        f"<title>{escape(plant.name)}</title><style>{_STYLE}text {{ font-size: {text_mm:.0f}px }}</style>",
        f'<rect class="floor" x="{_mm(x0)}" y="{_mm(-y1)}" width="{_mm(x1 - x0)}" height="{_mm(y1 - y0)}"/>',
        *_tiles(x0, y0, x1, y1),
        *(_track("bed", section.curve.points(0.02)) for section in plant.sections.values()),
        *(_track("rail", section.curve.points(0.02)) for section in plant.sections.values()),
        *(part for switch in plant.switches.values() for part in _branches(plant, switch)),
        *(_circle("crossing", *crossing.position_m, 0.04) for crossing in plant.crossings.values()),
        *(_balise(plant, balise) for balise in plant.balises),
        *(_buffer(buffer) for buffer in plant.buffers.values()),
        *(part for switch in plant.switches.values() for part in _notch(switch, text_mm)),
        *(_section_name(section, text_mm) for section in plant.sections.values()),
        *(part for vehicle in vehicles for part in _vehicle(vehicle)),
        _scale_bar(x0, y0, text_mm),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _page(plant: Plant) -> tuple[float, float, float, float]:
    """Bounds of the drawing, m: whole tiles around the plant."""
    x0, y0, x1, y1 = plant.bounds_m
    low = [floor((value - MARGIN_M) / TILE_M) * TILE_M for value in (x0, y0)]
    high = [ceil((value + MARGIN_M) / TILE_M) * TILE_M for value in (x1, y1)]
    return low[0], low[1], high[0], high[1]


def _mm(value_m: float) -> str:
    return f"{1000.0 * value_m:.1f}"


def _point(x_m: float, y_m: float) -> str:
    return f"{_mm(x_m)},{_mm(-y_m)}"


def _tiles(x0: float, y0: float, x1: float, y1: float) -> list[str]:
    columns = np.arange(round(x0 / TILE_M), round(x1 / TILE_M) + 1) * TILE_M
    rows = np.arange(round(y0 / TILE_M), round(y1 / TILE_M) + 1) * TILE_M
    lines = [((x, y0), (x, y1)) for x in columns.tolist()] + [((x0, y), (x1, y)) for y in rows.tolist()]
    return [f'<path class="tile" d="M {_point(*a)} L {_point(*b)}"/>' for a, b in lines]


def _track(css: str, points_m: FloatArray) -> str:
    return f'<path class="{css}" d="M {" L ".join(_point(x, y) for x, y in points_m.tolist())}"/>'


def _circle(css: str, x_m: float, y_m: float, diameter_m: float) -> str:
    return f'<circle class="{css}" cx="{_mm(x_m)}" cy="{_mm(-y_m)}" r="{_mm(diameter_m / 2.0)}"/>'


def _box(css: str, pose: Pose2, length_m: float, width_m: float, *, fill: str = "", tip: str = "") -> str:
    """A rectangle centred on ``pose``, its length along the heading; ``tip`` shows under the mouse."""
    turn = f"translate({_point(pose.x_m, pose.y_m)}) rotate({-degrees(pose.heading_rad):.3f})"
    size = f'x="{_mm(-length_m / 2)}" y="{_mm(-width_m / 2)}" width="{_mm(length_m)}" height="{_mm(width_m)}"'
    colour = f' fill="{escape(fill)}"' if fill else ""
    return f'<rect class="{css}" transform="{turn}" {size}{colour}><title>{escape(tip)}</title></rect>'


def _text(css: str, text: str, x_m: float, y_m: float, angle_rad: float = 0.0) -> str:
    turn = f"translate({_point(x_m, y_m)}) rotate({-degrees(angle_rad):.1f})"
    return f'<text class="{css}" transform="{turn}">{escape(text)}</text>'


def _branches(plant: Plant, switch: Switch) -> list[str]:
    """The first decimetres of both branches, in their colours."""
    parts = []
    for css, port in (("straight", switch.straight), ("diverging", switch.diverging)):
        curve = plant.sections[port.section].curve
        offsets_m = np.linspace(0.0, min(0.2, curve.length_m), 11)
        if port.end == "end":
            offsets_m = curve.length_m - offsets_m
        parts.append(_track(css, curve.poses_at(offsets_m)[:, :2]))
    return parts


def _notch(switch: Switch, text_mm: float) -> list[str]:
    """The machine with its spot beside the stem, and the switch's name beyond."""
    x, y = switch.spot_m
    toe = switch.toe
    side = 1.0 if toe.left_of(x, y) > 0 else -1.0
    name_at = toe.offset(0.0, side * (0.075 + text_mm / 2000.0))
    machine = _box("machine", Pose2(x, y, toe.heading_rad), 0.05, 0.024, tip=f"switch {switch.id}")
    return [machine, _circle("spot", x, y, SPOT_DIAMETER_M), _text("name", switch.id, *name_at)]


def _balise(plant: Plant, balise: Balise) -> str:
    pose = plant.sections[balise.section].curve.pose_at(balise.offset_m)
    return _box("balise", pose, 0.03, 0.02, tip=f"balise {balise.name}")


def _buffer(buffer: BufferStop) -> str:
    return _box("buffer", buffer.pose, 0.02, 0.07, tip=f"buffer {buffer.id}")


def _section_name(section: Section, text_mm: float) -> str:
    """Beside the track and along it, never upside down; off the middle, where tracks like to cross."""
    pose = section.curve.pose_at(0.44 * section.length_m)
    reading = pose if cos(pose.heading_rad) > -1e-6 else pose.reversed()
    return _text("section", section.id, *reading.offset(0.0, 0.03 + text_mm / 2000.0), reading.heading_rad)


def _vehicle(vehicle: VehicleMark) -> list[str]:
    body = _box("vehicle", vehicle.pose, vehicle.length_m, vehicle.width_m, fill=vehicle.colour, tip=vehicle.label)
    return [body, _text("name", vehicle.label, vehicle.pose.x_m, vehicle.pose.y_m)]


def _scale_bar(x0: float, y0: float, text_mm: float) -> str:
    x, y = x0 + 0.1, y0 + 0.1
    bar = f'<path stroke="#33373d" stroke-width="12" d="M {_point(x, y)} L {_point(x + 1.0, y)}"/>'
    return bar + _text("name", "1 m", x + 0.5, y + 0.02 + text_mm / 2000.0)
