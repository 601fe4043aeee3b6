"""Where there is no beam, the sky's light still does not get beneath a vehicle: the dark that makes it stand."""

import numpy as np

from contracts import FloatArray
from contracts.truth import Truth
from sim.air import Array32

_REACH_M = 1.0
_STRENGTH, _WIDE_M = 0.72, 1.2  # of the shade below a body, and how wide one is that keeps all of it away
_SOFT, _TALLEST_M = 0.24, 1.4  # width of the shade's edge, in heights of the body
_INSET_M = 0.10  # bodies are narrower at the ground than their boxes


def contact_shade(points_m: Array32, state: Truth) -> Array32:
    """Share of the diffuse light that users keep from the ground at (..., 3), (...) in [0, 1)."""
    left = np.ones(points_m.shape[:-1], np.float32)
    for row in range(len(state.ids)):
        left *= 1 - shade_of(points_m, state, row)
    return 1 - left


def shade_of(points_m: Array32, state: Truth, row: int) -> Array32:
    """The same of one user: nothing is left of it beyond ``shade_corners``."""
    cos, sin = np.float32(np.cos(state.headings_rad[row])), np.float32(np.sin(state.headings_rad[row]))
    length, width, height = state.sizes_m[row].tolist()
    x, y = (points_m[..., axis] - np.float32(state.positions_m[row, axis]) for axis in range(2))
    beyond = np.maximum(np.abs(x * cos + y * sin) - np.float32(length / 2 - _INSET_M), np.float32(0.0))
    beside = np.maximum(np.abs(y * cos - x * sin) - np.float32(width / 2 - _INSET_M), np.float32(0.0))
    soft = np.float32(1 / (_SOFT * min(height, _TALLEST_M)) ** 2)
    strength = np.float32(_STRENGTH * min(1.0, width / _WIDE_M))
    return np.asarray(strength * np.exp(np.float32(-0.5) * soft * (beyond * beyond + beside * beside)))


def shade_corners(state: Truth, row: int) -> FloatArray:
    """(4, 3) corners around all ground that a user shades."""
    reach = np.array([(x, y) for x in (-1, 1) for y in (-1, 1)]) * (state.sizes_m[row, :2] / 2 + _REACH_M)
    cos, sin = np.cos(state.headings_rad[row]), np.sin(state.headings_rad[row])
    flat = reach @ np.array([[cos, sin], [-sin, cos]])
    return np.asarray(np.insert(flat, 2, 0.0, axis=1) + state.positions_m[row])
