"""The lens: an oversized pinhole image bent as Brown's model says; image and masks alike."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import Camera, ImageArray, Intrinsics
from sim.projection import undistorted

_MARGIN_PX = 2  # for the bilinear neighbours


@dataclass(frozen=True, eq=False)
class Lens:
    """What lies between the pinhole that is rendered and the image that the camera delivers.

    pinhole: the same focal lengths without distortion, large enough for every pixel of the bent image.
    maps: fixed-point maps of ``cv2.remap`` from bent pixels to pinhole pixels; None for a lens that bends nothing.
    """

    pinhole: Intrinsics
    maps: tuple[NDArray[np.int16], NDArray[np.uint16]] | None

    @classmethod
    def of(cls, intrinsics: Intrinsics) -> "Lens":
        """The lens of a camera."""
        if not intrinsics.distortion.any():
            return cls(intrinsics, None)
        width, height = intrinsics.width_px, intrinsics.height_px
        u, v = np.meshgrid(np.arange(width), np.arange(height))
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
        return cls(pinhole, (coordinates, weights))

    def bend(self, image: ImageArray) -> ImageArray:
        """The pinhole image (H', W', 3) as the lens shows it (H, W, 3); bilinear."""
        if self.maps is None:
            return image
        return cv2.remap(image, *self.maps, interpolation=cv2.INTER_LINEAR)

    def bend_mask(self, mask: ImageArray) -> ImageArray:
        """The pinhole mask (H', W') as the lens shows it (H, W); nearest neighbour, so that numbers stay numbers."""
        if self.maps is None:
            return mask
        return cv2.remap(mask, *self.maps, interpolation=cv2.INTER_NEAREST)


def pinhole_camera(camera: Camera, lens: Lens) -> Camera:
    """``camera`` with the lens taken off: what a renderer draws."""
    return Camera(camera.name, lens.pinhole, camera.pose)
