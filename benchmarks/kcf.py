"""Our kernelized correlation filter against OpenCV-contrib's TrackerKCF: speed and centre error on the same frames.

``python -m benchmarks.kcf [--json] [--frames N]``. One thread each, processor time, turn by turn in one run; the best
of ROUNDS counts. Both follow the same vehicles, from the truth of the first frame on, without any further detection:
ours as the stand-alone tracker with its own prediction of place and heading, from the roof's rectangle; contrib's from
its upright hull, for it knows no other boxes. The error is the distance of the tracked centre to the roof's, both less
where they were in the first frame. Only frames in which a tracker has its target are timed and averaged; contrib's is
kept from giving up. OpenCV 5.0's raw-grey setting fails with an error of its own in the second frame: its scores are
not valid, and the headline ratios are those to contrib's default.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
import venv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from bench.scores import Score
from benchmarks.command import run
from contracts import Camera, Detections, FloatArray, Frame, ImageArray
from perception.filter_tracker import FilterTracker
from perception.kcf import CorrelationTracker, Features, KcfSettings
from scenarios.loader import load_scenario
from scenarios.worlds import build_world

SCENARIO, FPS = "oval-two-vehicles", 100.0  # at more than 5 px a frame contrib loses what it follows
ROUNDS = 3
LEAST_KEPT = 0.5  # of the frames; a tracker that had its target in fewer says nothing about speed or error
WHOLE, LEAST_FRAMES = 0.95, 40  # visible share and length of a stretch
HERE = Path(__file__).parent
ENVIRONMENT = HERE.parent / "runs" / "benchmarks" / "contrib"
OURS = {
    "colour": KcfSettings(),
    "grey": KcfSettings(features=Features.GREY),
    "hog": KcfSettings(features=Features.HOG, samples=8192),
}
CONTRIB = ("default", "grey")
PADDINGS, SAMPLES = (1.25, 1.5, 2.0, 2.5, 3.0), (512, 1024, 2048, 4096, 8192)


@dataclass(frozen=True, eq=False)
class Stretch:
    """Frames ``first`` to ``last`` of the film, in which one vehicle is whole.

    roofs_px: (n, 2) truth. quad_px: (4, 2) the roof in the first frame.
    """

    first: int
    last: int
    roofs_px: FloatArray
    quad_px: FloatArray


@dataclass(frozen=True, eq=False)
class Film:
    frames: ImageArray  # (N, H, W, 3), one camera after the other
    stretches: tuple[Stretch, ...]


def shoot(frames: int) -> Film:
    world = build_world(replace(load_scenario(SCENARIO), fps=FPS, duration_s=frames / FPS), workers=2)
    steps = list(world.steps())
    images, stretches = [], []
    for k, camera in enumerate(world.cameras):
        start = len(images)
        images += [step.frames[k].image for step in steps]
        for row in range(len(steps[0].truth.ids)):
            whole = [step.truth.cameras[k].visible_fractions[row] >= WHOLE for step in steps]
            edges = np.flatnonzero(np.diff(np.r_[0, whole, 0])).reshape(-1, 2).tolist()
            for first, last in edges:
                if last - first >= LEAST_FRAMES:
                    roofs = np.array([step.truth.cameras[k].roofs_px[row] for step in steps[first:last]])
                    quad = roof_quad(camera, steps[first].truth, row, roofs[0])
                    stretches.append(Stretch(start + first, start + last, roofs, quad))
    return Film(np.array(images), tuple(stretches))


def roof_quad(camera: Camera, truth, row: int, centre_px: FloatArray) -> FloatArray:
    """(4, 2) the roof's corners under a camera that looks nearly straight down."""
    heading, (length, width, height) = truth.headings_rad[row], truth.sizes_m[row]
    ahead = camera.pose.world_from_camera.T @ [np.cos(heading), np.sin(heading), 0.0]
    along = ahead[:2] / np.linalg.norm(ahead[:2])
    across = np.array([-along[1], along[0]])
    scale = camera.intrinsics.fx_px / (camera.pose.position_m[2] - height)
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) / 2 * (length * scale, width * scale)
    return corners @ np.array([along, across]) + centre_px


class FirstFrame:
    """Detector that knows where the target is in the first frame and nothing after."""

    def __init__(self, quad_px: FloatArray) -> None:
        self._quad_px = quad_px

    def reset(self) -> None: ...

    def detect(self, frame: Frame) -> Detections:
        if frame.index > 0:
            return Detections.empty(frame.camera, frame.index, frame.time_ns)
        quad = self._quad_px[None]
        boxes = np.concatenate([quad.min(axis=1), quad.max(axis=1)], axis=1)
        middle, cov = quad.mean(axis=1), np.eye(2)[None]
        return Detections("", 0, 0, ("target",), np.ones(1), boxes, quad, middle, np.zeros(1), cov)


@dataclass(frozen=True, eq=False)
class Run:
    """What a tracker did over one stretch: errors of the n frames in which it had the target, and its time."""

    errors_px: FloatArray
    frames: int  # in which it could have had it
    seconds: float


def errors_px(stretch: Stretch, start_px: FloatArray, centres: Sequence[Sequence[float] | None]) -> FloatArray:
    had = [k for k, centre in enumerate(centres) if centre is not None]
    moved = np.array([centres[k] for k in had]).reshape(-1, 2) - start_px
    return np.asarray(np.hypot(*(moved - (stretch.roofs_px[1:][had] - stretch.roofs_px[0])).T))


