"""What a camera sees of road users: the silhouettes of their bodies, and what hides them."""

from collections.abc import Sequence

import numpy as np

from contracts import BoolArray, Camera, FloatArray
from contracts.truth import CameraTruth, Occlusion, Truth
from sim.body_shapes import Wardrobe
from sim.camera_truth import Visibility, extent, view_of, visible_part
from sim.outlines import covered, hull
from sim.projection import project
from sim.renderer import Rendered, Still

BORDER = "border"
_MOST_PX = (
    4000.0  # a body whose outline reaches farther beyond the image is not drawn alone: it is all around the camera
)
_CENTRES = np.zeros((1, 2))  # where a pixel is looked at, from its centre


def road_camera_truth(camera: Camera, state: Truth, seen: Rendered, wardrobe: Wardrobe) -> CameraTruth:
    """The view of ``camera`` on ``state``; ``seen`` is which user, and which still thing, each pixel shows.

    Boxes are those of the body as it is drawn, which touches all faces of its true box but fills not every corner.
    """
    n = len(state.ids)
    full, visible, fractions = np.full((n, 4), np.nan), np.full((n, 4), np.nan), np.zeros(n)
    hidden: list[tuple[Occlusion, ...]] = [()] * n
    size = camera.intrinsics
    for row in range(n):
        outlines = _outlines(camera, wardrobe.pieces(state, row))
        if outlines is None:
            continue
        full[row] = extent(np.concatenate(outlines))
        if not _meets(full[row], size.width_px, size.height_px):
            continue
        alone, corner = silhouette(outlines, full[row])
        visible[row], count = visible_part(seen.instances, row, full[row])
        fractions[row] = min(1.0, count / max(1, int(alone.sum())))
        hidden[row] = occlusions(alone, corner, row, state.ids, seen)
    return view_of(camera, state, seen, Visibility(fractions, full, visible, tuple(hidden)))


def silhouette(outlines_px: Sequence[FloatArray], box_px: FloatArray) -> tuple[BoolArray, tuple[int, int]]:
    """Pixels whose centres convex outlines (C, 2) cover together, (h, w), and the pixel (u, v) of the first one."""
    left, top = np.floor(box_px[:2]).astype(int).tolist()
    right, bottom = np.ceil(box_px[2:]).astype(int).tolist()
    window = slice(top, bottom + 1), slice(left, right + 1)
    return np.asarray(covered(outlines_px, window, _CENTRES).any(axis=(0, 1))), (left, top)


def occlusions(
    alone: BoolArray, corner: tuple[int, int], row: int, ids: Sequence[str], seen: Rendered
) -> tuple[Occlusion, ...]:
    """What hides object ``row``, the largest share first.

    alone: (h, w) pixels that it would cover alone; corner: (u, v) of the first of them.
    A still thing counts where it stands upright before the object: ``seen.things`` tells it.
    """
    total = int(alone.sum())
    if not total:
        return ()
    height, width = seen.instances.shape
    u, v = corner
    rows, columns = slice(max(0, v), min(height, v + alone.shape[0])), slice(max(0, u), min(width, u + alone.shape[1]))
    inside = alone[rows.start - v : rows.stop - v, columns.start - u : columns.stop - u]
    shares = {BORDER: total - int(inside.sum())}
    here = seen.instances[rows, columns][inside]
    for number, count in enumerate(np.bincount(here, minlength=1).tolist()):
        if number and number != row + 1:
            shares[ids[number - 1]] = count
    if seen.things is not None:
        shares |= _by_still(seen.things, here == 0, inside, (rows, columns))
    found = [Occlusion(by, count / total) for by, count in shares.items() if count]
    return tuple(sorted(found, key=lambda one: (-one.fraction, one.by)))


def _by_still(things: Still, uncovered: BoolArray, inside: BoolArray, window: tuple[slice, slice]) -> dict[str, int]:
    kinds = things.kinds[window][inside][uncovered]
    counts = np.bincount(kinds, minlength=1 + len(things.names))[1:]
    return {name: int(count) for name, count in zip(things.names, counts, strict=True) if name in things.upright}


def _outlines(camera: Camera, pieces_m: Sequence[FloatArray]) -> list[FloatArray] | None:
    """Outline of each piece, (C, 2); None where not all of them lie well ahead of the camera."""
    counts = np.cumsum([len(piece) for piece in pieces_m])[:-1]
    pixels, valid = project(camera, np.concatenate(pieces_m))
    if not valid.all() or np.abs(pixels).max() > _MOST_PX:
        return None
    return [hull(points) for points in np.split(pixels, counts)]


def _meets(box_px: FloatArray, width_px: int, height_px: int) -> bool:
    left, top, right, bottom = box_px
    return bool(right >= 0 and bottom >= 0 and left <= width_px - 1 and top <= height_px - 1)
