"""The roof of a vehicle, measured to a fraction of a pixel.

A box seen from above shows its roof and, towards the point below the camera, up to two walls of the same hue. The roof
is therefore sought as an even brightness, then its four sides are measured one by one with calipers across them.
"""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray, ImageArray, IntArray
from perception.edge_profile import fit_edges

REACH_PX = 6.0  # calipers look so far to either side of the expected edge
CALIPERS = 24  # across each side
STRAIGHT_PX = 2.0  # a straight edge departs from the pixels' outline by no more
LEAST_SIDE_PX = 8.0  # a smaller patch has no sides to measure
SIDE_SHARE = 0.8  # of each side's length that is measured; corners are rounded by blur
EVEN = 0.12  # a pixel of the roof departs from the plane of brightness by less than this share
THINNING = 3  # of the pixels that brightness is fitted to
LEAST_PIXELS = 8
ROUNDS = 3  # of sampling and line fitting; fewer where one ...
NEAR_PX = 1.0  # moves no end of a side by more than this
FITS = 2  # of the edge model; the second from where the first ended, if that moved by more than ...
SETTLED_PX = 0.5
WALL_EVIDENCE = 3.0  # a wall is believed if it lowers the cost of the fit by more than this
ODD_TIMES, ODD_SHARE = 3.0, 0.15  # a caliper is odd beyond so many times the usual oddness, and share of the contrast
CROSSING_REACH_PX = 4.0
ON_LINE_PX = 0.8  # crossings so near to the line belong to it
_T_PX = np.arange(-REACH_PX, REACH_PX + 0.5)
_SEEN_PX = 3.0  # beyond a caliper's foot, that must lie in the image
_SPREAD = np.linspace(-SIDE_SHARE / 2, SIDE_SHARE / 2, CALIPERS)
_NEXT, _BEFORE = np.array([1, 2, 3, 0]), np.array([3, 0, 1, 2])


@dataclass(frozen=True, eq=False)
class Roof:
    """A measured roof; pixels of the whole image.

    quad_px: (4, 2) corners in order round it; the first side, from corner 0 to 1, is a long one.
    sides_measured: (4,) whether each side, from corner k to k + 1, was seen as an edge.
    walls_px: (4,) width of the wall seen beyond each side.
    """

    quad_px: FloatArray
    sides_measured: BoolArray
    walls_px: FloatArray

    @property
    def centre_px(self) -> FloatArray:
        """(2,) mean of the corners, where the lines through the middles of opposite sides meet."""
        return np.asarray(self.quad_px.mean(axis=0))

    def shifted(self, by_px: FloatArray | IntArray) -> "Roof":
        """The same roof, seen from an origin that lies ``by_px`` (2,) before this one."""
        return Roof(self.quad_px + by_px, self.sides_measured, self.walls_px)

    def turned(self) -> "Roof":
        """The same roof with its sides counted from the next one on, so that the axes change their names."""
        return Roof(self.quad_px[_NEXT], self.sides_measured[_NEXT], self.walls_px[_NEXT])

    @property
    def axes(self) -> FloatArray:
        """(2, 2) unit vectors along the long and the short side; corner 2 is forward in both."""
        sides = self.quad_px[_NEXT] - self.quad_px
        both = sides[:2] - sides[2:]
        return np.asarray(both / _length(both)[:, None])

    @property
    def ends_measured(self) -> BoolArray:
        """(2, 2) whether the backward and the forward end of each axis was seen as an edge."""
        return np.asarray(self.sides_measured[[[3, 1], [0, 2]]])

    @property
    def size_px(self) -> tuple[float, float]:
        """Long and short side."""
        a, b, c, d = _length(self.quad_px[_NEXT] - self.quad_px).tolist()
        return (a + c) / 2, (b + d) / 2


