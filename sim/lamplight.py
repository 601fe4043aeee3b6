"""What streetlamps throw on what a camera sees: irradiance, place by place.

OpenGL's fixed lights end at parallel beams; a lamp has a place. Irradiances are relative: 1 is the ground straight
below a lamp.
"""

import numpy as np

from contracts import FloatArray
from sim.air import Array32
from sim.roadside import LAMP_HEIGHT_M

_SHIELDED = 0.25  # cosine from the nadir at which the screen of a luminaire begins to cut its light
_FILL = 0.10  # share of a lamp's light that comes from all sides, off road and walls, to what stands upright
_NEAREST_M = 4.0  # a luminaire is no point to what is nearer
_FAINT = 5e-3  # less than this is not looked at


def irradiance(points_m: Array32, normals: Array32, lamps_m: FloatArray) -> Array32:
    """What lamps at (L, 3) throw on surfaces at (..., 3) with these unit normals, (...).

    Equal intensity to all sides below the screen's edge, so the light on a surface follows the inverse square and its
    cosine; what does not lie is lit a little from behind, too.
    """
    px, py, pz, nx, ny, nz = (part[..., axis] for part in (points_m, normals) for axis in range(3))
    total = np.zeros(points_m.shape[:-1], np.float32)
    fill = np.where(nz > np.float32(0.999), np.float32(0.0), np.float32(_FILL))
    for lamp_x, lamp_y, lamp_z in lamps_m.astype(np.float32):
        x, y, z = lamp_x - px, lamp_y - py, lamp_z - pz
        squared = np.maximum(x * x + y * y + z * z, np.float32(_NEAREST_M**2))
        nearness = 1 / np.sqrt(squared)
        cosine = np.maximum((x * nx + y * ny + z * nz) * nearness, np.float32(0.0))
        below = np.clip(z * nearness * np.float32(1 / _SHIELDED), np.float32(0.0), np.float32(1.0))
        total += below * (fill + (1 - fill) * cosine) * (np.float32(LAMP_HEIGHT_M**2) * nearness * nearness)
    return total


def near(lamps_m: FloatArray, points_m: Array32) -> FloatArray:
    """Those of the lamps (L, 3) that throw more than hardly anything on some of the points (N, 3)."""
    low, high = points_m.min(axis=0), points_m.max(axis=0)
    away_m = np.linalg.norm(np.maximum(np.maximum(low - lamps_m, lamps_m - high), 0.0), axis=1)
    strongest = LAMP_HEIGHT_M**2 / np.maximum(away_m, _NEAREST_M) ** 2
    return np.asarray(lamps_m[strongest > _FAINT])
