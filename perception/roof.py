"""The roof of a vehicle, measured to a fraction of a pixel.

A box seen from above shows its roof and, towards the point below the camera, up to two walls of the same hue. The roof
is therefore sought as an even brightness, then its four sides are measured one by one with calipers across them.
"""

from dataclasses import dataclass

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
THINNING = 2  # of the pixels that brightness is fitted to
LEAST_PIXELS = 8
ROUNDS = 3  # of sampling and line fitting; fewer where one ...
NEAR_PX = 1.0  # moves no end of a side by more than this
FITS = 2  # of the edge model; the second from where the first ended, if that moved by more than ...
SETTLED_PX = 0.7
WALL_EVIDENCE = 3.0  # a wall is believed if it lowers the cost of the fit by more than this
ODD_TIMES, ODD_SHARE = 3.0, 0.15  # a caliper is odd beyond so many times the usual oddness, and share of the contrast
CROSSING_REACH_PX = 4.0
ON_LINE_PX = 0.8  # crossings so near to the line belong to it
_T_PX = np.arange(-REACH_PX, REACH_PX + 0.5)


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
        """(2,) where the lines through the middles of opposite sides meet."""
        middles = (self.quad_px + np.roll(self.quad_px, -1, axis=0)) / 2
        return np.asarray(middles.mean(axis=0))

    def shifted(self, by_px: FloatArray | IntArray) -> "Roof":
        """The same roof, seen from an origin that lies ``by_px`` (2,) before this one."""
        return Roof(self.quad_px + by_px, self.sides_measured, self.walls_px)

    def turned(self) -> "Roof":
        """The same roof with its sides counted from the next one on, so that the axes change their names."""
        sides = np.roll(np.arange(4), -1)
        return Roof(self.quad_px[sides], self.sides_measured[sides], self.walls_px[sides])

    @property
    def axes(self) -> FloatArray:
        """(2, 2) unit vectors along the long and the short side; corner 2 is forward in both."""
        sides = np.roll(self.quad_px, -1, axis=0) - self.quad_px
        both = np.array([sides[0] - sides[2], sides[1] - sides[3]])
        return np.asarray(both / np.linalg.norm(both, axis=1, keepdims=True))

    @property
    def ends_measured(self) -> BoolArray:
        """(2, 2) whether the backward and the forward end of each axis was seen as an edge."""
        return np.asarray(self.sides_measured[[[3, 1], [0, 2]]])

    @property
    def size_px(self) -> tuple[float, float]:
        """Long and short side."""
        lengths = np.linalg.norm(np.roll(self.quad_px, -1, axis=0) - self.quad_px, axis=1)
        return float(lengths[0] + lengths[2]) / 2, float(lengths[1] + lengths[3]) / 2


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
        plane = np.linalg.lstsq(design.T @ design, brightness[even] @ design, rcond=None)[0]
        even = np.abs(brightness - places @ plane) < EVEN
    return _largest_rectangle(mask & _even(image, colour, plane))


def _even(image: ImageArray, colour: FloatArray, plane: FloatArray) -> ImageArray:
    """(H, W) 1 where the brightness, ``colour`` (3,) times a pixel, is nearly that of the plane (3,) of u, v, 1."""
    brightness = cv2.transform(image.astype(np.float32), colour[None])  # (H, W)
    height, width = image.shape[:2]
    expected = (np.arange(height) * plane[1] + plane[2])[:, None] + np.arange(width) * plane[0]
    return np.asarray(np.abs(brightness - expected) < EVEN, np.uint8)


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
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        return _lines_of(_meets(middles, directions))

    @property
    def along_px(self) -> FloatArray:
        """(4, C) places of the calipers along each side, from its middle."""
        return np.linspace(-SIDE_SHARE / 2, SIDE_SHARE / 2, CALIPERS)[None, :] * self.lengths[:, None]

    @property
    def corners_px(self) -> FloatArray:
        return _meets(self.middles, self.directions)


def _lines_of(quad_px: FloatArray) -> _Lines:
    sides = np.roll(quad_px, -1, axis=0) - quad_px
    lengths = np.linalg.norm(sides, axis=1)
    directions = sides / lengths[:, None]
    normals = np.stack([directions[:, 1], -directions[:, 0]], axis=1)
    middles = quad_px + sides / 2
    outward = ((middles - quad_px.mean(axis=0)) * normals).sum(axis=1, keepdims=True)
    return _Lines(middles, directions, normals * np.sign(outward), lengths)


def _meets(points: FloatArray, directions: FloatArray) -> FloatArray:
    """Corners (4, 2): where each line meets the one before it, so that side k runs from corner k to k + 1."""
    p, d = np.roll(points, 1, axis=0), np.roll(directions, 1, axis=0)
    gap = points - p
    along = (gap[:, 0] * directions[:, 1] - gap[:, 1] * directions[:, 0]) / (
        d[:, 0] * directions[:, 1] - d[:, 1] * directions[:, 0]
    )
    return np.asarray(p + along[:, None] * d)


