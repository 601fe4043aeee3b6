"""The scene of a plant: its track on the floor, with marks at the tile corners and things that lie about."""

from collections.abc import Sequence

import numpy as np

from contracts import BoolArray, Camera, FloatArray, SwitchState
from rail import Plant
from rail.switch_status import spot_visible
from sim.floor import MARK_RADIUS_M, control_points, floor_around
from sim.scene import Scene, Spot
from sim.shade import ground_in_view
from sim.streams import stream
from sim.surroundings import ObjectSpec, Surroundings

_LINE_STEP_M = 0.01
_MARK_CLEARANCE_M = 0.055  # half a sleeper, a mark's radius and a little more
_MACHINE_CLEARANCE_M = 0.04
_SURROUNDINGS_M = 0.5
_CLUTTER_PER_M2 = 0.6
_BARE: Surroundings = Surroundings()


def scene_of_plant(plant: Plant, cameras: Sequence[Camera], seed: int, surroundings: Surroundings = _BARE) -> Scene:
    """Lay out the scene under ``cameras``; the floor's picture and the clutter are drawn from ``seed``.

    Marks and clutter keep away from what is in ``surroundings``.
    """
    lines = tuple(section.curve.points(_LINE_STEP_M) for section in plant.sections.values())
    spots = tuple(
        Spot(
            switch.id,
            np.array(switch.spot_m),
            switch.toe.heading_rad,
            frozenset(state for state in SwitchState if spot_visible(switch, state)),
        )
        for switch in plant.switches.values()
    )
    balises = [plant.section(b.section).curve.pose_at(b.offset_m) for b in plant.balises]
    buffers = [buffer.pose for buffer in plant.buffers.values()]
    track = np.concatenate(lines)
    machines = np.array([spot.position_m for spot in spots]).reshape(-1, 2)
    floor = _floor_under(plant, cameras)
    marks = control_points(floor, track, clearance_m=_MARK_CLEARANCE_M)
    marks = _apart(marks, machines, _MACHINE_CLEARANCE_M)
    things = surroundings.things
    marks = marks[_uncovered(marks[:, :2], np.full(len(marks), MARK_RADIUS_M), things)]
    clutter = _clutter(floor, np.concatenate([track, machines]), marks[:, :2], stream(seed, "clutter/place"))
    clutter = clutter[_uncovered(clutter[:, :2], np.hypot(clutter[:, 3], clutter[:, 4]) / 2, things)]
    return Scene(
        floor_m=floor,
        control_points_m=marks,
        centrelines_m=lines,
        spots=spots,
        balises_m=np.array([[p.x_m, p.y_m, p.heading_rad] for p in balises]).reshape(-1, 3),
        buffers_m=np.array([[p.x_m, p.y_m, p.heading_rad] for p in buffers]).reshape(-1, 3),
        clutter_m=clutter,
        things=things,
        floor=surroundings.floor,
        seed=seed,
    )


def _floor_under(plant: Plant, cameras: Sequence[Camera]) -> FloatArray:
    """A floor that reaches beyond the plant and beyond every picture."""
    x0, y0, x1, y1 = plant.bounds_m
    low = [np.array([x0, y0]) - _SURROUNDINGS_M]
    high = [np.array([x1, y1]) + _SURROUNDINGS_M]
    for camera in cameras:
        centre, radius = ground_in_view(camera)
        low.append(centre[:2] - radius)
        high.append(centre[:2] + radius)
    return floor_around(np.min(low, axis=0), np.max(high, axis=0))


def _apart(points_m: FloatArray, from_m: FloatArray, distance_m: float) -> FloatArray:
    """Those of ``points_m`` (N, 2 or 3) that lie farther than ``distance_m`` from all of ``from_m`` (M, 2)."""
    if not len(from_m):
        return points_m
    gaps = np.array([np.hypot(*(from_m - point[:2]).T).min() for point in points_m])
    return points_m[gaps > distance_m]


def _uncovered(points_m: FloatArray, radii_m: FloatArray, things: Sequence[ObjectSpec]) -> BoolArray:
    """Which of the discs on the floor, (N, 2) and (N,), nothing stands on or, in a steep view, before; (N,)."""
    free = np.ones(len(points_m), np.bool_)
    for solid in (thing.solid for thing in things):
        free &= solid.gap_m(points_m) > radii_m + solid.top_m
    return free


def _clutter(floor_m: FloatArray, track_m: FloatArray, marks_m: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Boxes (N, 6) x, y, heading, length, width, height that neither touch the track nor hide a mark."""
    x0, y0, x1, y1 = floor_m
    count = round(_CLUTTER_PER_M2 * (x1 - x0) * (y1 - y0))
    low, high = [x0, y0, -np.pi, 0.05, 0.04, 0.01], [x1, y1, np.pi, 0.22, 0.14, 0.07]
    boxes = rng.uniform(low, high, (count, 6))
    # a low box at the edge of a steep view hides as much ground behind it as it is high
    reach = np.hypot(boxes[:, 3], boxes[:, 4]) / 2 + boxes[:, 5]
    clear = [
        np.hypot(*(track_m - box[:2]).T).min() > size + 0.10 and np.hypot(*(marks_m - box[:2]).T).min() > size + 0.02
        for box, size in zip(boxes, reach, strict=True)
    ]
    return np.asarray(boxes[np.array(clear, dtype=bool)])
