"""How far pixels that were picked on lines of the map lie from the lines' images."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from contracts import Camera, FloatArray, IntArray
from georef.mixture import Observed
from georef.picks import LinePicks
from georef.projection import Projection, project_with_derivatives, rays

_STEPS, _TOLERANCE = 12, 1e-12


def across_lines(camera: Camera, by_free: FloatArray, lines: LinePicks) -> Observed:
    """Each pixel's distance from the nearest place of its line's image, positive to the right of the line's course.

    by_free: (15, p) how the camera's parameters move with those that are fitted.
    The nearest place slides along the line as the camera moves; being the nearest, that changes the distance only to
    second order, and the derivative is that of the place held.
    """
    stretches = _Stretches.of(lines)
    seen = _nearest(camera, stretches)
    along = np.einsum("nij,nj->ni", seen.by_point, stretches.courses)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    gap = seen.pixels - stretches.pixels
    distance = np.nan_to_num(np.linalg.norm(gap, axis=1), nan=np.inf)
    bounds = np.searchsorted(stretches.owners, np.arange(len(lines) + 1))
    best = bounds[:-1] + [int(distance[a:b].argmin()) for a, b in pairwise(bounds)]
    normals = across[best]
    by_place = np.einsum("ni,nij->nj", normals, seen.by_point[best])
    return Observed(
        np.einsum("ni,ni->n", normals, gap[best])[:, None],
        (normals[:, None] @ seen.by_parameters[best]) @ by_free,
        (lines.sigmas_m**2 * np.nan_to_num(np.einsum("nj,nj->n", by_place, by_place)))[:, None, None],
    )


@dataclass(frozen=True, eq=False)
class _Stretches:
    """Every straight stretch of every pixel's line.

    owners: (S,) number of the pixel, ascending. pixels: (S, 2). starts, courses: (S, 3) and the way to its end.
    least, most: (S,) shares of the way within which a place belongs to it; open at the ends of the line.
    """

    owners: IntArray
    pixels: FloatArray
    starts: FloatArray
    courses: FloatArray
    least: FloatArray
    most: FloatArray

    @classmethod
    def of(cls, lines: LinePicks) -> "_Stretches":
        counts = [len(line) - 1 for line in lines.lines_m]
        owners = np.repeat(np.arange(len(lines)), counts)
        number = np.concatenate([np.arange(count) for count in counts])
        return cls(
            owners.astype(np.int64),
            lines.pixels[owners],
            np.concatenate([line[:-1] for line in lines.lines_m]),
            np.concatenate([np.diff(line, axis=0) for line in lines.lines_m]),
            np.where(number == 0, -np.inf, 0.0),
            np.where(number == np.repeat(counts, counts) - 1, np.inf, 1.0),
        )


def _nearest(camera: Camera, stretches: _Stretches) -> Projection:
    """Image of each stretch's place nearest to its pixel; NaN where the stretch is not before the camera.

    Gauss-Newton steps in the share of the way, from the place nearest to the pixel's ray.
    """
    directions, _ = rays(camera, stretches.pixels)
    courses, from_camera = stretches.courses, stretches.starts - camera.pose.position_m
    beside = courses - np.einsum("ni,ni->n", courses, directions)[:, None] * directions
    with np.errstate(divide="ignore", invalid="ignore"):
        share = -np.einsum("ni,ni->n", beside, from_camera) / np.einsum("ni,ni->n", beside, courses)
    share = np.clip(share, stretches.least, stretches.most)
    for _ in range(_STEPS):
        seen = project_with_derivatives(camera, stretches.starts + share[:, None] * courses)
        along = np.einsum("nij,nj->ni", seen.by_point, courses)
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.einsum("ni,ni->n", seen.pixels - stretches.pixels, along) / np.einsum("ni,ni->n", along, along)
        moved = np.clip(share - step, stretches.least, stretches.most)
        change = np.abs(np.nan_to_num(moved - share)).max(initial=0.0)
        share = moved
        if change < _TOLERANCE:
            break
    return project_with_derivatives(camera, stretches.starts + share[:, None] * courses)
