"""How high the empty scene rises in the parts of a picture."""

import numpy as np

from contracts import Camera
from sim.box_rays import SAMPLES_PX, Array32
from sim.renderer import Window

_BLOCK_PX = 16
_ROUNDING_M = 1e-4  # of a depth


class Skyline:
    """Upper bounds of the height of what one camera sees of the empty scene.

    depth_m: (S, H, W) at each of ``SAMPLES_PX``.
    """

    def __init__(self, camera: Camera, depth_m: Array32) -> None:
        numbers, pose = camera.intrinsics, camera.pose
        height, width = depth_m.shape[1:]
        climb = pose.world_from_camera[2]
        tops = np.full((height, width), -np.inf, np.float32)
        for (du, dv), depth in zip(SAMPLES_PX, depth_m, strict=True):
            x = (np.arange(width) + du - numbers.cx_px) / numbers.fx_px
            y = (np.arange(height) + dv - numbers.cy_px) / numbers.fy_px
            per_metre = (climb[0] * x + climb[2]).astype(np.float32) + (climb[1] * y).astype(np.float32)[:, None]
            np.maximum(tops, depth * per_metre, out=tops)
        by_rows = np.maximum.reduceat(tops, np.arange(0, height, _BLOCK_PX), axis=0)
        self._tops_m = np.maximum.reduceat(by_rows, np.arange(0, width, _BLOCK_PX), axis=1) + pose.position_m[2]

    def below_m(self, window: Window) -> float:
        """A height below which everything lies that the window shows."""
        rows, columns = (slice(part.start // _BLOCK_PX, (part.stop - 1) // _BLOCK_PX + 1) for part in window)
        return float(self._tops_m[rows, columns].max()) + _ROUNDING_M
