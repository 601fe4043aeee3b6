"""The lens: an oversized pinhole image bent as Brown's model says; image and masks alike."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray, Intrinsics
from sim.projection import undistorted
from sim.renderer import Window

_MARGIN_PX = 2  # for the bilinear neighbours
EVERYWHERE: Window = (slice(None), slice(None))
_EDGE_POINTS = 5  # along each side of a window
_NO_WEIGHTS = np.empty(0, np.uint16)


@dataclass(frozen=True, eq=False)
class Lens:
    """What lies between the pinhole that is rendered and the image that the camera delivers.

    bent: the camera's own intrinsics.
    pinhole: the same focal lengths without distortion, large enough for every pixel of the bent image.
    bent_to_pinhole: fixed-point maps for ``cv2.remap``, 1/32 px; None for a lens that bends nothing.
    nearest: the same, rounded to whole pixels; (``cv2.remap`` would round the former *down* for masks).
    """

    bent: Intrinsics
    pinhole: Intrinsics
    bent_to_pinhole: tuple[NDArray[np.int16], NDArray[np.uint16]] | None = None
    nearest: NDArray[np.int16] | None = None

    @staticmethod
    @lru_cache(maxsize=8)  # half a second each: board views and frames share them
    def of(intrinsics: Intrinsics) -> "Lens":
        """The lens of a camera."""
        if not intrinsics.distortion.any():
            return Lens(intrinsics, intrinsics)
        width, height = intrinsics.width_px, intrinsics.height_px
        u, v = np.meshgrid(np.arange(float(width)), np.arange(float(height)))
        normalised = undistorted(intrinsics, np.stack([u, v], axis=-1).reshape(-1, 2))  # (H W, 2)
        pixels = normalised * (intrinsics.fx_px, intrinsics.fy_px) + (intrinsics.cx_px, intrinsics.cy_px)
        low = np.floor(pixels.min(axis=0)).astype(int) - _MARGIN_PX
        high = np.ceil(pixels.max(axis=0)).astype(int) + _MARGIN_PX
        pinhole = Intrinsics(
            int(high[0] - low[0] + 1),
            int(high[1] - low[1] + 1),
            intrinsics.fx_px,
            intrinsics.fy_px,
            intrinsics.cx_px - low[0],
            intrinsics.cy_px - low[1],
            np.zeros(5),
        )
        source = (pixels - low).reshape(height, width, 2).astype(np.float32)
        coordinates, weights = cv2.convertMaps(source[..., 0], source[..., 1], cv2.CV_16SC2)
        nearest, _ = cv2.convertMaps(source[..., 0], source[..., 1], cv2.CV_16SC2, nninterpolation=True)
        return Lens(intrinsics, pinhole, (coordinates, weights), nearest)

    def bend(self, image: ImageArray, window: Window = EVERYWHERE) -> ImageArray:
        """The pinhole image (H', W', 3) as the lens shows it in ``window`` of the bent image; bilinear."""
        if self.bent_to_pinhole is None:
            return image[window]
        places, weights = self.bent_to_pinhole
        return np.asarray(cv2.remap(image, places[window], weights[window], interpolation=cv2.INTER_LINEAR), np.uint8)

    def bend_mask(self, mask: ImageArray, window: Window = EVERYWHERE) -> ImageArray:
        """The pinhole mask (H', W') in the same way; nearest neighbour, so that numbers stay numbers."""
        if self.nearest is None:
            return mask[window]
        return np.asarray(cv2.remap(mask, self.nearest[window], _NO_WEIGHTS, interpolation=cv2.INTER_NEAREST), np.uint8)

    def bent_window(self, window: Window) -> Window:
        """The part of the bent image that may show something of ``window`` of the pinhole image."""
        if self.bent_to_pinhole is None:
            return window
        (rows, columns), pinhole = window, self.pinhole
        x = (np.linspace(columns.start - 1, columns.stop, _EDGE_POINTS) - pinhole.cx_px) / pinhole.fx_px
        y = (np.linspace(rows.start - 1, rows.stop, _EDGE_POINTS) - pinhole.cy_px) / pinhole.fy_px
        grid = np.stack([*np.meshgrid(x, y), np.ones((_EDGE_POINTS, _EDGE_POINTS))], axis=-1).reshape(-1, 3)
        bent, _ = cv2.projectPoints(grid, np.zeros(3), np.zeros(3), self.bent.matrix, self.bent.distortion)
        width, height = self.bent.width_px, self.bent.height_px
        low = np.clip(np.floor(bent.reshape(-1, 2).min(axis=0)).astype(int) - 1, 0, (width, height))
        high = np.clip(np.ceil(bent.reshape(-1, 2).max(axis=0)).astype(int) + 2, 0, (width, height))
        return slice(low[1], high[1]), slice(low[0], high[0])


def pinhole_camera(camera: Camera, lens: Lens) -> Camera:
    """``camera`` with the lens taken off: what a renderer draws."""
    return Camera(camera.name, lens.pinhole, camera.pose)
