"""The exact truth of a simulated world. Only ``sim`` makes it and only the recording and the score read it.

``perception``, ``georef`` and ``rail`` may not import this module; import-linter proves that they do not.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from contracts.arrays import FloatArray, freeze
from contracts.camera import Camera
from contracts.events import Event
from contracts.frame import Frame
from contracts.survey import Survey
from contracts.switches import SwitchState


@dataclass(frozen=True)
class Place:
    """Where on the track a vehicle's centre is.

    offset_m: metres along the section from its start.
    direction: +1 if the vehicle faces the section's end, -1 if it faces the start.
    """

    section: str
    offset_m: float
    direction: int


@dataclass(frozen=True)
class Occlusion:
    """Something that hides a part of an object.

    by: the id of another object, what stands still ("building", "tree", ...), or "border" of the image.
    fraction: of all pixels that the object would cover alone in an unbounded image.
    """

    by: str
    fraction: float


@dataclass(frozen=True, eq=False)
class CameraTruth:
    """What one camera sees of the N objects of ``Truth``, row for row, with the lens as it is.

    visible_fractions: (N,) visible pixels over all pixels that the object would cover alone in an unbounded image.
    full_boxes_px: (N, 4) upright box of the whole object; may leave the image; NaN behind the camera.
    visible_boxes_px: (N, 4) upright box of its visible pixels; NaN where none is.
    footprints_px: (N, 2) image of the footprint's centre; NaN behind the camera.
    roofs_px: (N, 2) image of the centre of the upper face; NaN behind the camera.
    footprint_corners_px: (N, 4, 2) images of the footprint's corners: rear right, rear left, front right, front left;
        NaN behind the camera, None where not told.
    hidden_by: N times what hides the object from this camera; empty where not told.
    instances: (H, W) uint8, 0 for background and k + 1 for row k; None where not kept.
    """

    camera: str
    index: int
    time_ns: int
    visible_fractions: FloatArray
    full_boxes_px: FloatArray
    visible_boxes_px: FloatArray
    footprints_px: FloatArray
    roofs_px: FloatArray
    footprint_corners_px: FloatArray | None = None
    hidden_by: tuple[tuple[Occlusion, ...], ...] = ()
    instances: NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        n = len(self.visible_fractions)
        freeze(self, "visible_fractions", shape=(n,))
        freeze(self, "full_boxes_px", shape=(n, 4), finite=False)
        freeze(self, "visible_boxes_px", shape=(n, 4), finite=False)
        freeze(self, "footprints_px", shape=(n, 2), finite=False)
        freeze(self, "roofs_px", shape=(n, 2), finite=False)
        if self.footprint_corners_px is not None:
            freeze(self, "footprint_corners_px", shape=(n, 4, 2), finite=False)
        if self.instances is not None:
            freeze(self, "instances", shape=(None, None), dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class Truth:
    """The state of the world at mid-exposure; N objects.

    ids, labels: N names, and N colours or classes as perception would call them.
    positions_m: (N, 3) centre of the footprint.
    headings_rad: (N,) counter-clockwise from east.
    sizes_m: (N, 3) length, width, height.
    velocities_mps: (N, 2) of the footprint's centre.
    places: N places on the track, None where the object runs on none.
    kinds: N kinds, finer than the labels, or none where labels say all.
    switches: state of every switch by id.
    events: what happened since the previous step, up to and including this moment.
    cameras: one view per filmed camera; empty where nothing was filmed.
    travelled_m: (N,) way gone since the object was first there; None where not told.
    """

    index: int
    time_ns: int
    ids: tuple[str, ...]
    labels: tuple[str, ...]
    positions_m: FloatArray
    headings_rad: FloatArray
    sizes_m: FloatArray
    velocities_mps: FloatArray
    places: tuple[Place | None, ...] = ()
    kinds: tuple[str, ...] = ()
    switches: dict[str, SwitchState] | None = None
    events: tuple[Event, ...] = ()
    cameras: tuple[CameraTruth, ...] = ()
    travelled_m: FloatArray | None = None

    def __post_init__(self) -> None:
        n = len(self.ids)
        if self.travelled_m is not None:
            freeze(self, "travelled_m", shape=(n,))
        freeze(self, "positions_m", shape=(n, 3))
        freeze(self, "headings_rad", shape=(n,))
        freeze(self, "sizes_m", shape=(n, 3))
        freeze(self, "velocities_mps", shape=(n, 2))


@dataclass(frozen=True, eq=False)
class Step:
    """One moment of a world: the frames for perception, the truth for the recording; None where the world is real."""

    frames: tuple[Frame, ...]
    truth: Truth | None


class World(Protocol):
    """A simulated world, already seeded."""

    @property
    def survey(self) -> Survey:
        """What the cameras' owner knows beforehand."""
        ...

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The true cameras; for the score and for oracles only."""
        ...

    def __len__(self) -> int:
        """Number of steps."""
        ...

    def steps(self) -> Iterator[Step]:
        """From the start to the end of the scenario; the same each time it is called."""
        ...

    def board_views(self, camera: str) -> Iterator[Frame]:
        """The checkerboard in many poses before one camera, through the same lens and sensor."""
        ...
