"""Sequences in memory: filmed once, calibrated once, then shown to one perceiver after the other."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import cv2
import numpy as np

from bench.jobs import manifest_of
from bench.recording import Manifest, RecordedStep, Recording
from bench.wiring import Stages, board_lenses, calibrated_cameras, make_chain
from contracts import Camera, FloatArray, Perceiver, Tracks
from contracts.truth import Step, Truth
from scenarios.schema import Scenario
from scenarios.worlds import build_world


@dataclass(frozen=True, eq=False)
class Film:
    """A filmed sequence: every step with its frames and the exact masks of all vehicles.

    manifest: with the cameras as calibrated from the sequence's own images.
    """

    scenario: Scenario
    manifest: Manifest
    steps: tuple[Step, ...]

    def thinned(self, every: int) -> "Film":
        """Every so-manyth step of it."""
        return replace(self, steps=self.steps[::every])


@dataclass(frozen=True, eq=False)
class Watched:
    """What one perceiver made of one film.

    sequence: of the scenario. light: all its lights, in order. method: how the perceiver is called.
    lights: by the frame's index, which light shone; two while one fades into the other.
    recording: as of a run of its own, without instance masks.
    seconds: by camera, (T,) processor time of each frame, from image to tracks.
    """

    sequence: str
    light: str
    method: str
    lights: dict[int, str]
    recording: Recording
    seconds: dict[str, FloatArray]


def film(scenario: Scenario, *, frames: int | None = None, stages: Stages | None = None) -> Film:
    """Film ``scenario``, at most ``frames`` frames of each camera if given, and calibrate its cameras.

    stages: says how the cameras are calibrated; from what they see, if not given.
    """
    if frames is not None and frames < scenario.frame_count:
        scenario = replace(scenario, duration_s=frames / scenario.fps)
    world = build_world(scenario, workers=os.cpu_count() or 1)
    stages = stages or Stages()
    filmed = world.steps()
    lenses = board_lenses(world, stages)
    steps = tuple(filmed)
    calibrated = calibrated_cameras(world, lenses, steps[0].frames)
    return Film(scenario, manifest_of(scenario, world, stages, calibrated), steps)


def watch(shown: Film, method: str, make_perceiver: Callable[[Camera], Perceiver]) -> Watched:
    """Send a film through the chain with one perceiver per camera, on one thread.

    Times are processor time: what other programs do meanwhile counts as little as it can.
    """
    cameras = [one.camera for one in shown.manifest.calibrated_cameras]
    perceivers = {camera.name: make_perceiver(camera) for camera in cameras}
    seconds: dict[str, list[float]] = {name: [] for name in perceivers}

    def perceive(step: Step) -> tuple[Tracks, ...]:
        tracks = []
        for frame in step.frames:
            start = time.process_time()
            tracks.append(perceivers[frame.camera].perceive(frame))
            seconds[frame.camera].append(time.process_time() - start)
        return tuple(tracks)

    chain = make_chain(Stages(), perceive, shown.manifest.calibrated_cameras)
    recorded = []
    with one_thread():
        for step in shown.steps:
            index = step.frames[0].index
            seen = chain.perceive(step)
            views = chain.locate(step, seen)
            fused = chain.fuse(views)
            truth, motions = without_masks(step.truth), chain.analyse(fused)
            recorded.append(RecordedStep(index, fused.time_ns, truth, seen, views, fused, motions, ()))
    return Watched(
        shown.scenario.name,
        " → ".join([shown.scenario.light, *(change.to for change in shown.scenario.light_change)]),
        method,
        {step.frames[0].index: light_name(shown.scenario, step.frames[0].time_ns) for step in shown.steps},
        Recording(shown.manifest, tuple(recorded)),
        {name: np.array(times) for name, times in seconds.items()},
    )


@contextmanager
def one_thread() -> Iterator[None]:
    """While this context lasts OpenCV works on one thread."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def light_name(scenario: Scenario, time_ns: int) -> str:
    """The light that shines at a moment, ``"sunny to cloudy"`` while one fades into the other."""
    name = str(scenario.light)
    for change in scenario.light_change:
        since_s = time_ns * 1e-9 - change.at_s
        if since_s < 0:
            break
        if since_s < change.over_s:
            return f"{name} to {change.to}"
        name = str(change.to)
    return name


def without_masks(truth: Truth | None) -> Truth | None:
    """The truth without its instance masks, which would fill the memory."""
    if truth is None:
        return None
    return replace(truth, cameras=tuple(replace(view, instances=None) for view in truth.cameras))


def frames_per_second(seconds: Sequence[FloatArray]) -> float:
    """Frames over processor time; NaN of no frame."""
    together = np.concatenate([np.empty(0), *seconds])
    return len(together) / float(together.sum()) if len(together) else float("nan")
