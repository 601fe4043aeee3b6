"""All views of one moment warped to one horizontal plane: a map-like picture, exact on that plane.

What stands above the plane leans away from the camera that saw it, as a roof does here; only what lies on the plane is
where it seems to be.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, Camera, FloatArray, ImageArray, InputError
from georef.location import on_plane
from georef.projection import project

MOST_PIXELS = 64_000_000
_FEATHER = 0.25  # of an image's shorter side: over so much a view fades out towards its border


@dataclass(frozen=True)
class PlaneGrid:
    """Pixels of a picture of a horizontal plane, north up; the centre of the first pixel is its north-west corner.

    west_m, north_m: place of the first pixel's centre. px_per_m: scale. width_px, height_px: size of the picture.
    height_m: of the plane above the ground.
    """

    west_m: float
    north_m: float
    px_per_m: float
    width_px: int
    height_px: int
    height_m: float = 0.0

    def __post_init__(self) -> None:
        if not np.isfinite((self.west_m, self.north_m, self.height_m)).all() or not 0 < self.px_per_m < np.inf:
            raise InputError(f"PlaneGrid: place and scale must be finite and the scale positive, got {self}")
        if min(self.width_px, self.height_px) < 1 or self.width_px * self.height_px > MOST_PIXELS:
            raise InputError(f"PlaneGrid: {self.width_px} x {self.height_px} px is empty or too large")

    @classmethod
    def around(cls, cameras: Sequence[Camera], *, px_per_m: float, height_m: float = 0.0) -> "PlaneGrid":
        """The smallest grid that holds all that the cameras see of the plane.

        Raises InputError if a camera's image reaches the horizon, or if there is no camera.
        """
        if not cameras:
            raise InputError("PlaneGrid.around needs at least one camera")
        borders_m = [on_plane(camera, border_px(camera), height_m) for camera in cameras]
        if not all(seen.all() for _, seen in borders_m):
            raise InputError("PlaneGrid.around: an image reaches the horizon; give the grid's bounds instead")
        points_m = np.concatenate([points[:, :2] for points, _ in borders_m])
        (west, south), (east, north) = points_m.min(axis=0).tolist(), points_m.max(axis=0).tolist()
        size = np.ceil(np.array([east - west, north - south]) * px_per_m).astype(int) + 1
        return cls(west, north, px_per_m, int(size[0]), int(size[1]), height_m)

    def pixels(self, points_m: FloatArray) -> FloatArray:
        """Where points of the plane (..., 2), east and north, lie in the picture (..., 2)."""
        return np.asarray((np.asarray(points_m) - (self.west_m, self.north_m)) * (self.px_per_m, -self.px_per_m))

    def points_m(self, pixels: FloatArray) -> FloatArray:
        """The inverse of ``pixels``."""
        return np.asarray(np.asarray(pixels) / (self.px_per_m, -self.px_per_m) + (self.west_m, self.north_m))


@dataclass(frozen=True, eq=False)
class Mosaic:
    """A picture of the plane.

    image: (H, W, 3) BGR, 0 where no camera sees the plane. seen: (H, W) how many cameras do.
    """

    grid: PlaneGrid
    image: ImageArray
    seen: NDArray[np.uint8]


def mosaic(images: Mapping[str, ImageArray], cameras: Sequence[Camera], grid: PlaneGrid) -> Mosaic:
    """Warp the images, by their camera's name, to the plane; where several see the same place they are blended.

    Each image weighs the more the farther from its border a pixel lies, so that no seam shows.
    Raises InputError if an image lacks its camera or has another size than its camera says.
    """
    known = {camera.name: camera for camera in cameras}
    total = np.zeros((grid.height_px, grid.width_px, 3), np.float32)
    weight = np.zeros((grid.height_px, grid.width_px), np.float32)
    seen = np.zeros((grid.height_px, grid.width_px), np.uint8)
    for name, image in images.items():
        if name not in known:
            raise InputError(f'mosaic: there is no camera "{name}" among {", ".join(known) or "none"}')
        pixels_px, inside = seen_from(known[name], grid)
        lens = known[name].intrinsics
        if image.shape != (lens.height_px, lens.width_px, 3):
            raise InputError(f'mosaic: camera "{name}" takes {lens.width_px} x {lens.height_px} px, got {image.shape}')
        share = np.where(inside, feather(known[name], pixels_px), np.float32(0))
        u, v = (np.ascontiguousarray(pixels_px[..., k], np.float32) for k in (0, 1))
        warped = cv2.remap(image, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        total += share[..., None] * warped
        weight += share
        seen += inside.astype(np.uint8)
    blended = total / np.maximum(weight, np.finfo(np.float32).tiny)[..., None]
    return Mosaic(grid, np.round(blended).astype(np.uint8), seen)


def seen_from(camera: Camera, grid: PlaneGrid) -> tuple[FloatArray, BoolArray]:
    """Where ``camera`` images each pixel of the grid, (H, W, 2) px, and whether that is inside of its image, (H, W)."""
    u, v = np.meshgrid(np.arange(grid.width_px), np.arange(grid.height_px))
    plane_m = grid.points_m(np.stack([u, v], axis=-1))  # (H, W, 2)
    heights_m = np.full((*plane_m.shape[:2], 1), grid.height_m)
    pixels_px, ahead = project(camera, np.concatenate([plane_m, heights_m], axis=-1))
    last = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px]) - 0.5
    inside = ahead & (pixels_px >= -0.5).all(axis=-1) & (pixels_px <= last).all(axis=-1)
    return np.where(inside[..., None], pixels_px, -1.0), np.asarray(inside)


def feather(camera: Camera, pixels_px: FloatArray) -> NDArray[np.float32]:
    """How much a view weighs at ``pixels_px`` (..., 2): 1 well inside, falling to nearly 0 at the image's border."""
    size = np.array([camera.intrinsics.width_px, camera.intrinsics.height_px])
    to_border = np.minimum(pixels_px + 0.5, size - 0.5 - pixels_px).min(axis=-1)
    return np.asarray(np.clip(to_border / (_FEATHER * size.min()), 1e-3, 1.0), np.float32)


def border_px(camera: Camera, per_side: int = 32) -> FloatArray:
    """(4 N, 2) points round the image's border, corner pixels' centres included."""
    right, low = camera.intrinsics.width_px - 1.0, camera.intrinsics.height_px - 1.0
    corners = np.array([(0.0, 0.0), (right, 0.0), (right, low), (0.0, low), (0.0, 0.0)])
    shares = np.linspace(0.0, 1.0, per_side, endpoint=False)[:, None]
    return np.concatenate([a + shares * (b - a) for a, b in pairwise(corners)])