def _profiles(pixels: NDArray[np.float32], lines: _Lines) -> tuple[FloatArray, BoolArray]:
    """Colours (4, C, T, 3) along C calipers across each side, and which calipers (4, C) lie inside the image."""
    foot = lines.middles[:, None] + lines.along_px[..., None] * lines.directions[:, None]  # (4, C, 2)
    places = foot[:, :, None] + _T_PX[None, None, :, None] * lines.normals[:, None, None]  # (4, C, T, 2)
    u, v = np.moveaxis(places.reshape(4 * CALIPERS, len(_T_PX), 2).astype(np.float32), -1, 0)
    sampled = cv2.remap(pixels, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    height, width = pixels.shape[:2]
    near = places[:, :, np.abs(_T_PX) <= 3]
    inside = ((near >= 0) & (near <= (width - 1, height - 1))).all(axis=(2, 3))
    return sampled.reshape(4, CALIPERS, len(_T_PX), 3).astype(np.float64), np.asarray(inside)


def _crossings(profiles: FloatArray, inside: BoolArray, counted: BoolArray) -> FloatArray:
    """(4, C) offset outwards at which each caliper leaves the roof, to half a pixel or so; NaN outside the image."""
    typical = _mean(profiles, counted)  # (4, T, 3)
    roof = typical[:, _T_PX <= -3].mean(axis=1)[:, None, None]  # (4, 1, 1, 3)
    beyond = typical[:, (_T_PX >= 2) & (_T_PX <= 4)].mean(axis=1)[:, None, None]
    axis = roof - beyond
    span = np.maximum((axis**2).sum(axis=-1), 1.0)  # (4, 1, 1)
    near = np.abs(_T_PX) <= CROSSING_REACH_PX
    share = ((profiles[:, :, near] - beyond) * axis).sum(axis=-1) / span  # (4, C, T) 1 on the roof, 0 beyond
    falling = np.minimum.accumulate(np.clip(share, 0.0, 1.0), axis=-1)
    return np.where(inside, falling.sum(axis=-1) - CROSSING_REACH_PX - 0.5, np.nan)


def _alike(profiles: FloatArray, counted: BoolArray) -> BoolArray:
    """(4, C) which calipers show the roof and its edge as most of their side do: not those that something covers."""
    near = profiles[:, :, (_T_PX >= -CROSSING_REACH_PX) & (_T_PX <= 0)]  # (4, C, T, 3)
    usual = _mean(near, counted)
    contrast = np.linalg.norm(usual[:, 0] - usual[:, -1], axis=1)  # (4,)
    for _ in range(2):
        oddness = np.linalg.norm(near - usual[:, None], axis=-1).max(axis=-1)  # (4, C)
        typical = _median(oddness, counted)
        kept = counted & (oddness <= np.maximum(ODD_TIMES * typical, ODD_SHARE * contrast)[:, None])
        usual = _mean(near, kept)
    return np.asarray(kept)


def _mean(profiles: FloatArray, counted: BoolArray) -> FloatArray:
    """(4, T, 3) mean over the calipers that count; over all of a side where none does."""
    weights = (counted | ~counted.any(axis=1, keepdims=True)).astype(np.float64)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray(np.einsum("sc,sctb->stb", weights, profiles))


def _robust_line(along_px: FloatArray, offsets_px: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Offset (4,) at the middle and slope (4,) of each side's crossings (4, C), and which of them lie on that line.

    Repeated medians (Siegel 1982) bear it when something covers almost half of a side; least squares over the
    crossings near that line then make it precise.
    """
    valid = np.isfinite(offsets_px)
    y = np.where(valid, offsets_px, 0.0)
    run = along_px[:, None, :] - along_px[:, :, None]  # (4, C, C)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = (y[:, None, :] - y[:, :, None]) / run
    paired = valid[:, None, :] & valid[:, :, None] & (run != 0)
    slope = _median(_median(slopes, paired), valid)
    offset = _median(y - slope[:, None] * along_px, valid)
    kept = valid & (np.abs(y - offset[:, None] - slope[:, None] * along_px) <= ON_LINE_PX)
    weight = kept.astype(np.float64)
    total = np.maximum(weight.sum(axis=1), 1.0)
    mean_x, mean_y = (weight * along_px).sum(axis=1) / total, (weight * y).sum(axis=1) / total
    x = along_px - mean_x[:, None]
    slope = (weight * x * y).sum(axis=1) / np.maximum((weight * x**2).sum(axis=1), 1.0)
    return mean_y - slope * mean_x, slope, kept


def _median(values: FloatArray, counted: BoolArray) -> FloatArray:
    """Median over the last axis of the values that count; 0 where none does."""
    ranked = np.sort(np.where(counted, values, np.inf), axis=-1)
    middle = np.minimum(counted.sum(axis=-1, keepdims=True) // 2, values.shape[-1] - 1)
    return np.where(counted.any(axis=-1), np.take_along_axis(ranked, middle, axis=-1)[..., 0], 0.0)
