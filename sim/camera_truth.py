"""What a camera sees of the truth: boxes, visible shares and centres, through its lens as it is."""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from contracts import Camera, FloatArray, ImageArray
from contracts.truth import CameraTruth, Occlusion, Truth
from sim.projection import project
from sim.renderer import Rendered

View = Callable[[Camera, Truth, Rendered], CameraTruth]

_EDGE_POINTS = 9  # along each edge: a lens bends straight edges
_CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (-0.5, 0.5) for x in (-0.5, 0.5)])
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


def camera_truth(camera: Camera, state: Truth, seen: Rendered) -> CameraTruth:
    """The view of ``camera`` on ``state``, whose objects are boxes.

    seen: which object each pixel (H, W) shows, as the lens bends it.
    """
    outlines = outline_points(state)  # (N, P, 3)
    pixels, in_field = project(camera, outlines)
    whole = in_field.all(axis=1)
    n = len(state.ids)
    full, visible, fractions = np.full((n, 4), np.nan), np.full((n, 4), np.nan), np.zeros(n)
    for row in np.flatnonzero(whole).tolist():
        full[row] = extent(pixels[row])
        box, count = visible_part(seen.instances, row, full[row])
        if count:
            visible[row] = box
            fractions[row] = min(1.0, count / max(1, silhouette_pixels(pixels[row])))
    return view_of(camera, state, seen, Visibility(fractions, full, visible))


@dataclass(frozen=True, eq=False)
class Visibility:
    """How much of each object a camera sees; as the fields of ``CameraTruth``."""

    fractions: FloatArray
    full_boxes_px: FloatArray
    visible_boxes_px: FloatArray
    hidden_by: tuple[tuple[Occlusion, ...], ...] = ()


def view_of(camera: Camera, state: Truth, seen: Rendered, found: Visibility) -> CameraTruth:
    """What was found of the objects' visibility, with where the camera has the points of their true boxes."""
    return CameraTruth(
        camera=camera.name,
        index=state.index,
        time_ns=state.time_ns,
        visible_fractions=found.fractions,
        full_boxes_px=found.full_boxes_px,
        visible_boxes_px=found.visible_boxes_px,
        footprints_px=project(camera, state.positions_m)[0],
        roofs_px=project(camera, roof_centres(state))[0],
        footprint_corners_px=project(camera, footprint_corners(state))[0],
        hidden_by=found.hidden_by,
        instances=seen.instances,
    )


def extent(points_px: FloatArray) -> FloatArray:
    """Upright box (4,) around points (P, 2)."""
    return np.concatenate([points_px.min(axis=0), points_px.max(axis=0)])


def roof_centres(state: Truth) -> FloatArray:
    """Centre of each upper face, (N, 3) world."""
    return np.asarray(state.positions_m + state.sizes_m * (0.0, 0.0, 1.0))


def footprint_corners(state: Truth) -> FloatArray:
    """Corners of each footprint, (N, 4, 3) world: rear right, rear left, front right, front left."""
    return box_corners(state)[:, [0, 2, 1, 3]]


def outline_points(state: Truth) -> FloatArray:
    """Points along all twelve edges of every object's box, (N, P, 3) world."""
    share = np.linspace(0.0, 1.0, _EDGE_POINTS)[:, None]
    unit = np.concatenate([_CORNERS[a] * (1 - share) + _CORNERS[b] * share for a, b in _EDGES])  # (P, 3)
    return placed(state, np.broadcast_to(unit, (len(state.ids), *unit.shape)))


def box_corners(state: Truth) -> FloatArray:
    """Corners of each object's box, (N, 8, 3) world."""
    return placed(state, np.broadcast_to(_CORNERS, (len(state.ids), *_CORNERS.shape)))


def placed(state: Truth, unit: FloatArray) -> FloatArray:
    """Points (N, P, 3) of unit boxes, x ahead and y to the left in [-0.5, 0.5], z in [0, 1], in the world."""
    local = unit * state.sizes_m[:, None]  # (N, P, 3)
    cos, sin = np.cos(state.headings_rad)[:, None], np.sin(state.headings_rad)[:, None]
    x, y = local[..., 0], local[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y, local[..., 2]], axis=-1) + state.positions_m[:, None]


def silhouette_pixels(outline_px: FloatArray) -> int:
    """Number of pixel centres inside the convex hull of the projected outline (P, 2), on an image without bounds."""
    corner = np.rint(outline_px.mean(axis=0))  # OpenCV's hull is of single precision: stay near zero
    hull = cv2.convexHull((outline_px - corner).astype(np.float32)).reshape(-1, 2).astype(np.float64)  # (C, 2)
    (u1, v1), (u2, v2) = hull.T, np.roll(hull, -1, axis=0).T
    rows = np.arange(np.ceil(v1.min()), np.floor(v1.max()) + 1)[:, None]  # (R, 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = u1 + (rows - v1) * ((u2 - u1) / (v2 - v1))  # (R, C)
    meets = (np.minimum(v1, v2) <= rows) & (rows <= np.maximum(v1, v2)) & (v1 != v2)
    first = np.where(meets, crossing, np.inf).min(axis=1, initial=np.inf)
    last = np.where(meets, crossing, -np.inf).max(axis=1, initial=-np.inf)
    crossed = first <= last
    return int((np.floor(last[crossed]) - np.ceil(first[crossed]) + 1).sum())


def visible_part(instances: ImageArray, row: int, full_box_px: FloatArray) -> tuple[FloatArray, int]:
    """Upright box (4,) around the pixels of object ``row``, to their outer edges, and their number."""
    height, width = instances.shape
    left, top = np.clip(np.floor(full_box_px[:2]).astype(int) - 2, 0, (width, height))
    right, bottom = np.clip(np.ceil(full_box_px[2:]).astype(int) + 3, 0, (width, height))
    mine = instances[top:bottom, left:right] == row + 1
    columns, rows = np.flatnonzero(mine.any(axis=0)), np.flatnonzero(mine.any(axis=1))
    if not columns.size:
        return np.full(4, np.nan), 0
    box = np.array([left + columns[0] - 0.5, top + rows[0] - 0.5, left + columns[-1] + 0.5, top + rows[-1] + 0.5])
    return box, int(mine.sum())
