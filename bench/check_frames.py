"""Small made-up frames for the contract kit: moving blocks of colour, and images that are out of the ordinary."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from contracts import Detections, FloatArray, Frame, ImageArray

CAMERA = "kit"
PERIOD_NS = 40_000_000
COLOURS_BGR = {"red": (30, 30, 200), "blue": (200, 60, 20), "green": (40, 170, 40)}
BLOCK_PX = np.array([34.0, 18.0])  # width, height


@dataclass(frozen=True)
class Scene:
    """A frame, faultless detections for it, and its name in messages."""

    title: str
    frame: Frame
    detections: Detections


def street(count: int = 10) -> list[Scene]:
    """Three blocks that drive over a grey floor, one of them out of the image."""
    scenes = []
    for index in range(count):
        image = np.full((160, 240, 3), 120, np.uint8)
        starts = np.array([[20.0, 30.0], [150.0, 70.0], [180.0, 120.0]])  # (3, 2)
        speeds = np.array([[6.0, 0.0], [-5.0, 1.0], [9.0, 0.0]])
        corners = np.round(starts + speeds * index)
        boxes = np.concatenate([corners, corners + BLOCK_PX], axis=1) - 0.5  # (3, 4), the blocks' edges
        inside = boxes[:, 0] < 239
        for colour, (left, top, right, bottom) in zip(COLOURS_BGR.values(), (boxes + 0.5).astype(int), strict=True):
            image[top:bottom, left:right] = colour
        labels = tuple(np.array(list(COLOURS_BGR))[inside].tolist())
        scenes.append(_scene(f"frame {index} of a plain sequence", image, index, labels, boxes[inside]))
    return scenes


def strange_scenes() -> list[list[Scene]]:
    """Sequences of one image each, without any object."""
    noise = np.random.default_rng(0).integers(0, 256, (90, 120, 3), dtype=np.uint8)
    images = {
        "a black image": np.zeros((90, 120, 3), np.uint8),
        "a white image": np.full((90, 120, 3), 255, np.uint8),
        "an image of noise": noise,
        "an image of odd size": np.full((67, 101, 3), 120, np.uint8),
        "an image smaller than any object": np.full((12, 16, 3), 120, np.uint8),
    }
    return [[_scene(title, image, 0, (), np.empty((0, 4)))] for title, image in images.items()]


def given_scenes(frames: Sequence[Frame]) -> list[Scene]:
    """``frames`` as scenes in which nothing is detected."""
    return [
        Scene(f"frame {frame.index}", frame, Detections.empty(frame.camera, frame.index, frame.time_ns))
        for frame in frames
    ]


def _scene(title: str, image: ImageArray, index: int, labels: tuple[str, ...], boxes_px: FloatArray) -> Scene:
    n = len(labels)
    left, top, right, bottom = boxes_px.T
    time_ns = index * PERIOD_NS
    detections = Detections(
        CAMERA,
        index,
        time_ns,
        labels=labels,
        scores=np.ones(n),
        boxes_px=boxes_px,
        quads_px=np.stack([left, top, right, top, right, bottom, left, bottom], axis=1).reshape(n, 4, 2),
        anchors_px=(boxes_px[:, :2] + boxes_px[:, 2:]) / 2,
        anchor_heights_m=np.zeros(n),
        anchor_covs_px2=np.tile(np.eye(2), (n, 1, 1)),
    )
    return Scene(title, Frame(CAMERA, index, time_ns, image), detections)
