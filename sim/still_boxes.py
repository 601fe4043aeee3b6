"""Boxes of the scene that stand still and are high enough to throw a shadow on a vehicle."""

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.box_rays import Box, upright_box
from sim.lights import Beam
from sim.scene import BUFFER_SIZE_M, Scene
from sim.shade import along_beam

_Outline = NDArray[np.float32]


class StillBoxes:
    """Clutter and buffer stops; everything else that stands still is lower than 9 mm."""

    def __init__(self, scene: Scene) -> None:
        clutter = [upright_box(np.array([x, y, 0.0]), turn, np.array(size)) for x, y, turn, *size in scene.clutter_m]
        buffers = [upright_box(np.array([x, y, 0.0]), turn, BUFFER_SIZE_M) for x, y, turn in scene.buffers_m]
        self._boxes = [*clutter, *buffers]
        self._shadows: dict[Beam, tuple[list[_Outline], NDArray[np.float64]]] = {}

    def before(self, box: Box, beam: Beam) -> list[Box]:
        """Those that may keep the beam from some of ``box``: along the beam they lie over each other."""
        if not self._boxes:
            return []
        if beam not in self._shadows:
            outlines = [_outline(still, beam) for still in self._boxes]
            bounds = np.array([[*outline.min(axis=0), *outline.max(axis=0)] for outline in outlines], np.float64)
            self._shadows[beam] = outlines, bounds
        outlines, bounds = self._shadows[beam]
        mine = _outline(box, beam)
        near = (bounds[:, :2] < mine.max(axis=0)).all(axis=1) & (bounds[:, 2:] > mine.min(axis=0)).all(axis=1)
        return [
            self._boxes[row]
            for row in np.flatnonzero(near).tolist()
            if cv2.intersectConvexConvex(outlines[row], mine)[0] > 0.0
        ]


def _outline(box: Box, beam: Beam) -> _Outline:
    """A box, followed along a beam to the ground: a convex outline (C, 2), metres."""
    return np.asarray(cv2.convexHull(along_beam(box.corners_m, beam).astype(np.float32)).reshape(-1, 2))
