"""Our histogram back-projection against the textbook chain on the same filmed frames, in one thread, taking turns.

``python -m benchmarks.hbp [--json] [--frames N]``. The textbook chain is paper R's as everyone writes it down from
OpenCV's functions: cvtColor, calcHist, calcBackProject, filter2D with a disc of the vehicle's area, threshold, opening
and closing, contours, smallest rotated rectangle, all of it on the whole frame. It is given the same colour models. The
time is the processor's, the least of some repetitions; where a detector places a vehicle is held against the truth:
ours gives the roof's centre, the textbook's the middle of a rectangle round roof, walls and what the disc smeared.
Ours goes on where the textbook chain ends, to measure the roof to a tenth of a pixel; ``outline`` is ours without that.
"""

import time
from collections.abc import Callable, Sequence
from itertools import islice

import cv2
import numpy as np

from bench.scores import Score
from benchmarks.command import run
from contracts import Camera, FloatArray, Frame
from contracts.truth import Truth
from perception.colour_models import SHIPPED, ColourModel, ColourModels
from perception.hbp import HistogramBackProjection
from perception.hue_saturation import SHAPE
from scenarios.loader import load_scenario
from scenarios.worlds import build_world

SCENARIO = "oval-two-vehicles"
EVERY = 8  # of the film's frames
REPETITIONS = 5
WHOLE = 0.98  # visible share from which a vehicle counts as whole
BINARY_MIN = 64.0  # of the smoothed likelihood
CLOSING_PX = 5

Places = dict[str, FloatArray]
Locate = Callable[[Frame], Places]
Shot = tuple[Frame, Truth]


def film(frames: int) -> tuple[list[Shot], Camera]:
    """Frames of the first camera with the truth, and the camera as its owner knows it."""
    world = build_world(load_scenario(SCENARIO), film=True)
    steps = islice(world.steps(), 0, frames * EVERY, EVERY)
    return [(step.frames[0], step.truth) for step in steps if step.truth], world.survey.cameras[0]


def textbook(models: Sequence[ColourModel], scale_px_per_m: float) -> Locate:
    """Centres by label, found by OpenCV's functions one after the other on the whole frame."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSING_PX, CLOSING_PX))
    area_px = {model.label: float(np.prod(model.roof_size_m)) * scale_px_per_m**2 for model in models}
    discs = {label: disc(float(np.sqrt(area / np.pi))) for label, area in area_px.items()}
    channels, ranges = (0, 1), (0.0, 180.0, 0.0, 256.0)

    def locate(frame: Frame) -> Places:
        hsv = cv2.cvtColor(frame.image, cv2.COLOR_BGR2HSV)
        counts = cv2.calcHist([hsv], channels, None, SHAPE, ranges)
        places = {}
        for model in models:
            area = area_px[model.label]
            ratio = np.minimum(model.histogram * area / np.maximum(counts, 1.0), 1.0).astype(np.float32) * 255
            likelihood = cv2.calcBackProject([hsv], channels, ratio, ranges, 1.0)
            smooth = cv2.filter2D(likelihood, -1, discs[model.label])
            binary = cv2.threshold(smooth, BINARY_MIN, 1, cv2.THRESH_BINARY)[1]
            tidy = cv2.morphologyEx(cv2.morphologyEx(binary, cv2.MORPH_OPEN, kernel), cv2.MORPH_CLOSE, kernel)
            contours, _ = cv2.findContours(tidy, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            if contours:
                largest = max(contours, key=cv2.contourArea)
                if cv2.contourArea(largest) >= area / 2:
                    places[model.label] = np.array(cv2.minAreaRect(largest)[0])
        return places

    return locate


def disc(radius: float) -> FloatArray:
    """A disc of ones over its area, as a kernel; (2 r + 1, 2 r + 1)."""
    reach = int(np.ceil(radius))
    x, y = np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1))
    inside = (x**2 + y**2 <= radius**2).astype(np.float64)
    return np.asarray(inside / inside.sum())


def ours(models: ColourModels, camera: Camera) -> Locate:
    """Anchors by label."""
    detector = HistogramBackProjection(models, camera)

    def locate(frame: Frame) -> Places:
        found = detector.detect(frame)
        return dict(zip(found.labels, found.anchors_px, strict=True))

    return locate


def outlines(models: ColourModels, camera: Camera) -> Locate:
    """Ours up to the smallest rotated rectangle, where the textbook chain ends: its centres by label."""
    detector = HistogramBackProjection(models, camera)

    def locate(frame: Frame) -> Places:
        found = detector.silhouettes(frame.image)
        return {label: np.array(outline.rectangle[0]) for label, outline in found.items()}

    return locate


def side_by_side(methods: Sequence[Locate], shots: Sequence[Shot]) -> tuple[FloatArray, list[list[float]]]:
    """Seconds of each method (M, frames), the least of the repetitions, and its errors in px of whole vehicles."""
    seconds = np.full((len(methods), len(shots)), np.inf)
    errors: list[list[float]] = [[] for _ in methods]
    for k, (frame, truth) in enumerate(shots):
        for repetition in range(REPETITIONS):
            for row, locate in enumerate(methods):
                begin = time.thread_time()
                places = locate(frame)
                seconds[row, k] = min(seconds[row, k], time.thread_time() - begin)
                if not repetition:
                    errors[row] += _errors_px(places, frame, truth)
    return seconds, errors


def _errors_px(places: Places, frame: Frame, truth: Truth) -> list[float]:
    (view,) = (view for view in truth.cameras if view.camera == frame.camera)
    seen = zip(truth.labels, view.roofs_px, view.visible_fractions.tolist(), strict=True)
    return [
        float(np.linalg.norm(places[label] - roof_px))
        for label, roof_px, share in seen
        if share >= WHOLE and label in places
    ]


def measure(frames: int) -> list[Score]:
    cv2.setNumThreads(1)
    shots, camera = film(frames)
    models = ColourModels.load(SHIPPED)
    scale_px_per_m = camera.intrinsics.fx_px / (camera.pose.position_m[2] - models.models[0].roof_height_m)
    label = shots[0][1].labels[0]
    one = ColourModels(tuple(m for m in models.models if m.label == label), models.focal_px, models.height_m)
    scores = []
    for name, chosen in (("", one), ("_all_colours", models)):
        methods = ours(chosen, camera), outlines(chosen, camera), textbook(chosen.models, scale_px_per_m)
        seconds, errors = side_by_side(methods, shots)
        fast, outline, slow = seconds.mean(axis=1).tolist()
        near, _, far = (float(np.sqrt(np.mean(np.square(each)))) for each in errors)
        n = len(shots)
        scores += [
            Score(f"hbp.fps{name}", 1 / fast, "1/s", n, True),
            Score(f"hbp.textbook_fps{name}", 1 / slow, "1/s", n, True),
            Score(f"hbp.fps_ratio{name}", slow / fast, "1", n, True),
            Score(f"hbp.outline_fps{name}", 1 / outline, "1/s", n, True),
            Score(f"hbp.outline_fps_ratio{name}", slow / outline, "1", n, True),
            Score(f"hbp.rms{name}", near, "px", len(errors[0]), True),
            Score(f"hbp.textbook_rms{name}", far, "px", len(errors[2]), True),
        ]
    return scores


if __name__ == "__main__":
    run("hbp", __doc__, measure, frames=25)
