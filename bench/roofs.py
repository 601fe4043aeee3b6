"""The roofs of the true objects as a camera sees them: marks for training frames and annotations for export."""

import numpy as np

from contracts import Camera, FloatArray
from contracts.truth import Truth
from georef.projection import project

_CORNERS = np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]])  # of length and width, in order round


def roof_quads_px(truth: Truth, camera: Camera) -> FloatArray:
    """(N, 4, 2) corners of each object's roof in the image of ``camera``, in order round it.

    They may lie outside the image; NaN where a corner is behind the camera or beyond the fold of the lens.
    """
    pixels, _ = project(camera, roof_corners_m(truth))
    return pixels


def roof_corners_m(truth: Truth) -> FloatArray:
    """(N, 4, 3) corners of each object's roof in the world, front left first, counter-clockwise from above."""
    along, across = (_CORNERS * truth.sizes_m[:, None, :2]).transpose(2, 0, 1)  # (N, 4) each
    cos, sin = np.cos(truth.headings_rad)[:, None], np.sin(truth.headings_rad)[:, None]
    x = truth.positions_m[:, None, 0] + cos * along - sin * across
    y = truth.positions_m[:, None, 1] + sin * along + cos * across
    z = np.broadcast_to((truth.positions_m[:, 2] + truth.sizes_m[:, 2])[:, None], x.shape)
    return np.stack([x, y, z], axis=-1)  # (N, 4, 3)
