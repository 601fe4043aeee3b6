"""Paint on the road, found in an image: where it is, and to a fraction of a pixel where strokes and edges run.

Paint is brighter than the asphalt around it in its brightest channel, be it white or yellow, whatever the light.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import BoolArray, FloatArray, Frame, ImageArray, InputError
from contracts.arrays import freeze

_LEAST_CONTRAST = 18.0  # levels between paint and asphalt
_STEP_PX = 0.5  # between samples of a profile
_BEYOND_PX = 3.0  # asphalt that must show beside a stroke
_FLANK = 4  # samples to either side of a stroke that its middle is reckoned from
_WIDTH_RATIO, _WIDTH_SLACK_PX = 1.6, 1.5
_CORNER_WINDOW_PX, _CORNER_DARK, _CORNER_EVEN = 4, 35.0, 0.04


@dataclass(frozen=True, eq=False)
class Found:
    """What was looked for at N places. pixels: (N, 2), NaN where ``seen`` (N,) is False."""

    pixels: FloatArray
    seen: BoolArray

    def __post_init__(self) -> None:
        freeze(self, "pixels", shape=(None, 2), finite=False)
        freeze(self, "seen", shape=(len(self.pixels),), dtype=np.bool_)


def still_picture(frames: Sequence[Frame]) -> ImageArray:
    """What stands still before a camera: the median of its frames, (H, W, 3) BGR. InputError without any."""
    if not frames:
        raise InputError("no frame was given to look for the road in")
    if len(frames) == 1:
        return frames[0].image
    return np.median([frame.image for frame in frames], axis=0).astype(np.uint8)


def brightness(image: ImageArray) -> NDArray[np.float32]:
    """The brightest channel, (H, W) levels: white and yellow paint look alike in it."""
    return np.asarray(image.max(axis=2), np.float32)


def strokes_across(
    light: NDArray[np.float32],
    places_px: FloatArray,
    normals: FloatArray,
    widths_px: FloatArray,
    reach_px: FloatArray,
    *,
    uneven: float,
) -> Found:
    """The middle of a bright stroke across each of N places.

    places_px, normals: (N, 2) where a stroke is expected and the unit vector across it. widths_px: (N,) its width.
    reach_px: (N,) how far to either side it may lie. A stroke must be as wide as expected, with asphalt on both sides.
    uneven: how differently bright the two sides may be, over the stroke's height: what is bright or dark beside a
        stroke draws its middle to one side.
    """
    pixels = np.full((len(places_px), 2), np.nan)
    for row, (place, normal, width, reach) in enumerate(zip(places_px, normals, widths_px, reach_px, strict=True)):
        half = float(reach + width / 2 + _BEYOND_PX)
        offsets, profile = _profile(light, place, normal, half)
        low = float(np.median(profile))
        found = _stroke(offsets, profile, low, width=float(width), reach=float(reach), uneven=uneven)
        if found is not None:
            pixels[row] = place + found * normal
    return Found(pixels, np.isfinite(pixels[:, 0]))


def edges_across(light: NDArray[np.float32], places_px: FloatArray, normals: FloatArray, reach_px: FloatArray) -> Found:
    """The edge of paint across each of N places; ``normals`` (N, 2) point from the paint to the asphalt."""
    pixels = np.full((len(places_px), 2), np.nan)
    for row, (place, normal, reach) in enumerate(zip(places_px, normals, reach_px, strict=True)):
        offsets, profile = _profile(light, place, normal, float(reach + _BEYOND_PX))
        found = _edge(offsets, profile, float(reach))
        if found is not None:
            pixels[row] = place + found * normal
    return Found(pixels, np.isfinite(pixels[:, 0]))


def corners_near(light: NDArray[np.float32], places_px: FloatArray, reach_px: FloatArray) -> Found:
    """The corner of paint near each of N places: where all gradients around point past it (Foerstner 1987)."""
    pixels = np.full((len(places_px), 2), np.nan)
    height, width = light.shape
    margin = 2 * _CORNER_WINDOW_PX + 2
    for row, (place, reach) in enumerate(zip(places_px, reach_px, strict=True)):
        if not (margin < place[0] < width - margin and margin < place[1] < height - margin):
            continue
        corner = place.astype(np.float32).reshape(1, 1, 2)
        window = (_CORNER_WINDOW_PX, _CORNER_WINDOW_PX)
        criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.005)
        moved = cv2.cornerSubPix(light, corner, window, (-1, -1), criteria).reshape(2).astype(np.float64)
        away = np.hypot(*(moved - place))  # exactly 0 where the search ran out of its window
        if 0.0 < away <= reach and _is_corner(light, moved):
            pixels[row] = moved
    return Found(pixels, np.isfinite(pixels[:, 0]))


def _profile(
    light: NDArray[np.float32], place: FloatArray, normal: FloatArray, half_px: float
) -> tuple[FloatArray, FloatArray]:
    offsets = np.arange(-half_px, half_px + _STEP_PX / 2, _STEP_PX)
    along = np.array([-normal[1], normal[0]])
    lanes = [place + offsets[:, None] * normal + shift * along for shift in (-1.0, 0.0, 1.0)]  # noise averages out
    sampled = [
        cv2.remap(
            light,
            lane[:, 0].astype(np.float32),
            lane[:, 1].astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        ).reshape(-1)
        for lane in lanes
    ]
    return offsets, np.mean(sampled, axis=0).astype(np.float64)


def _stroke(
    offsets: FloatArray, profile: FloatArray, low: float, *, width: float, reach: float, uneven: float
) -> float | None:
    """Where the only stroke of the right width has its middle; None where there is none, or more than one."""
    low = min(low, float(np.percentile(profile, 30)))
    high = float(profile.max())
    if high - low < _LEAST_CONTRAST:
        return None
    above = profile > 0.5 * (low + high)
    starts, stops = _runs(above)
    middles = []
    for start, stop in zip(starts, stops, strict=True):
        size = (stop - start) * _STEP_PX
        if start == 0 or stop == len(profile):
            continue
        if width / _WIDTH_RATIO - _WIDTH_SLACK_PX <= size <= width * _WIDTH_RATIO + _WIDTH_SLACK_PX:
            begin, end = max(0, start - _FLANK), min(len(profile), stop + _FLANK)
            left, right = float(profile[begin:start].min()), float(profile[stop:end].min())
            if abs(left - right) > uneven * (high - max(left, right)):
                return None
            weight = np.maximum(profile[begin:end] - low - 0.1 * (high - low), 0.0)
            middles.append(float((weight * offsets[begin:end]).sum() / weight.sum()))
    near = [middle for middle in middles if abs(middle) <= reach]
    return near[0] if len(near) == 1 and len(middles) == 1 else None


def _edge(offsets: FloatArray, profile: FloatArray, reach: float) -> float | None:
    """Where bright becomes dark, half way; None where it does not do so once."""
    inside, outside = float(profile[:4].mean()), float(profile[-4:].mean())
    if inside - outside < _LEAST_CONTRAST:
        return None
    middle = 0.5 * (inside + outside)
    crossing = np.flatnonzero((profile[:-1] > middle) & (profile[1:] <= middle))
    if len(crossing) != 1:
        return None
    k = int(crossing[0])
    share = (profile[k] - middle) / (profile[k] - profile[k + 1])
    at = float(offsets[k] + share * _STEP_PX)
    return at if abs(at) <= reach else None


def _is_corner(light: NDArray[np.float32], place: FloatArray) -> bool:
    """Whether light changes in both directions around a place, and by as much as paint does."""
    u, v = np.rint(place).astype(int).tolist()
    reach = _CORNER_WINDOW_PX
    patch = light[v - reach : v + reach + 1, u - reach : u + reach + 1]
    if patch.shape != (2 * reach + 1, 2 * reach + 1) or np.ptp(patch) < _CORNER_DARK:
        return False
    by_v, by_u = np.gradient(patch)
    tensor = np.array([[(by_u**2).sum(), (by_u * by_v).sum()], [(by_u * by_v).sum(), (by_v**2).sum()]])
    least, most = np.linalg.eigvalsh(tensor)
    return bool(least > _CORNER_EVEN * most)


def _runs(above: BoolArray) -> tuple[list[int], list[int]]:
    change = np.diff(np.concatenate([[0], above.astype(np.int8), [0]]))
    return np.flatnonzero(change == 1).tolist(), np.flatnonzero(change == -1).tolist()
