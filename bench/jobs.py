"""A run from beginning to end: a scenario or footage in, a finished run directory out, or nothing at all."""

import itertools
import os
import secrets
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path

import cv2
from rich.console import Console
from rich.progress import track

from bench.expectations import check
from bench.footage import Footage
from bench.recording import Manifest, Recording
from bench.recording_file import RECORDING_NAME, Recorder, load_recording
from bench.road_calibration import CALIBRATORS, FRAMES, PICKS, calibrated_from_map, thinned
from bench.run import Chain, run
from bench.scores import Score, write_scores
from bench.scoring import score
from bench.wiring import ON_MAP, Stages, board_lenses, calibrated_cameras, make_chain, make_perception
from contracts import Frame, InputError
from contracts.truth import Step, World
from georef.calibrated import CalibratedCamera
from georef.camera_file import read_camera
from georef.map_ground import MapGround
from scenarios.loader import list_scenarios, load_scenario
from scenarios.schema import RoadScenario, Scenario
from scenarios.worlds import build_world, geo_of, maps_of

SCORES_NAME = "scores.json"
SAMPLES_NAME = "samples"
SAMPLES = 4  # pictures per camera that a run keeps for its report
FOOTAGE_SAMPLE_EVERY = 100  # frames; the length of footage is not known beforehand
DECIDING_PACKAGES = ("mujoco", "numpy", "opencv-python-headless", "scipy")


@dataclass(frozen=True, eq=False)
class Outcome:
    """A finished run.

    directory: where it lies.
    failures: the scenario's expectations that it did not meet, one sentence each.
    """

    directory: Path
    recording: Recording
    scores: tuple[Score, ...]
    failures: tuple[str, ...]


