"""The yellow control points on the floor, found in the image by their colour.

A disc's centroid is not the image of its centre, but for a disc of 10 mm radius seen from 2.8 m under 20 degrees the
two differ by less than 0.01 px: it is left alone.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import FloatArray, Frame, InputError, IntArray

_FLOOR_LEVEL = 128.0  # grey level that the floor is brought to
_YELLOW_HSV = (np.array([18, 110, 45]), np.array([38, 255, 255]))  # OpenCV's half degrees; pure yellow is 30
_LEAST_AREA_PX = 6
_LARGEST_SIDE_RATIO = 1.8
_LEAST_FILL = 0.55  # area over bounding box: pi / 4 for a disc
_AREA_FACTOR = 2.5  # larger or smaller than the median mark by more than this is another thing
_MARGIN_PX = 3  # of floor round a mark, in which its fading edge lies
_FLOOR = 0.15  # share of a mark's contrast that is still taken for floor and noise


def find_marks(frame: Frame) -> FloatArray:
    """(N, 2) pixels of the yellow marks that lie wholly in the image, in no particular order.

    Colours are judged against the floor's, so that a warm lamp's light on a grey floor is not taken for paint.
    Other small yellow things are found too; ``georef.labelling`` tells them apart by place.
    """
    image = _balanced(frame.image)
    mask = cv2.inRange(cv2.cvtColor(image, cv2.COLOR_BGR2HSV), *_YELLOW_HSV)
    _, _, boxes, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    marks = _disc_like(np.asarray(boxes[1:], dtype=np.int64), mask.shape)  # row 0 is the background
    return np.array([_centroid(image, box) for box in marks]).reshape(-1, 2)


def find_marks_in(frames: Sequence[Frame]) -> FloatArray:
    """Marks averaged over frames of a camera that stands still: (N, 2) those seen in at least half of the frames.

    A mark that moves by more than 2 px from the first frame that shows it counts as another one.
    """
    if not frames:
        raise InputError("no frame was given to find control points in")
    groups: list[list[FloatArray]] = []
    for frame in frames:
        for mark in find_marks(frame):
            near = [group for group in groups if np.hypot(*(group[0] - mark)) < 2.0]
            if near:
                near[0].append(mark)
            else:
                groups.append([mark])
    lasting = [np.median(group, axis=0) for group in groups if 2 * len(group) >= len(frames)]
    return np.array(lasting).reshape(-1, 2)


def _balanced(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The image with its median colour, the floor's, made grey."""
    floor = np.maximum(np.median(image[::4, ::4].reshape(-1, 3), axis=0), 1.0)
    table = np.arange(256)[:, None] * (_FLOOR_LEVEL / floor)  # (256, 3)
    table = np.clip(np.rint(table), 0, 255).astype(np.uint8)
    return np.asarray(cv2.LUT(image, table[None]), dtype=np.uint8)


def _disc_like(boxes: IntArray, shape: tuple[int, ...]) -> IntArray:
    """Rows x, y, width, height, area of components that may be marks: whole, compact, of the usual size."""
    x, y, width, height, area = boxes.T
    whole = (x > 0) & (y > 0) & (x + width < shape[1]) & (y + height < shape[0])
    ratio = np.maximum(width, height) / np.minimum(width, height)
    compact = (ratio < _LARGEST_SIDE_RATIO) & (area >= _LEAST_FILL * width * height) & (area >= _LEAST_AREA_PX)
    boxes = boxes[whole & compact]
    usual = np.median(boxes[:, 4]) if len(boxes) else 0.0
    return boxes[(boxes[:, 4] < _AREA_FACTOR * usual) & (boxes[:, 4] > usual / _AREA_FACTOR)]


def _centroid(image: NDArray[np.uint8], box: IntArray) -> FloatArray:
    """Centroid of the yellowness min(g, r) - b above the floor's, in the component's box and a margin round it."""
    x, y, width, height, _ = (int(n) for n in box)
    left, top = max(x - _MARGIN_PX, 0), max(y - _MARGIN_PX, 0)
    patch = image[top : y + height + _MARGIN_PX, left : x + width + _MARGIN_PX].astype(np.float64)
    yellowness = np.minimum(patch[..., 1], patch[..., 2]) - patch[..., 0]
    edge = np.concatenate([yellowness[0], yellowness[-1], yellowness[:, 0], yellowness[:, -1]])
    floor, peak = np.median(edge), np.percentile(yellowness, 90)
    weight = np.clip(yellowness - floor - _FLOOR * (peak - floor), 0.0, None)
    v, u = np.mgrid[top : top + weight.shape[0], left : left + weight.shape[1]]
    centroid: FloatArray = np.array([(weight * u).sum(), (weight * v).sum()]) / weight.sum()
    return centroid
