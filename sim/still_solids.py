"""What stands still and is high enough to throw a shadow on a vehicle."""

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray
from sim.box_rays import Box
from sim.lights import Beam
from sim.scene import BUFFER_SIZE_M, Scene
from sim.shade import along_beam
from sim.solids import Solid
from sim.surroundings import SHEET_M, outline_of

_Outline = NDArray[np.float32]


class StillSolids:
    """Clutter, buffer stops and what an author added; everything else that stands still is lower than 9 mm."""

    def __init__(self, scene: Scene) -> None:
        clutter = [
            Solid(outline_of("box", (x, y), turn, length, width), 0.0, height)
            for x, y, turn, length, width, height in scene.clutter_m.tolist()
        ]
        length, width, height = BUFFER_SIZE_M.tolist()
        buffers = [Solid(outline_of("box", (x, y), turn, length, width), 0.0, height) for x, y, turn in scene.buffers_m]
        things = [thing.solid for thing in scene.things]
        self._solids = [*clutter, *buffers, *(solid for solid in things if solid.top_m > SHEET_M)]
        self._shadows: dict[Beam, tuple[list[_Outline], NDArray[np.float64]]] = {}

    def before(self, box: Box, beam: Beam) -> list[Solid]:
        """Those that may keep the beam from some of ``box``: along the beam they lie over each other."""
        if not self._solids:
            return []
        if beam not in self._shadows:
            outlines = [_outline(still.corners_m, beam) for still in self._solids]
            bounds = np.array([[*outline.min(axis=0), *outline.max(axis=0)] for outline in outlines], np.float64)
            self._shadows[beam] = outlines, bounds
        outlines, bounds = self._shadows[beam]
        mine = _outline(box.corners_m, beam)
        near = (bounds[:, :2] < mine.max(axis=0)).all(axis=1) & (bounds[:, 2:] > mine.min(axis=0)).all(axis=1)
        return [
            self._solids[row]
            for row in np.flatnonzero(near).tolist()
            if cv2.intersectConvexConvex(outlines[row], mine)[0] > 0.0
        ]


def _outline(corners_m: FloatArray, beam: Beam) -> _Outline:
    """Corners (N, 3), followed along a beam to the ground: a convex outline (C, 2), metres."""
    return np.asarray(cv2.convexHull(along_beam(corners_m, beam).astype(np.float32)).reshape(-1, 2))
