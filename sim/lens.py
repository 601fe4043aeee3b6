"""The lens: an oversized pinhole image bent as Brown's model says; image and masks alike."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray, Intrinsics
from sim.projection import undistorted

_MARGIN_PX = 2  # for the bilinear neighbours
_NO_WEIGHTS = np.empty(0, np.uint16)


@dataclass(frozen=True, eq=False)
class Lens:
    """What lies between the pinhole that is rendered and the image that the camera delivers.

    pinhole: the same focal lengths without distortion, large enough for every pixel of the bent image.
    bent_to_pinhole: fixed-point maps for ``cv2.remap``, 1/32 px; None for a lens that bends nothing.
    nearest: the same, rounded to whole pixels; (``cv2.remap`` would round the former *down* for masks).
    """

    pinhole: Intrinsics
    bent_to_pinhole: tuple[NDArray[np.int16], NDArray[np.uint16]] | None = None
    nearest: NDArray[np.int16] | None = None

    @classmethod
    def of(cls, intrinsics: Intrinsics) -> "Lens":
        """The lens of a camera."""
        if not intrinsics.distortion.any():
            return cls(intrinsics)
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
        return cls(pinhole, (coordinates, weights), nearest)

    def bend(self, image: ImageArray) -> ImageArray:
        """The pinhole image (H', W', 3) as the lens shows it (H, W, 3); bilinear."""
        if self.bent_to_pinhole is None:
            return image
        return np.asarray(cv2.remap(image, *self.bent_to_pinhole, interpolation=cv2.INTER_LINEAR), np.uint8)

    def bend_mask(self, mask: ImageArray) -> ImageArray:
        """The pinhole mask (H', W') as the lens shows it (H, W); nearest neighbour, so that numbers stay numbers."""
        if self.nearest is None:
            return mask
        return np.asarray(cv2.remap(mask, self.nearest, _NO_WEIGHTS, interpolation=cv2.INTER_NEAREST), np.uint8)


def pinhole_camera(camera: Camera, lens: Lens) -> Camera:
    """``camera`` with the lens taken off: what a renderer draws."""
    return Camera(camera.name, lens.pinhole, camera.pose)
