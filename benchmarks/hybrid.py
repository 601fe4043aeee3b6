"""How fast the hybrid tracker is, on frames already in memory: one, two and six cameras.

``python -m benchmarks.hybrid [--json] [--frames N]``. One and two cameras in one process and thread; six cameras of
1920x1200 shared by two processes. Whole-frame searches are counted in; detection in every frame is measured beside it,
interleaved, on the same frames.
"""

import multiprocessing
import time
from collections.abc import Callable, Sequence
from itertools import islice

import cv2

from bench.scores import Score
from benchmarks.command import run
from contracts import Camera, Frame, Perceiver
from perception.hbp import HistogramBackProjection
from perception.hybrid import HybridTracker
from perception.identity import ColourIdentity
from perception.perceiver import DetectThenTrack
from scenarios.loader import load_scenario
from scenarios.worlds import build_world

ONE_VEHICLE, TWO_VEHICLES, SIX_CAMERAS = "oval-one-vehicle", "oval-two-vehicles", "line30-station"
SLICES = 5  # in which the two perceivers take turns, so that a loaded machine slows both

Film = list[tuple[Frame, ...]]


def film(scenario: str, frames: int, cameras: Sequence[int]) -> tuple[Film, list[Camera]]:
    """Frames of some cameras of a scenario, and what their owner knows of the cameras."""
    world = build_world(load_scenario(scenario), film=True, workers=2)
    steps = islice(world.steps(), frames)
    return [tuple(step.frames[k] for k in cameras) for step in steps], [world.survey.cameras[k] for k in cameras]


def hybrid(camera: Camera) -> Perceiver:
    return HybridTracker(camera=camera)


def detection(camera: Camera) -> Perceiver:
    return DetectThenTrack(HistogramBackProjection(camera=camera), ColourIdentity())


def seconds(perceivers: Sequence[Perceiver], shots: Film) -> float:
    begin = time.perf_counter()
    for frames in shots:
        for perceiver, frame in zip(perceivers, frames, strict=True):
            perceiver.perceive(frame)
    return time.perf_counter() - begin


def side_by_side(shots: Film, cameras: Sequence[Camera]) -> tuple[float, float]:
    """Frames per second of each camera: the hybrid, and detection in every frame."""
    makers: tuple[Callable[[Camera], Perceiver], ...] = (hybrid, detection)
    teams = [[make(camera) for camera in cameras] for make in makers]
    spent = [0.0, 0.0]
    size = -(-len(shots) // SLICES)
    for begin in range(0, len(shots), size):
        for k, team in enumerate(teams):
            spent[k] += seconds(team, shots[begin : begin + size])
    return len(shots) / spent[0], len(shots) / spent[1]


def in_two_processes(shots: Film, cameras: Sequence[Camera]) -> float:
    """Frames per second of each camera, half of the cameras in each process; the slower one counts."""
    context = multiprocessing.get_context("fork")  # the frames are shared, not copied
    ready = context.Barrier(2)
    times = context.SimpleQueue()

    def work(share: slice) -> None:
        cv2.setNumThreads(1)
        mine = [frames[share] for frames in shots]
        team = [hybrid(camera) for camera in cameras[share]]
        ready.wait()
        times.put(seconds(team, mine))

    team = [context.Process(target=work, args=(slice(k, None, 2),)) for k in range(2)]
    for process in team:
        process.start()
    slowest = max(times.get() for _ in team)
    for process in team:
        process.join()
    return len(shots) / slowest


def measure(frames: int) -> list[Score]:
    cv2.setNumThreads(1)
    scores = []
    for name, scenario, cameras in (("1_camera", ONE_VEHICLE, (0,)), ("2_cameras", TWO_VEHICLES, (0, 1))):
        shots, known = film(scenario, frames, cameras)
        fast, slow = side_by_side(shots, known)
        scores += [
            Score(f"hybrid.fps_{name}", fast, "1/s", len(shots), True),
            Score(f"hybrid.detection_fps_{name}", slow, "1/s", len(shots), True),
            Score(f"hybrid.fps_ratio_{name}", fast / slow, "1", len(shots), True),
        ]
    shots, known = film(SIX_CAMERAS, frames // 5, range(6))
    fps = in_two_processes(shots, known)
    return [*scores, Score("hybrid.fps_6_cameras_two_processes", fps, "1/s", len(shots), True)]


if __name__ == "__main__":
    run("hybrid", __doc__, measure, frames=250)