def run_scenario(
    scenario: Scenario,
    stages: Stages,
    directory: Path,
    *,
    seed: int | None = None,
    noise_seed: int | None = None,
    keep_frames: bool = False,
    quiet: bool = False,
) -> Outcome:
    """Simulate, film, see, locate, record and score one scenario into ``directory``.

    seed: instead of the scenario's own. noise_seed: of the sensors alone; nothing else changes with it.
    Raises InputError for a stage, a seed or a directory that cannot serve.
    """
    stages = _checked_stages(scenario, stages)
    for name, chosen in (("--seed", seed), ("--noise-seed", noise_seed)):
        if chosen is not None and chosen < 0:
            raise InputError(f"{name} {chosen} must not be negative")
    workers = os.cpu_count() or 1
    world = build_world(
        scenario,
        seed=seed,
        noise_seed=noise_seed,
        film=stages.needs_film,
        workers=workers,
        renderer=stages.renderer,
    )
    make_perception(stages, world.survey.cameras)  # first: a wrong plug-in costs no film
    steps = world.steps()
    by_map = isinstance(scenario, RoadScenario) and "calibrate" not in stages.oracles
    by_board = stages.needs_film and not by_map
    lenses = board_lenses(world, stages) if by_board else {}  # meanwhile other processes prepare the film
    first = next(steps)
    calibrated: tuple[CalibratedCamera, ...] = ()
    if by_board:
        calibrated = calibrated_cameras(world, lenses, first.frames)
    elif stages.needs_film and isinstance(scenario, RoadScenario):
        calibrated = _from_map(_seeded(scenario, seed), world, stages, noise_seed)
    manifest = manifest_of(scenario, world, stages, calibrated, seed=seed)
    shown = _with_progress(itertools.chain([first], steps), scenario.name, total=len(world), quiet=quiet)
    cameras = [each.camera for each in calibrated]
    perception = make_perception(stages, cameras, world.survey.centrelines_m)
    ground = None
    if stages.locator == ON_MAP and isinstance(scenario, RoadScenario):
        ground = MapGround.of(maps_of(_seeded(scenario, seed))[1])
    chain = make_chain(stages, perception, calibrated, one_per_label=scenario.world == "rail", ground=ground)
    _record(shown, manifest, chain, directory, keep_frames=keep_frames, sample_every=len(world) // SAMPLES + 1)
    return rescore(directory, scenario)


def _from_map(
    scenario: RoadScenario, world: World, stages: Stages, noise_seed: int | None
) -> tuple[CalibratedCamera, ...]:
    """The cameras over a road; from frames alone, their first ten seconds are filmed thinly for it."""
    frames: list[Frame] = []
    if stages.calibrator == FRAMES:
        before = build_world(thinned(scenario), noise_seed=noise_seed, workers=1, renderer=stages.renderer)
        frames = [frame for step in before.steps() for frame in step.frames]
    return calibrated_from_map(scenario, world, frames, stages.calibrator or PICKS)


def _seeded(scenario: RoadScenario, seed: int | None) -> RoadScenario:
    """As its map is drawn under the seed of the run."""
    return scenario if seed is None else replace(scenario, seed=seed)


def _checked_stages(scenario: Scenario, stages: Stages) -> Stages:
    """The stages with the world's own defaults. What the bench has none of must be named; InputError else."""
    if not isinstance(scenario, RoadScenario):
        if stages.locator == ON_MAP:
            raise InputError(f"--locator {ON_MAP} is for the road: the rail has no map of its ground")
        if stages.calibrator:
            raise InputError(f"--calibrator {stages.calibrator} is for the road: the rail has board and marks")
        return stages
    if stages.calibrator and stages.calibrator not in CALIBRATORS:
        choices = ", ".join(CALIBRATORS)
        raise InputError(f"--calibrator {stages.calibrator}: no such calibrator, choose from {choices}")
    if stages.calibrator and "calibrate" in stages.oracles:
        raise InputError(
            f"--calibrator {stages.calibrator} beside --oracle calibrate: the truth leaves it nothing to do"
        )
    if not stages.needs_film:
        return stages
    if not (stages.detector or stages.perceiver or "detect" in stages.oracles):
        raise InputError("the road has no detector of its own: name yours with --detector, or give --oracle detect")
    return replace(stages, calibrator=stages.calibrator or PICKS, locator=stages.locator or ON_MAP)


def manifest_of(
    scenario: Scenario, world: World, stages: Stages, calibrated: Sequence[CalibratedCamera], *, seed: int | None = None
) -> Manifest:
    """What is run, with the cameras as calibrated.

    seed: instead of the scenario's own, as the world was built with.
    """
    return Manifest(
        scenario=scenario.name,
        title=scenario.title,
        world=scenario.world,
        seed=scenario.seed if seed is None else seed,
        fps=scenario.fps,
        stages={**stages.names(), **({"renderer": stages.renderer} if stages.needs_film else {})},
        oracles=stages.oracles,
        versions=_versions(),
        survey=world.survey,
        true_cameras=world.cameras,
        calibrated_cameras=tuple(calibrated),
        geo=geo_of(scenario),
    )


def run_footage(
    video: Path,
    camera_file: Path,
    stages: Stages,
    directory: Path,
    *,
    fps: float | None = None,
    keep_frames: bool = False,
    quiet: bool = False,
) -> Outcome:
    """Send real footage through the same chain. There is no truth, so every score is there and none is valid.

    fps: frames per second where the footage does not say, as with a folder of images.
    """
    if stages.oracles:
        raise InputError("real footage has no truth: run it without --oracle")
    calibrated = read_camera(camera_file)
    footage = Footage(video, calibrated.camera, fps=fps)
    manifest = Manifest(
        scenario=video.name,
        title=f"Footage {video.name}",
        world="footage",
        seed=0,
        fps=footage.fps,
        stages={**stages.names(), "calibrator": camera_file.name},
        oracles=(),
        versions=_versions(),
        survey=None,
        true_cameras=(),
        calibrated_cameras=(calibrated,),
    )
    shown = _with_progress(footage.steps(), video.name, total=None, quiet=quiet)
    chain = make_chain(stages, make_perception(stages, [calibrated.camera]), [calibrated])
    _record(shown, manifest, chain, directory, keep_frames=keep_frames, sample_every=FOOTAGE_SAMPLE_EVERY)
    return rescore(directory)


def rescore(directory: Path, scenario: Scenario | None = None) -> Outcome:
    """Score a recorded run (again) and write ``scores.json``; nothing is simulated.

    scenario: whose expectations to hold; the run's own from the library if not given and still there.
    """
    recording = load_recording(directory)
    scores = score(recording)
    write_scores(directory / SCORES_NAME, scores)
    name = recording.manifest.scenario
    if scenario is None and name in list_scenarios():
        scenario = load_scenario(name)
    failures = check(scenario.expect, scores, recording) if scenario else ()
    return Outcome(directory, recording, scores, tuple(failures))


def _record(
    steps: Iterable[Step], manifest: Manifest, chain: Chain, directory: Path, *, keep_frames: bool, sample_every: int
) -> None:
    with _whole_or_nothing(directory) as partial, Recorder(partial, manifest, keep_frames=keep_frames) as recorder:
        run(_with_samples(steps, partial / SAMPLES_NAME, sample_every), chain, recorder)


@contextmanager
def _whole_or_nothing(directory: Path) -> Iterator[Path]:
    """A directory beside ``directory`` that takes its place when the block ends well, and vanishes when it does not."""
    if directory.name in ("", ".."):
        raise InputError(f"{directory} is no name for a run: choose another --out")
    if directory.exists() and not directory.is_dir():
        raise InputError(f"{directory} is a file: choose another --out")
    if directory.exists() and not (directory / RECORDING_NAME).exists() and any(directory.iterdir()):
        raise InputError(f"{directory} exists and is no run: choose another --out")
    try:
        partial = directory.with_name(f".{directory.name}-{secrets.token_hex(4)}")
        partial.mkdir(parents=True)
    except OSError as error:
        raise InputError(f"{directory}: cannot be written: {error.strerror}") from error
    try:
        yield partial
        shutil.rmtree(directory, ignore_errors=True)
        partial.rename(directory)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise


def _with_samples(steps: Iterable[Step], directory: Path, every: int) -> Iterator[Step]:
    """Pass the steps on, keeping every so-manyth frame as a picture for the report."""
    directory.mkdir()
    for index, step in enumerate(steps):
        if index % every == every // 2:
            for frame in step.frames:
                cv2.imwrite(str(directory / f"{frame.camera}_{frame.index:06d}.png"), frame.image)
        yield step


def _with_progress(steps: Iterable[Step], title: str, *, total: int | None, quiet: bool) -> Iterable[Step]:
    return track(steps, title, total=total, disable=quiet, console=Console(stderr=True))


def _versions() -> dict[str, str]:
    return {package: version(package) for package in DECIDING_PACKAGES}
