"""The lens: an oversized pinhole image bent as Brown's model says; image and masks alike."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.polynomial.chebyshev import chebvander
from numpy.typing import NDArray

from contracts import Camera, FloatArray, ImageArray, Intrinsics
from sim.projection import undistorted
from sim.renderer import Window

_MARGIN_PX = 2  # for the bilinear neighbours
EVERYWHERE: Window = (slice(None), slice(None))
_EDGE_POINTS = 5  # along each side of a window
_ALONG = np.linspace(0.0, 1.0, _EDGE_POINTS)
_DEGREE, _EXACT_PX = 14, 1e-4
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
        pixels = _straight_px(intrinsics).reshape(-1, 2)
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
        """The pinhole image (H', W', 3) or (H', W') as the lens shows it in ``window`` of the bent image; bilinear."""
        if self.bent_to_pinhole is None:
            return image[window]
        places, weights = self.bent_to_pinhole
        return np.asarray(cv2.remap(image, places[window], weights[window], interpolation=cv2.INTER_LINEAR), np.uint8)

    def bend_mask(self, mask: ImageArray, window: Window = EVERYWHERE) -> ImageArray:
        """The pinhole mask (H', W') in the same way; nearest neighbour, so that numbers stay numbers."""
        if self.nearest is None:
            return mask[window]
        return np.asarray(cv2.remap(mask, self.nearest[window], _NO_WEIGHTS, interpolation=cv2.INTER_NEAREST), np.uint8)

    def bent_windows(self, windows: Sequence[Window]) -> list[Window]:
        """The parts of the bent image that may show something of parts of the pinhole image."""
        if self.bent_to_pinhole is None or not windows:
            return list(windows)
        pinhole = self.pinhole
        bounds = np.array([(c.start - 1, c.stop, r.start - 1, r.stop) for r, c in windows], np.float64)  # (N, 4)
        edges = bounds[:, 0::2, None] + (bounds[:, 1::2] - bounds[:, 0::2])[..., None] * _ALONG  # (N, 2, E)
        rays = np.ones((len(windows), _EDGE_POINTS, _EDGE_POINTS, 3))
        rays[..., 0] = (edges[:, 0, None, :] - pinhole.cx_px) / pinhole.fx_px
        rays[..., 1] = (edges[:, 1, :, None] - pinhole.cy_px) / pinhole.fy_px
        matrix, distortion = self.bent.matrix, self.bent.distortion
        bent = cv2.projectPoints(rays.reshape(-1, 3), np.zeros(3), np.zeros(3), matrix, distortion)[0]
        bent = bent.reshape(len(windows), -1, 2)
        size = (self.bent.width_px, self.bent.height_px)
        low = np.clip(np.floor(bent.min(axis=1)).astype(int) - 1, 0, size).tolist()
        high = np.clip(np.ceil(bent.max(axis=1)).astype(int) + 2, 0, size).tolist()
        return [(slice(v0, v1), slice(u0, u1)) for (u0, v0), (u1, v1) in zip(low, high, strict=True)]


def _straight_px(intrinsics: Intrinsics) -> FloatArray:
    """Where a pinhole of the same K shows what each pixel shows, (H, W, 2).

    The way back through a lens is smooth: a polynomial through exact values is exact, too, and much cheaper.
    """
    size = np.array([intrinsics.width_px, intrinsics.height_px])
    nodes = np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))  # Chebyshev's, in [-1, 1]
    exact = _straight_at(intrinsics, *np.meshgrid(*((nodes[None] + 1) / 2 * (size[:, None] - 1))))  # (n, n, 2)
    to_coefficients = np.linalg.inv(chebvander(nodes, _DEGREE))
    coefficients = np.einsum("ia,jb,abk->kij", to_coefficients, to_coefficients, exact)  # by degree in v, in u
    in_u, in_v = (chebvander(np.linspace(-1.0, 1.0, n), _DEGREE) for n in size)
    pixels = np.stack([in_v @ plane @ in_u.T for plane in coefficients], axis=-1)  # (H, W, 2)
    tried = np.s_[:: max(1, size[1] // 16), :: max(1, size[0] // 16)]
    u, v = np.meshgrid(np.arange(float(size[0])), np.arange(float(size[1])))
    if np.abs(pixels[tried] - _straight_at(intrinsics, u[tried], v[tried])).max() > _EXACT_PX:
        return _straight_at(intrinsics, u, v)
    return np.asarray(pixels)


def _straight_at(intrinsics: Intrinsics, u: FloatArray, v: FloatArray) -> FloatArray:
    """The same for pixels u, v (H, W), one by one."""
    normalised = undistorted(intrinsics, np.stack([u, v], axis=-1).reshape(-1, 2))
    pixels = normalised * (intrinsics.fx_px, intrinsics.fy_px) + (intrinsics.cx_px, intrinsics.cy_px)
    return np.asarray(pixels.reshape(*u.shape, 2))


def pinhole_camera(camera: Camera, lens: Lens) -> Camera:
    """``camera`` with the lens taken off: what a renderer draws."""
    return Camera(camera.name, lens.pinhole, camera.pose)