def seed_quad(image: ImageArray, mask: ImageArray, outward: FloatArray) -> FloatArray | None:
    """Rough corners (4, 2) of the roof in a window: the even brightness that reaches farthest ``outward``.

    image: (H, W, 3) BGR. mask: (H, W) not 0 where the vehicle's colour is.
    outward: (2,) direction away from the point below the camera; there the silhouette is bounded by the roof.
    """
    rows, columns = np.nonzero(mask[::THINNING, ::THINNING])
    places = np.stack([columns, rows, np.ones_like(rows)], axis=1) * (THINNING, THINNING, 1.0)  # (N, 3)
    colours = image[::THINNING, ::THINNING][rows, columns].astype(np.float64)  # (N, 3)
    distance = places[:, :2] @ outward
    outer = distance >= np.median(distance) if len(distance) else np.zeros(0, np.bool_)
    if outer.sum() < LEAST_PIXELS:
        return None
    colour = np.median(colours[outer], axis=0)
    colour /= colour @ colour
    brightness = colours @ colour
    even = outer & (np.abs(brightness - 1) < EVEN)
    for _ in range(3):
        if even.sum() < LEAST_PIXELS:
            return None
        design = places[even]
        plane = np.linalg.solve(design.T @ design + np.eye(3) * 1e-6, brightness[even] @ design)
        even = np.abs(brightness - places @ plane) < EVEN
    return _largest_rectangle(mask & _even(image, colour, plane))


def _even(image: ImageArray, colour: FloatArray, plane: NDArray[np.floating[Any]]) -> ImageArray:
    """(H, W) 1 where the brightness, ``colour`` (3,) times a pixel, is nearly that of the plane (3,) of u, v, 1."""
    departure = cv2.transform(image.astype(np.float32), colour[None])  # (H, W)
    height, width = image.shape[:2]
    departure -= (np.arange(height) * plane[1] + plane[2]).astype(np.float32)[:, None]
    departure -= (np.arange(width) * plane[0]).astype(np.float32)
    return np.asarray(np.abs(departure) < EVEN, np.uint8)


