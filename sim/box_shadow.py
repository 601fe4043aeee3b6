"""Where the shadow of a box may fall in a picture, and where it must: what is between is looked at sample by sample.

A beam is parallel, so the shadow of a box is a convex prism that begins at the box. A ray of the camera meets the
ground and all that stands on it between two heights; if the prism holds the ray at both, it holds it between them.
"""

from dataclasses import dataclass

import numpy as np

from contracts import Camera, FloatArray
from sim.box_rays import SKIN_M, Box
from sim.lights import Beam
from sim.outlines import NEAR_M, hull, seen_px
from sim.scene import FLOOR_Z_M

_RIM = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@dataclass(frozen=True, eq=False)
class BoxShadow:
    """The shadow of an upright box in one beam, before one camera."""

    box: Box
    beam: Beam
    camera: Camera

    def outline_px(self) -> FloatArray:
        """Outline (C, 2) outside of which nothing between the floor and the top of the box is shaded by it."""
        low, top = self._ends_m(0.0)
        seen = self._sections_px((FLOOR_Z_M, max(FLOOR_Z_M, low), top), thinner_m=0.0)
        if seen is None:  # partly behind the camera: it may show anywhere
            size = self.camera.intrinsics
            return np.array([[-1, -1], [size.width_px, -1], [size.width_px, size.height_px], [-1, size.height_px]])
        return hull(seen.reshape(-1, 2))

    def sure_px(self, below_m: float) -> tuple[FloatArray, ...]:
        """Outlines (C, 2) inside all of which everything between the floor and ``below_m`` is shaded.

        None where nothing is certain.
        """
        # a beam that touches a core of the box runs farther than the skin through the box
        if below_m >= self._ends_m(SKIN_M)[1] or self.box.half_m.min() <= SKIN_M:
            return ()
        seen = self._sections_px((FLOOR_Z_M, below_m), thinner_m=SKIN_M)
        return () if seen is None else tuple(hull(section) for section in seen)

    def _ends_m(self, thinner_m: float) -> tuple[float, float]:
        """Heights of bottom and top."""
        middle, half = float(self.box.centre_m[2]), float(self.box.half_m[2]) - thinner_m
        return middle - half, middle + half

    def _sections_px(self, heights_m: tuple[float, ...], *, thinner_m: float) -> FloatArray | None:
        """Points (H, 8, 2) around the prism's sections at heights below its top; None if some are behind the camera."""
        box, pose = self.box, self.camera.pose
        rim = (_RIM * (box.half_m[:2] - thinner_m)) @ box.world_from_box[:2, :2].T + box.centre_m[:2]  # (4, 2)
        low, top = self._ends_m(thinner_m)
        heights = np.array(heights_m)
        fall = np.stack([np.maximum(low - heights, 0.0), top - heights], axis=1)  # (H, 2)
        per_metre = self.beam.direction[:2] / self.beam.direction[2]
        points = np.empty((len(heights), 2, 4, 3))
        points[..., :2] = rim - (fall[..., None] * per_metre)[:, :, None]
        points[..., 2] = heights[:, None, None]
        in_camera = (points.reshape(len(heights), 8, 3) - pose.position_m) @ pose.world_from_camera
        return seen_px(self.camera, in_camera) if in_camera[..., 2].min() >= NEAR_M else None
