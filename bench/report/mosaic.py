"""All cameras on one plane, with what the chain found drawn where it says it is (paper R, figure 15).

The picture is warped with the cameras as calibrated: rails and marks that do not join are a calibration's fault. Dots
are the fused positions on the floor; roofs stand above it and so lean away from their camera.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from bench.recording import RecordedStep
from bench.report.material import ReportedRun, colours
from bench.report.pictures import data_url, sample_pictures
from bench.report.tables import table
from contracts import Camera, Compass, ImageArray, InputError, MotionState, SwitchState
from georef.mosaic import Mosaic, PlaneGrid, mosaic
from rail.plant import Plant, Switch
from rail.switch_status import spot_visible, status_from_flag

WIDTH_PX, HEIGHT_PX = 1600, 1000  # of the picture, at most
SHOWN_SCALE = 0.7  # CSS pixels for each of them
FINEST_PX_PER_M = 1200.0
MOMENTS = 2
_SIDE = 0.12  # of the width: texts so near to a side run away from it
_PAPER_BGR = (227, 233, 236)  # where no camera looks
EXPLANATION = (
    "Every camera's frame warped to the floor, north up. Dots: the fused positions, with the direction of travel "
    "where it is known. Rings: where a switch shows its white spot, filled while it does; the table says how the "
    "switch lies as seen from each vehicle under way in its direction (left or right, paper R's table 2). Switch "
    "states are the true ones."
)
_ARROWS = {Compass.NORTH: "↑", Compass.SOUTH: "↓", Compass.WEST: "←", Compass.EAST: "→"}


@dataclass(frozen=True)
class PlacedVehicle:
    """A vehicle as the chain says it: label, fused position, state, direction of travel if it moves."""

    label: str
    east_m: float
    north_m: float
    state: MotionState
    direction: Compass | None


def mosaics_html(run: ReportedRun) -> str:
    """A figure for each of a few moments of which the run kept every camera's picture; nothing if there is none."""
    cameras = [one.camera for one in run.recording.manifest.calibrated_cameras]
    grid = grid_of(cameras)
    if grid is None:
        return ""
    moments: dict[int, dict[str, ImageArray]] = {}
    for picture in sample_pictures(run):
        moments.setdefault(picture.index, {})[picture.camera] = picture.image
    whole = [index for index, images in moments.items() if images.keys() == {camera.name for camera in cameras}]
    steps = run.recording.steps
    place = {step.index: k for k, step in enumerate(steps)}
    figures = []
    for k in np.linspace(0, len(whole) - 1, min(MOMENTS, len(whole))).round().astype(int).tolist():
        here = place[whole[k]]
        vehicles = placed_vehicles(steps[here])
        figures.append(mosaic_figure(mosaic(moments[whole[k]], cameras, grid), steps[here], vehicles, run.plant))
    return "".join(figures)


def grid_of(cameras: Sequence[Camera]) -> PlaneGrid | None:
    """A grid over all that the cameras see of the floor, as fine as fits; None where that has no bounds."""
    try:
        coarse = PlaneGrid.around(cameras, px_per_m=100.0)
        fits_px_per_m = coarse.px_per_m * min(WIDTH_PX / coarse.width_px, HEIGHT_PX / coarse.height_px)
        return PlaneGrid.around(cameras, px_per_m=min(FINEST_PX_PER_M, fits_px_per_m))
    except InputError:  # no camera, or one that sees the horizon
        return None


def placed_vehicles(step: RecordedStep) -> list[PlacedVehicle]:
    """The fused vehicles of ``step`` with what the analyst said of them."""
    fused, said = step.fused, {identity: k for k, identity in enumerate(step.motions.ids.tolist())}
    vehicles = []
    for row in np.flatnonzero(fused.valid).tolist():
        east_m, north_m = fused.positions_m[row].tolist()
        k = said.get(int(fused.ids[row]))
        state = MotionState.UNKNOWN if k is None else step.motions.states[k]
        direction = None if k is None else step.motions.directions[k]
        vehicles.append(PlacedVehicle(fused.labels[row], east_m, north_m, state, direction))
    return vehicles