def _largest_rectangle(mask: ImageArray) -> FloatArray | None:
    """Corners (4, 2) of the rectangle along the longest straight edge of the largest part; first side long.

    Edges on the window's border do not count: there the image ends, not the roof.
    """
    opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    contours, _ = cv2.findContours(opened, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return None
    contour = max(contours, key=cv2.contourArea)
    ends = cv2.approxPolyDP(contour, STRAIGHT_PX, closed=True)[:, 0].astype(np.float64)  # (E, 2)
    edges = np.roll(ends, -1, axis=0) - ends
    last = np.array(mask.shape[::-1]) - 1
    at_border = np.concatenate([ends <= 1, ends >= last - 1], axis=1)  # (E, 4)
    along_border = (at_border & np.roll(at_border, -1, axis=0)).any(axis=1)
    lengths = np.where(along_border, 0.0, np.linalg.norm(edges, axis=1))
    longest = int(np.argmax(lengths))
    if lengths[longest] < LEAST_SIDE_PX:
        return None
    along = edges[longest] / lengths[longest]
    axes = np.array([along, (-along[1], along[0])])
    low, high = (limit(contour[:, 0] @ axes.T, axis=0) for limit in (np.min, np.max))
    if min(high - low) < LEAST_SIDE_PX:
        return None
    corners: FloatArray = np.array([low, (high[0], low[1]), high, (low[0], high[1])]) @ axes
    return corners if high[0] - low[0] >= high[1] - low[1] else np.roll(corners, -1, axis=0)


def measure_roof(image: ImageArray, quad_px: FloatArray, lean_px: FloatArray | None = None) -> Roof:
    """Measure the four sides near a rough quadrangle (4, 2), first side long, corners in order.

    lean_px: (2,) from a point of the roof to the ground below it, where that is known: so wide are the walls.
    """
    pixels = image.astype(np.float32)
    lines = _lines_of(quad_px)
    kept = np.ones((4, CALIPERS), np.bool_)
    for _ in range(ROUNDS):
        profiles, inside = _profiles(pixels, lines)
        offsets, slopes, kept = _robust_line(lines.along_px, _crossings(profiles, inside, kept & inside))
        lines = lines.moved(np.clip(offsets, -2.0, 2.0), np.clip(slopes, -0.1, 0.1))
        if max(np.abs(offsets).max(), np.abs(slopes * lines.lengths / 2).max()) < NEAR_PX:
            break
    expected = None if lean_px is None else np.maximum(lines.normals @ lean_px, 0.0)
    usable, walls = np.ones(4, np.bool_), np.zeros(4)
    for _ in range(FITS):
        profiles, inside = _profiles(pixels, lines)
        alike = _alike(profiles, kept & inside)
        usable = alike.sum(axis=1) >= CALIPERS // 3
        edges, walls = _roof_ends(_mean(profiles, alike), expected)
        edges = np.where(usable, edges, 0.0)
        lines = lines.moved(edges, np.zeros(4))
        if np.abs(edges).max() < SETTLED_PX:
            break
    return Roof(lines.corners_px, usable, walls)


def _roof_ends(profiles: FloatArray, walls_px: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Where the roof ends (4,) and how wide the wall beyond it is (4,), from one mean profile for each side.

    A strip of shadow on the side away from the camera looks like a narrow wall, so any side may have one.
    """
    fits = fit_edges(profiles, _T_PX, walls_px)
    pick = (fits.costs[0] - fits.costs[1] > WALL_EVIDENCE).astype(np.int64), np.arange(4)
    return fits.edges_px[pick], fits.walls_px[pick]


@dataclass(frozen=True, eq=False)
class _Lines:
    """Four sides: middles (4, 2), unit directions (4, 2), unit outward normals (4, 2), lengths (4,)."""

    middles: FloatArray
    directions: FloatArray
    normals: FloatArray
    lengths: FloatArray

    def moved(self, offsets_px: FloatArray, slopes: FloatArray) -> "_Lines":
        """Shifted outwards by ``offsets_px`` (4,) and turned by ``slopes`` (4,), px outwards per px along."""
        middles = self.middles + offsets_px[:, None] * self.normals
        directions = self.directions + slopes[:, None] * self.normals
        return _lines_of(_meets(middles, directions))

    @property
    def along_px(self) -> FloatArray:
        """(4, C) places of the calipers along each side, from its middle."""
        return _SPREAD * self.lengths[:, None]

    @property
    def corners_px(self) -> FloatArray:
        return _meets(self.middles, self.directions)


def _lines_of(quad_px: FloatArray) -> _Lines:
    sides = quad_px[_NEXT] - quad_px
    lengths = _length(sides)
    directions = sides / lengths[:, None]
    diagonals = quad_px[2:] - quad_px[:2]  # (2, 2)
    turning = diagonals[0, 0] * diagonals[1, 1] - diagonals[0, 1] * diagonals[1, 0]
    normals = directions[:, ::-1] * ((1.0, -1.0) if turning > 0 else (-1.0, 1.0))
    return _Lines(quad_px + sides / 2, directions, normals, lengths)


def _meets(points: FloatArray, directions: FloatArray) -> FloatArray:
    """Corners (4, 2): where each line meets the one before it, so that side k runs from corner k to k + 1."""
    p, d = points[_BEFORE], directions[_BEFORE]
    gap = points - p
    along = (gap[:, 0] * directions[:, 1] - gap[:, 1] * directions[:, 0]) / (
        d[:, 0] * directions[:, 1] - d[:, 1] * directions[:, 0]
    )
    return np.asarray(p + along[:, None] * d)


def _profiles(pixels: NDArray[np.float32], lines: _Lines) -> tuple[FloatArray, BoolArray]:
    """Colours (4, C, T, 3) along C calipers across each side, and which calipers (4, C) lie inside the image."""
    along = lines.along_px
    foot = lines.middles.T[:, :, None] + along * lines.directions.T[:, :, None]  # (2, 4, C)
    across = (lines.normals.T[:, :, None] * _T_PX).astype(np.float32)  # (2, 4, T)
    u, v = (foot.astype(np.float32)[..., None] + across[:, :, None]).reshape(2, 4 * CALIPERS, len(_T_PX))
    sampled = cv2.remap(pixels, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    last = np.array(pixels.shape[1::-1])[:, None, None] - 1 - _SEEN_PX
    inside = ((foot >= _SEEN_PX) & (foot <= last)).all(axis=0)
    return sampled.reshape(4, CALIPERS, len(_T_PX), 3).astype(np.float64), np.asarray(inside)


def _crossings(profiles: FloatArray, inside: BoolArray, counted: BoolArray) -> FloatArray:
    """(4, C) offset outwards at which each caliper leaves the roof, to half a pixel or so; NaN outside the image."""
    typical = _mean(profiles, counted)  # (4, T, 3)
    roof = typical[:, _T_PX <= -3].mean(axis=1)[:, None, None]  # (4, 1, 1, 3)
    beyond = typical[:, (_T_PX >= 2) & (_T_PX <= 4)].mean(axis=1)[:, None, None]
    axis = roof - beyond
    span = np.maximum((axis**2).sum(axis=-1), 1.0)  # (4, 1, 1)
    near = np.abs(_T_PX) <= CROSSING_REACH_PX
    by = axis / span[..., None]
    share = (profiles[:, :, near] @ by[:, 0, 0, :, None][:, None])[..., 0] - (beyond * by).sum(axis=-1)
    falling = np.minimum.accumulate(np.clip(share, 0.0, 1.0), axis=-1)
    return np.where(inside, falling.sum(axis=-1) - CROSSING_REACH_PX - 0.5, np.nan)


def _alike(profiles: FloatArray, counted: BoolArray) -> BoolArray:
    """(4, C) which calipers show the roof and its edge as most of their side do: not those that something covers."""
    near = profiles[:, :, (_T_PX >= -CROSSING_REACH_PX) & (_T_PX <= 0)]  # (4, C, T, 3)
    usual = _mean(near, counted)
    contrast, kept = _length(usual[:, 0] - usual[:, -1]), counted  # (4,), (4, C)
    for _ in range(2):
        oddness = _length(near - usual[:, None]).max(axis=-1)  # (4, C)
        before, limit = kept, ODD_TIMES * _median(oddness, counted)
        kept = counted & (oddness <= np.maximum(limit, ODD_SHARE * contrast)[:, None])
        if (kept == before).all():
            break
        usual = _mean(near, kept)
    return np.asarray(kept)


def _mean(profiles: FloatArray, counted: BoolArray) -> FloatArray:
    """(4, T, 3) mean over the calipers that count; over all of a side where none does."""
    weights = (counted | ~counted.any(axis=1, keepdims=True)).astype(np.float64)
    weights /= weights.sum(axis=1, keepdims=True)
    count = profiles.shape[2]
    return np.asarray((weights[:, None] @ profiles.reshape(4, CALIPERS, count * 3)).reshape(4, count, 3))


def _robust_line(along_px: FloatArray, offsets_px: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Offset (4,) at the middle and slope (4,) of each side's crossings (4, C), and which of them lie on that line.

    Repeated medians (Siegel 1982) bear it when something covers almost half of a side; least squares over the
    crossings near that line then make it precise. Where all crossings lie on one line that is not needed.
    """
    valid = np.isfinite(offsets_px)
    y = np.where(valid, offsets_px, 0.0)
    offset, slope = _line_through(along_px, y, valid)
    kept = valid & (np.abs(y - offset[:, None] - slope[:, None] * along_px) <= ON_LINE_PX)
    if (kept == valid).all():
        return offset, slope, kept
    offset, slope = _median_line(along_px, y, valid)
    kept = valid & (np.abs(y - offset[:, None] - slope[:, None] * along_px) <= ON_LINE_PX)
    return *_line_through(along_px, y, kept), kept


def _line_through(x: FloatArray, y: FloatArray, counted: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Offset (4,) and slope (4,) of the least-squares lines through the points (4, C) that count."""
    weight = counted.astype(np.float64)
    total = np.maximum(weight.sum(axis=1), 1.0)
    mean_x, mean_y = (weight * x).sum(axis=1) / total, (weight * y).sum(axis=1) / total
    away = weight * (x - mean_x[:, None])
    slope = (away * y).sum(axis=1) / np.maximum((away * x).sum(axis=1), 1.0)
    return mean_y - slope * mean_x, slope


def _median_line(x: FloatArray, y: FloatArray, counted: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Offset (4,) and slope (4,) by repeated medians over the points (4, C) that count."""
    run = x[:, None, :] - x[:, :, None]  # (4, C, C)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = (y[:, None, :] - y[:, :, None]) / run
    paired = counted[:, None, :] & counted[:, :, None] & (run != 0)
    slope = _median(_median(slopes, paired), counted)
    return _median(y - slope[:, None] * x, counted), slope


def _length(vectors: FloatArray) -> FloatArray:
    """(...) of vectors (..., D)."""
    return np.asarray(np.sqrt(np.einsum("...d,...d->...", vectors, vectors)))


def _median(values: FloatArray, counted: BoolArray) -> FloatArray:
    """Median over the last axis of the values that count; 0 where none does."""
    ranked = np.sort(np.where(counted, values, np.inf), axis=-1)
    middle = np.minimum(counted.sum(axis=-1, keepdims=True) // 2, values.shape[-1] - 1)
    return np.where(counted.any(axis=-1), np.take_along_axis(ranked, middle, axis=-1)[..., 0], 0.0)