def run_ours(film: Film, stretch: Stretch, settings: KcfSettings) -> Run:
    tracker = FilterTracker(FirstFrame(stretch.quad_px), partial(CorrelationTracker, settings))
    frames = [Frame("", k, k, film.frames[stretch.first + k]) for k in range(stretch.last - stretch.first)]
    tracker.perceive(frames[0])
    centres, seconds = [], 0.0
    for frame in frames[1:]:
        begin = time.thread_time()
        tracks = tracker.perceive(frame)
        if len(tracks):
            seconds += time.thread_time() - begin
        centres.append(tracks.objects.anchors_px[0].tolist() if len(tracks) else None)
    return Run(errors_px(stretch, stretch.quad_px.mean(axis=0), centres), len(centres), seconds)


class Contrib:
    """OpenCV-contrib's tracker, in its own environment and process."""

    def __init__(self, frames: Path) -> None:
        python = ENVIRONMENT / "bin" / "python"
        if not python.exists():
            venv.create(ENVIRONMENT, with_pip=True, clear=True)
            subprocess.run([python, "-m", "pip", "-q", "install", "-r", HERE / "kcf_contrib.txt"], check=True)
        self._process = subprocess.Popen(
            [python, HERE / "kcf_contrib.py", frames], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def run(self, stretch: Stretch, setting: str) -> Run:
        low, high = stretch.quad_px.min(axis=0), stretch.quad_px.max(axis=0)
        corner, size = np.rint(low).astype(int), np.rint(high - low).astype(int)
        order = {"setting": setting, "frames": [stretch.first, stretch.last], "box": [*corner.tolist(), *size.tolist()]}
        print(json.dumps(order), file=self._process.stdin, flush=True)
        answer = json.loads(self._process.stdout.readline())
        found = errors_px(stretch, corner + (size - 1) / 2, answer["centres"])
        return Run(found, len(answer["centres"]), answer["seconds"])

    def close(self) -> None:
        self._process.stdin.close()
        self._process.wait()


def summary(name: str, rounds: Sequence[Sequence[Run]]) -> tuple[float, float, list[Score]]:
    """Frames per second, mean error, and the scores of a tracker over all stretches."""
    frames = sum(run.frames for run in rounds[0])
    seconds = sum(min(times) for times in zip(*[[run.seconds for run in runs] for runs in rounds], strict=True))
    errors = np.concatenate([run.errors_px for run in rounds[0]])
    if not len(errors):
        sys.exit(f"{name} lost every target at once: nothing to compare")
    fps, error, kept = len(errors) / seconds, float(errors.mean()), len(errors) / frames
    scores = [
        Score.of(f"kcf.{name}_fps", fps, "1/s", len(errors) if kept >= LEAST_KEPT else 0),
        Score.of(f"kcf.{name}_error_px", error, "px", len(errors) if kept >= LEAST_KEPT else 0),
        Score(f"kcf.{name}_kept", kept, "1", frames, True),
    ]
    return fps, error, scores


def against_contrib(film: Film) -> list[Score]:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "frames.npy"
        np.save(path, film.frames)
        contrib = Contrib(path)
        runs: dict[str, list[list[Run]]] = {f"ours_{name}": [] for name in OURS}
        runs |= {f"contrib_{name}": [] for name in CONTRIB}
        for _ in range(ROUNDS):
            turns: dict[str, list[Run]] = {name: [] for name in runs}
            for stretch in film.stretches:
                for name, settings in OURS.items():
                    turns[f"ours_{name}"].append(run_ours(film, stretch, settings))
                for name in CONTRIB:
                    turns[f"contrib_{name}"].append(contrib.run(stretch, name))
            for name, each in turns.items():
                runs[name].append(each)
        contrib.close()
    found = {name: summary(name, rounds) for name, rounds in runs.items()}
    scores = [score for _, _, several in found.values() for score in several]
    for ours in OURS:
        for theirs in CONTRIB:
            (fps, error, _), (their_fps, their_error, _) = found[f"ours_{ours}"], found[f"contrib_{theirs}"]
            n = min(found[name][2][0].n for name in (f"ours_{ours}", f"contrib_{theirs}"))  # 0 where one lost them
            scores.append(Score.of(f"kcf.fps_ratio_{ours}_to_{theirs}", fps / their_fps, "1", n))
            scores.append(Score.of(f"kcf.error_ratio_{ours}_to_{theirs}", error / their_error, "1", n))
    named = {score.name: score for score in scores}
    headline = [
        replace(named[f"kcf.{what}_colour_to_default"], name=f"kcf.{what}") for what in ("fps_ratio", "error_ratio")
    ]
    return [*scores, *headline]


def by_region(film: Film) -> list[Score]:
    """Speed and error against the size of the tracked region, and against how finely it is sampled."""
    variants = {f"padding_{value:g}": KcfSettings(padding=value) for value in PADDINGS}
    variants |= {f"samples_{value}": KcfSettings(samples=value) for value in SAMPLES}
    scores = []
    for name, settings in variants.items():
        rounds = [[run_ours(film, stretch, settings) for stretch in film.stretches] for _ in range(ROUNDS)]
        scores += summary(name, rounds)[2]
    return scores


def measure(frames: int) -> list[Score]:
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):  # of the process that is about to be started
        os.environ[name] = "1"
    cv2.setNumThreads(1)
    film = shoot(frames)
    if not film.stretches:
        sys.exit(f"no vehicle is whole for {LEAST_FRAMES} frames: give more --frames")
    return [*against_contrib(film), *by_region(film)]


if __name__ == "__main__":
    run("kcf", __doc__, measure, frames=150)
