"""The tiled floor and the marks on it."""

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, ImageArray, InputError
from sim.streams import stream

TILE_M = 0.40
MARK_RADIUS_M = 0.011  # a control point is a yellow disc of 22 mm
PERIOD_M = 5 * TILE_M  # the picture of the floor repeats after so many tiles: sharp at any size of floor
_TEXELS = 2048
_GROUT_M = 0.004
_GROUT_SHARE = 0.636  # of the tiles' colour, at contrast 1
_MAX_CONTRAST = 5.0


@dataclass(frozen=True)
class FloorSpec:
    """How the floor looks.

    srgb: mean colour of the tiles, red, green, blue, 0 to 255.
    contrast: factor on all that differs from it: tiles from each other, their mottle, the grout. 0 is a plain floor.
    """

    srgb: tuple[int, int, int] = (176, 171, 162)
    contrast: float = 1.0

    def __post_init__(self) -> None:
        if not all(0 <= level <= 255 for level in self.srgb):
            raise InputError(f"srgb = {list(self.srgb)} must be three levels from 0 to 255")
        if not (math.isfinite(self.contrast) and 0 <= self.contrast <= _MAX_CONTRAST):
            raise InputError(f"contrast = {self.contrast} must lie in [0, {_MAX_CONTRAST}]")


@lru_cache(maxsize=2)
def floor_texture(seed: int, floor: FloorSpec) -> ImageArray:
    """One period of the floor, (2048, 2048, 3) RGB: tiles that differ a little, with grout between them.

    The texture's edges are tile edges; it continues itself on all sides.
    """
    rng = stream(seed, "floor")
    n, tiles = _TEXELS, round(PERIOD_M / TILE_M)
    tile_of = np.arange(n) * tiles // n
    tones = rng.normal(0.0, 5.0, (tiles, tiles, 1)) + rng.normal(0.0, 1.5, (tiles, tiles, 3))
    tones = tones * floor.contrast + floor.srgb
    mottle = floor.contrast * sum(
        _mottle(rng, n, cells, strength) for cells, strength in ((32, 4.0), (128, 3.0), (1024, 3.0))
    )
    grout = _grout(n)
    tile, spans = 1 - grout, np.bincount(tile_of)
    planes = []
    dark = max(0.0, 1.0 - floor.contrast * (1.0 - _GROUT_SHARE))
    for tone, level in zip(np.moveaxis(tones.astype(np.float32), 2, 0), floor.srgb, strict=True):
        plane = np.repeat(tone[tile_of], spans, axis=1)  # (n, n)
        plane += mottle
        plane = cv2.blendLinear(plane, np.full_like(plane, dark * level), tile, grout)
        planes.append(cv2.convertScaleAbs(np.maximum(plane, 0.0)))
    return np.asarray(cv2.merge(planes), np.uint8)


def _grout(n: int) -> NDArray[np.float32]:
    """Share of grout in each texel, (n, n)."""
    from_middle = np.abs((np.arange(n) + 0.5) * PERIOD_M / n % TILE_M - TILE_M / 2)
    to_edge = (TILE_M / 2 - from_middle).astype(np.float32)  # (n,) metres to the nearest tile edge
    nearest = np.minimum(to_edge[:, None], to_edge[None, :])
    share: NDArray[np.float32] = np.clip(
        (np.float32(_GROUT_M / 2) - nearest) / np.float32(0.001) + np.float32(0.5), 0.0, 1.0
    )
    return share


def control_points(floor_m: FloatArray, keep_clear_m: FloatArray, *, clearance_m: float) -> FloatArray:
    """Marks at the tile corners of the floor (x0, y0, x1, y1), but not within ``clearance_m`` of points (N, 2).

    Returns (M, 3) world positions, all on z = 0.
    """
    x0, y0, x1, y1 = np.asarray(floor_m) / TILE_M
    x = np.arange(np.floor(x0) + 1, np.ceil(x1)) * TILE_M
    y = np.arange(np.floor(y0) + 1, np.ceil(y1)) * TILE_M
    corners = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    if len(keep_clear_m):
        apart = np.array([np.hypot(*(keep_clear_m - corner).T).min() for corner in corners])
        corners = corners[apart > clearance_m]
    return np.column_stack([corners, np.zeros(len(corners))])


def floor_around(low_m: FloatArray, high_m: FloatArray) -> FloatArray:
    """The floor (x0, y0, x1, y1) around a rectangle: whole periods, so that tile corners are multiples of 0.4 m."""
    low = np.floor(np.asarray(low_m) / PERIOD_M) * PERIOD_M
    high = np.ceil(np.asarray(high_m) / PERIOD_M) * PERIOD_M
    return np.concatenate([low, high])


def _mottle(rng: np.random.Generator, n: int, cells: int, strength: float) -> NDArray[np.float32]:
    """Soft random spots, ``cells`` along each side, of standard deviation ``strength``, continued over the edges."""
    border = 4  # cells, more than a cubic reaches
    coarse = np.pad(rng.standard_normal((cells, cells), dtype=np.float32), border, mode="wrap")
    whole = round(n * (cells + 2 * border) / cells)
    margin = (whole - n) // 2
    smooth = cv2.resize(coarse, (whole, whole), interpolation=cv2.INTER_CUBIC)[margin : margin + n, margin : margin + n]
    return np.asarray(smooth * np.float32(strength / cv2.meanStdDev(smooth)[1].item()), np.float32)
