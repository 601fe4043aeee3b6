"""The scene: everything that stands still, in numbers. ``sim.scene_model`` builds it for MuJoCo."""

from dataclasses import dataclass, field

import numpy as np

from contracts import FloatArray, SwitchState
from sim.floor import FloorSpec
from sim.surroundings import ObjectSpec

FLOOR_Z_M = -0.0005  # just below the marks, which lie exactly on z = 0
SPOT_RADIUS_M = 0.005
SPOT_HEIGHT_M = 0.006  # the lid of a switch machine
BUFFER_SIZE_M = np.array([0.008, 0.050, 0.030])  # along the track, across, height


@dataclass(frozen=True, eq=False)
class Spot:
    """The white spot on a switch's notch: where it is, and in which states it shows."""

    switch: str
    position_m: FloatArray
    heading_rad: float
    visible_in: frozenset[SwitchState]


@dataclass(frozen=True, eq=False)
class Scene:
    """What stands still, in metres, world.

    floor_m: (4,) x0, y0, x1, y1, whole periods of the floor's picture.
    control_points_m: (N, 3) centres of the yellow marks.
    centrelines_m: tracks, each (N, 2), densely sampled.
    spots: one per switch.
    balises_m, buffers_m: (N, 3) x, y, heading.
    clutter_m: (N, 6) x, y, heading, length, width, height of boxes beside the track.
    things: what an author added.
    floor: how the floor looks.
    seed: of the floor's picture and the clutter's colours.
    """

    floor_m: FloatArray
    control_points_m: FloatArray
    centrelines_m: tuple[FloatArray, ...] = ()
    spots: tuple[Spot, ...] = ()
    balises_m: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    buffers_m: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    clutter_m: FloatArray = field(default_factory=lambda: np.empty((0, 6)))
    things: tuple[ObjectSpec, ...] = ()
    floor: FloorSpec = field(default_factory=FloorSpec)
    seed: int = 0
