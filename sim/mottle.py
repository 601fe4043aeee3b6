"""Unevenness of asphalt, pavement and grass: seen from above, at the places that a picture shows.

Spots of several sizes, each faded where a pixel covers more than a spot: far surfaces are even, and do not flicker.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from sim.road_scene import KIND_CODES, PartKind
from sim.streams import stream

Array32 = NDArray[np.float32]

_TILE = 256  # spots along each side of the pattern, which then repeats
_SPOTS_M = (0.08, 0.6, 3.5)
_STRENGTH = {
    PartKind.ROAD: (0.050, 0.030, 0.045),
    PartKind.PAVEMENT: (0.030, 0.030, 0.040),
    PartKind.PAINT: (0.030, 0.040, 0.040),
    PartKind.GROUND: (0.080, 0.080, 0.090),
}


def mottle(kinds: NDArray[np.uint8], points_m: Array32, size_m: Array32, seed: int) -> Array32:
    """Factors (H, W) on the albedo of what each pixel shows.

    kinds: (H, W) codes of ``KIND_CODES``. points_m: (H, W, 3) world. size_m: (H, W) length of a pixel on the surface.
    """
    strengths = np.zeros((1 + len(KIND_CODES), len(_SPOTS_M)), np.float32)
    for kind, values in _STRENGTH.items():
        strengths[KIND_CODES[kind]] = values
    factor = np.ones(kinds.shape, np.float32)
    for octave, spot_m in enumerate(_SPOTS_M):
        factor += strengths[kinds, octave] * spots(points_m, size_m, spot_m, seed, f"mottle/{octave}")
    return np.maximum(factor, np.float32(0.1))


def spots(points_m: Array32, size_m: Array32, spot_m: float, seed: int, concern: str) -> Array32:
    """Standard normal values (H, W) that change over ``spot_m`` on the ground, drawn for a concern from the seed."""
    pattern = stream(seed, concern).standard_normal((_TILE, _TILE), dtype=np.float32)
    places = np.mod(points_m[..., :2] / np.float32(spot_m), _TILE)
    u, v = (np.ascontiguousarray(places[..., axis] + 1) for axis in range(2))
    values = cv2.remap(np.pad(pattern, 1, mode="wrap"), u, v, cv2.INTER_LINEAR)
    return np.asarray(values / (1 + (size_m / np.float32(spot_m)) ** 2), np.float32)
