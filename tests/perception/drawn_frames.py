"""Frames drawn with supersampling, so that the sub-pixel place of every roof is known exactly.

A vehicle is a box under a camera that looks straight down: its roof quadrangle, its ground quadrangle shifted by the
lean, the walls between them in the roof's hue at other brightness, and a shadow on a textured floor.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np

from contracts import FloatArray, Frame, ImageArray
from perception.learning import LabelledFrame
from perception.view import straight_down

SUPERSAMPLING = 8
LENS_BLUR_PX = 0.5
FOCAL_PX, HEIGHT_M = 827.0, 1.714  # 500 px per metre on a roof 6 cm high, whose walls lean by 3.5 % of the way outwards
COLOURS_BGR = {"blue": (190, 70, 25), "red": (35, 30, 185), "green": (60, 150, 40), "yellow": (20, 170, 200)}


@dataclass(frozen=True)
class Box:
    """A vehicle to draw; ``lean_px`` points from the roof to its footprint, towards the nadir."""

    label: str
    centre_px: tuple[float, float]
    heading_rad: float = 0.0
    size_px: tuple[float, float] = (70.0, 35.0)
    lean_px: tuple[float, float] = (0.0, 0.0)
    shadow_px: tuple[float, float] = (0.0, 0.0)
    wall_gains: tuple[float, float] = (0.6, 0.8)
    colour_bgr: tuple[int, int, int] | None = field(default=None)

    @property
    def roof_quad_px(self) -> FloatArray:
        long, short = self.size_px
        corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) / 2 * (long, short)
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return corners @ np.array([(cos, sin), (-sin, cos)]) + self.centre_px


def floor(rng: np.random.Generator, shape: tuple[int, int] = (360, 640)) -> ImageArray:
    """(H, W, 3) a grey floor with soft texture."""
    coarse = rng.normal(0, 1, (shape[0] // 8 + 1, shape[1] // 8 + 1, 1)).astype(np.float32)
    soft = cv2.resize(coarse, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)[..., None]
    return np.clip(np.array([118.0, 122.0, 126.0]) + 5 * soft, 0, 255).round().astype(np.uint8)


def draw(background: ImageArray, boxes: list[Box], *, gain: float = 1.0) -> ImageArray:
    """The boxes on the background, blurred as by a good lens, everything multiplied by ``gain``."""
    image = background.astype(np.float64)
    for box in boxes:
        _draw_box(image, box)
    image = cv2.GaussianBlur(image, (0, 0), LENS_BLUR_PX)
    return np.clip(image * gain, 0, 255).round().astype(np.uint8)


def frame_of(image: ImageArray, index: int = 0) -> Frame:
    return Frame("west", index, index * 40_000_000, image)


def labelled(image: ImageArray, boxes: list[Box]) -> LabelledFrame:
    quads = np.array([box.roof_quad_px for box in boxes])
    camera = straight_down(FOCAL_PX, HEIGHT_M, (image.shape[1], image.shape[0]))
    n = len(boxes)
    labels = tuple(box.label for box in boxes)
    return LabelledFrame(frame_of(image), camera, labels, quads.reshape(n, 4, 2), np.full(n, 0.06), np.ones(n))


def _draw_box(image: FloatArray, box: Box) -> None:
    roof = box.roof_quad_px
    ground = roof + box.lean_px
    colour = np.array(box.colour_bgr or COLOURS_BGR[box.label], np.float64)
    if any(box.shadow_px):
        both = np.concatenate([ground, ground + box.shadow_px])
        hull = cv2.convexHull(both.astype(np.float32))[:, 0].astype(np.float64)
        _mix(image, hull, lambda pixels: pixels * 0.55)
    for k in range(4):  # nearer walls hide farther ones, so only those on the nadir's side are drawn
        a, b = roof[k], roof[(k + 1) % 4]
        outward = (a + b) / 2 - roof.mean(axis=0)
        if outward @ np.array(box.lean_px) > 0:
            wall = np.array([a, b, b + box.lean_px, a + box.lean_px])
            _mix(image, wall, lambda _, gain=box.wall_gains[k % 2]: colour * gain)
    _mix(image, roof, lambda _: colour)


def _mix(image: FloatArray, polygon: FloatArray, paint) -> None:
    """Paint a polygon, each pixel by its covered share."""
    height, width = image.shape[:2]
    low = np.clip(np.floor(polygon.min(axis=0)).astype(int) - 1, 0, (width, height))
    high = np.clip(np.ceil(polygon.max(axis=0)).astype(int) + 2, 0, (width, height))
    size = high - low
    if (size <= 0).any():
        return
    s = SUPERSAMPLING
    mask = np.zeros((size[1] * s, size[0] * s), np.uint8)
    fine = (polygon - low + 0.5) * s - 0.5
    cv2.fillPoly(mask, [np.round(fine * 256).astype(np.int32)], 1, shift=8)
    share = mask.reshape(size[1], s, size[0], s).mean(axis=(1, 3))[..., None]
    window = image[low[1] : high[1], low[0] : high[0]]
    window[:] = share * paint(window) + (1 - share) * window


def random_boxes(rng: np.random.Generator, labels: tuple[str, ...], shape: tuple[int, int] = (360, 640)) -> list[Box]:
    """Whole vehicles side by side, leaning towards the middle of the image as under a camera that looks down."""
    height, width = shape
    boxes = []
    for k, label in enumerate(labels):
        lane = width / len(labels)
        centre = np.array([rng.uniform(k * lane + 60, (k + 1) * lane - 60), rng.uniform(60, height - 60)])
        lean = (np.array([width, height]) / 2 - centre) * 0.035
        gains = (rng.uniform(0.25, 0.75), rng.uniform(0.25, 0.75))
        boxes.append(
            Box(
                label,
                (float(centre[0]), float(centre[1])),
                heading_rad=rng.uniform(-np.pi, np.pi),
                lean_px=(float(lean[0]), float(lean[1])),
                shadow_px=(rng.uniform(-15, 15), rng.uniform(-15, 15)),
                wall_gains=gains,
            )
        )
    return boxes


def training_frames(seed: int, labels: tuple[str, ...], count: int) -> list[LabelledFrame]:
    rng = np.random.default_rng(seed)
    frames = []
    for _ in range(count):
        boxes = random_boxes(rng, labels)
        frames.append(labelled(draw(floor(rng), boxes, gain=rng.uniform(0.5, 1.2)), boxes))
    return frames
