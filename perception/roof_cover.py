r"""How much of a roof shows, and which of its ends is hidden: under a bridge, or beyond the image's border.

::

         bridge              What covers a vehicle stands still, so it hides nothing that showed a frame ago. A roof
       +--------+            that is too short now has, between one frame and the next,
    +--|        |            either its front under something: the end that shows there did not go back, or
    |  |        |            its rear: the end that shows there did not go ahead.
    +--|        |
       +--------+            And the end that is hidden stays hidden until the other side of the cover shows.
"""

import cv2
import numpy as np

from contracts import BoolArray, FloatArray, ImageArray, IntArray
from perception.roof_window import BACK, FORTH, MARGIN_PX, RoofPose

SAME_COLOUR = 0.15  # by which the direction of a roof's colour may change from fit to fit
COVERED_PX = 1.0  # by which a roof does not become shorter from one frame to the next
SHOWN_SLACK_PX = 2.5  # what ``shown_part`` may miss of a whole roof's length
MOVING_PX = 2.0  # by which what covers a roof may move after all: its edge is soft, a shadow wanders
_BRIGHTNESS = 0.72, 1.4  # of the roof's; a wall is darker
_FULL = 0.8  # of the most pixels of the roof in a row or a column, from which it is counted
_OUTWARD = np.array([(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)])  # the image's left, upper, right, lower border


def same_colour(colour: FloatArray, known: FloatArray) -> BoolArray:
    """(...) whether colours (..., 3) differ from known ones (..., 3) in brightness only."""
    return np.asarray(np.linalg.norm(_unit(colour) - _unit(known), axis=-1) <= SAME_COLOUR)


def _unit(colour: FloatArray) -> FloatArray:
    length = np.asarray(np.linalg.norm(colour, axis=-1, keepdims=True), np.float64)
    return np.asarray(colour / np.maximum(length, 1.0))


def within_border(image: ImageArray, pose: RoofPose) -> tuple[RoofPose, BoolArray]:
    """What of a roof lies within the image, with a margin, and the sides (4,) that the border hides.

    For each border that it crosses one side is given up: that without which most is left. Of a roof that lies outside
    nothing is left: a size is negative.
    """
    last_u, last_v = (float(n - 1) for n in image.shape[1::-1])
    hidden = np.zeros(4, np.bool_)
    for outward, limit in zip(_OUTWARD, (0.0, 0.0, last_u, last_v), strict=True):
        room, lean = limit - float(outward @ pose.centre_px), pose.axes @ outward
        taken = np.abs(lean) * (pose.size_px / 2 + MARGIN_PX)  # (2,) of the room, by each axis
        if taken.sum() <= room:
            continue
        reach = np.minimum((room - taken[::-1]) / np.maximum(np.abs(lean), 1e-9), pose.size_px / 2)
        axis = int(np.argmax(reach / pose.size_px))
        low, high = -pose.size_px / 2, pose.size_px / 2
        if lean[axis] > 0:
            high[axis], hidden[FORTH[axis]] = reach[axis], True
        else:
            low[axis], hidden[BACK[axis]] = -reach[axis], True
        pose = pose.cut(low, high)
    return pose, hidden


def shown_part(image: ImageArray, pose: RoofPose, colours: FloatArray, beyond_px: FloatArray) -> RoofPose | None:
    """The largest rectangle of the roof's colour, along the axes of where it is expected, to a pixel or so.

    colours: (4, 3) BGR of the roof at its sides; a lamp that is mirrored in it makes them differ.
    beyond_px: (4,) by which it may reach beyond the expected sides, at the risk that a bright wall is taken for a roof.
    """
    lowest, highest = -pose.size_px / 2 - beyond_px[BACK], pose.size_px / 2 + beyond_px[FORTH]
    half = np.ceil(np.maximum(-lowest, highest)).astype(int) + 1
    origin = pose.centre_px - half @ pose.axes
    window = cv2.warpAffine(
        image,
        np.column_stack([pose.axes.T, origin]),
        (2 * int(half[0]) + 1, 2 * int(half[1]) + 1),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
    )
    soft = np.asarray(cv2.blur(window, (3, 3)), np.float64)
    usual = _across(colours, pose.size_px, half)
    brightness = np.linalg.norm(soft, axis=2) / np.maximum(np.linalg.norm(usual, axis=2), 1.0)
    alike = same_colour(soft, usual) & (brightness >= _BRIGHTNESS[0]) & (brightness <= _BRIGHTNESS[1])
    left, right = _longest_run(alike.sum(axis=0))
    above, below = _longest_run(alike[:, left : right + 1].sum(axis=1))
    low = np.maximum(np.array([left, above]) - half - 0.5, lowest)
    high = np.minimum(np.array([right, below]) - half + 0.5, highest)
    return pose.cut(low, high) if (high > low).all() else None


def _across(colours: FloatArray, size_px: FloatArray, half_px: IntArray) -> FloatArray:
    """(H, W, 3) colours at the pixels of a window round a roof, which change evenly from side to side (4, 3)."""
    along, across = (np.clip(np.arange(-h, h + 1) / size, -0.5, 0.5) for h, size in zip(half_px, size_px, strict=True))
    changing = along[None, :, None] * (colours[1] - colours[3]) + across[:, None, None] * (colours[2] - colours[0])
    return np.asarray(colours.mean(axis=0) + changing)


def covered_sides(
    part: RoofPose, missing_px: FloatArray, last: RoofPose, last_hidden: BoolArray, known: BoolArray
) -> BoolArray | None:
    """(4,) which sides of a roof are hidden, when ``part`` of it shows; None if that is not clear.

    missing_px: (2,) by how much the part is too short. last: what showed of the roof before, and which sides (4,) were
    hidden then. known: (4,) sides of which it is known that they are hidden now.
    """
    hidden = known.copy()
    for axis in np.flatnonzero((missing_px > COVERED_PX) & ~known[FORTH] & ~known[BACK]):
        side = _covered_side(part, last, last_hidden, int(axis))
        if side is None:
            return None
        hidden[side] = True
    return hidden


def _covered_side(part: RoofPose, last: RoofPose, last_hidden: BoolArray, axis: int) -> int | None:
    forth, back = FORTH[axis], BACK[axis]
    half, last_half = part.size_px[axis] / 2, last.size_px[axis] / 2
    last_middle = float((last.centre_px - part.centre_px) @ part.axes[axis])  # along the axis, from what shows now
    if last_hidden[forth] != last_hidden[back]:  # the cover begins at the end that was hidden
        edge = last_middle + (last_half if last_hidden[forth] else -last_half)
        return int(forth) if edge > 0 else int(back)
    ahead, behind = half - last_middle - last_half, half + last_middle - last_half  # how far each end went outwards
    if max(ahead, behind) < -MOVING_PX:
        return None
    return int(forth) if ahead > behind else int(back)


def _longest_run(counts: FloatArray) -> tuple[int, int]:
    """First and last place of the longest run of counts near to the largest."""
    full = np.concatenate([[False], counts >= _FULL * max(float(counts.max()), 1.0), [False]])
    begins, ends = np.flatnonzero(full[1:] & ~full[:-1]), np.flatnonzero(full[:-1] & ~full[1:])
    if not len(begins):
        return 0, -1
    longest = int(np.argmax(ends - begins))
    return int(begins[longest]), int(ends[longest]) - 1