def mosaic_figure(picture: Mosaic, step: RecordedStep, vehicles: Sequence[PlacedVehicle], plant: Plant | None) -> str:
    """The picture with dots for the vehicles and names for the switches, and a table of the same."""
    height, width = picture.image.shape[:2]
    switches = dict(plant.switches) if plant else {}
    states = (step.truth.switches or {}) if step.truth else {}
    marks = [*_switch_marks(picture.grid, switches, states), *_vehicle_marks(picture.grid, vehicles)]
    image = f'<image x="-0.5" y="-0.5" width="{width}" height="{height}" href="{data_url(on_paper(picture))}"/>'
    view = f'viewBox="-0.5 -0.5 {width} {height}" style="max-width:{SHOWN_SCALE * width:.0f}px"'
    svg = f'<svg class="frame mosaic" {view}>{image}{"".join(marks)}</svg>'
    caption = f"{step.time_ns / 1e9:.2f} s, {1000 / picture.grid.px_per_m:.1f} mm per pixel"
    return f"<figure>{svg}<figcaption>{caption}</figcaption>{_table(vehicles, switches, states)}</figure>"


def on_paper(picture: Mosaic) -> ImageArray:
    """The picture with the page's own grey where no camera looks."""
    image = picture.image.copy()
    image[picture.seen == 0] = _PAPER_BGR
    return image


def switch_side(switch: Switch, state: SwitchState, direction: Compass | None) -> str:
    """Table 2 of paper R for one vehicle and one switch: L, R, or a dash where nobody can say."""
    if direction is None or state not in (SwitchState.STRAIGHT, SwitchState.DIVERGING):
        return "—"
    return status_from_flag(direction, spot_visible(switch, state)).value[0].upper()


def _table(vehicles: Sequence[PlacedVehicle], switches: dict[str, Switch], states: dict[str, SwitchState]) -> str:
    head = ["vehicle", "east, m", "north, m", "direction", *switches]
    rows = [
        [
            one.label,
            f"{one.east_m:.3f}",
            f"{one.north_m:.3f}",
            str(one.direction or one.state),
            *(
                switch_side(switch, states.get(name, SwitchState.UNKNOWN), one.direction)
                for name, switch in switches.items()
            ),
        ]
        for one in vehicles
    ]
    return table(head, rows)


def _switch_marks(grid: PlaneGrid, switches: dict[str, Switch], states: dict[str, SwitchState]) -> Iterator[str]:
    for name, switch in switches.items():
        u, v = grid.pixels(np.array(switch.spot_m)).tolist()
        if not (0 <= u < grid.width_px and 0 <= v < grid.height_px):
            continue
        state = states.get(name, SwitchState.UNKNOWN)
        shown = " on" if spot_visible(switch, state) else ""
        yield f'<circle class="switch{shown}" cx="{u:.1f}" cy="{v:.1f}" r="7"/>'
        yield _text(grid, "switch", f"{name} {state.value}", u, v - 14)


def _vehicle_marks(grid: PlaneGrid, vehicles: Sequence[PlacedVehicle]) -> Iterator[str]:
    paint = colours((one.label, one.label) for one in vehicles)
    for one in vehicles:
        u, v = grid.pixels(np.array([one.east_m, one.north_m])).tolist()
        heading = f" {_ARROWS[one.direction]} {one.direction.value[0].upper()}" if one.direction else f" {one.state}"
        yield f'<circle class="vehicle" cx="{u:.1f}" cy="{v:.1f}" r="9" fill="{paint[one.label]}"/>'
        yield _text(grid, "vehicle", f"{one.label} {one.east_m:.3f}, {one.north_m:.3f} m{heading}", u, v + 38)


def _text(grid: PlaneGrid, css: str, text: str, u: float, v: float) -> str:
    """Text that stays within the picture: centred, but flush where its place is near a side."""
    near = min(max(u / grid.width_px, 0.0), 1.0)
    side = "start" if near < _SIDE else "end" if near > 1 - _SIDE else "middle"
    return f'<text class="{css}" text-anchor="{side}" x="{u:.1f}" y="{v:.1f}">{escape(text)}</text>'
