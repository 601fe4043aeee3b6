"""One channel out of three: the mixture of blue, green and red in which a target differs most from its surroundings."""

import numpy as np

from contracts import BoolArray, ImageArray
from perception.correlation import Float32Array

GREY: Float32Array = np.array([[0.114, 0.587, 0.299]], np.float32)  # ITU-R BT.601, the weights of OpenCV's BGR2GRAY
_NOISE = 2.0  # deviation, grey levels, that every colour has at least


def colour_axis(window: ImageArray, target: BoolArray, surroundings: BoolArray) -> Float32Array:
    """(1, 3) weights of B, G, R, of unit length: Fisher's linear discriminant (1936).

    window: (H, W, 3). target, surroundings: (H, W) which pixels belong to either.
    A shadow or a highlight spreads both along brightness, so the axis turns away from it, towards hue; where hue tells
    nothing, as with a grey vehicle, it falls back on brightness. Grey's weights where the means are equal.
    """
    inside, outside = window[target].astype(np.float64), window[surroundings].astype(np.float64)  # (n, 3), (m, 3)
    scatter = np.cov(inside, rowvar=False) + np.cov(outside, rowvar=False) + _NOISE**2 * np.eye(3)
    axis = np.linalg.solve(scatter, inside.mean(axis=0) - outside.mean(axis=0))
    length = float(np.linalg.norm(axis))
    return (axis / length)[None].astype(np.float32) if length > 0 else GREY
