"""A finished run as the report needs it: recording, scores, populations, plant."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.expectations import check
from bench.matching import gate_m
from bench.recording import Recording
from bench.recording_file import load_recording
from bench.scores import Score, by_name
from bench.scoring import score
from bench.scoring.anchors import Sightings, sightings
from bench.scoring.population import Population, camera_names, camera_population, fused_population
from bench.scoring.stages import StageErrors, split
from rail.plant import Plant
from scenarios.check import plant_of
from scenarios.loader import list_scenarios, load_scenario
from scenarios.schema import Expect, RailScenario, Scenario
from sim.colours import PALETTE, Colour

_OTHERS = ("#1b6ca8", "#b5562b", "#4a8a3a", "#7a4fa3", "#a8862b", "#3a8f8a", "#a33f6b", "#5b6470")


@dataclass(frozen=True, eq=False)
class ReportedRun:
    """What is shown of one run.

    failures: expectations that were not met; None where the scenario expects nothing, or is not in
        the library (any more).
    fused: the fused positions against the truth.
    cameras: what every camera placed on the ground, against the truth, by name.
    seen: the sightings of every camera by name.
    stages: the error of all sightings split by stage.
    plant: to draw the track; None where there is none or it is not known.
    """

    directory: Path
    recording: Recording
    scores: dict[str, Score]
    failures: tuple[str, ...] | None
    fused: Population
    cameras: dict[str, Population]
    seen: dict[str, Sightings]
    stages: StageErrors
    plant: Plant | None

    @property
    def name(self) -> str:
        """How the run is called among others."""
        return self.directory.resolve().name


def read_run(directory: Path) -> ReportedRun:
    """Read and score the run in ``directory``. Raises InputError if there is none or it is damaged."""
    recording = load_recording(directory)
    gate = gate_m(recording.manifest.world)
    scores = score(recording)
    cameras = {name: camera_population(recording, name, gate) for name in camera_names(recording)}
    seen = {name: sightings(recording, camera) for name, camera in cameras.items()}
    scenario = _scenario(recording)
    return ReportedRun(
        directory=directory,
        recording=recording,
        scores=by_name(scores),
        failures=tuple(check(scenario.expect, scores, recording)) if scenario and scenario.expect != Expect() else None,
        fused=fused_population(recording, gate),
        cameras=cameras,
        seen=seen,
        stages=split(recording, list(seen.items())),
        plant=plant_of(scenario.plant) if isinstance(scenario, RailScenario) else None,
    )


def colours(objects: Iterable[tuple[str, str]]) -> dict[str, str]:
    """A CSS colour for every (id, label): the vehicle's own paint where the label names one, else one apart."""
    known = dict(sorted(set(objects)))
    paints = {name: f"#{r:02x}{g:02x}{b:02x}" for name, (r, g, b) in PALETTE.items()}
    return {
        name: paints[Colour(label)] if label in paints else _OTHERS[k % len(_OTHERS)]
        for k, (name, label) in enumerate(known.items())
    }


def run_colours(run: ReportedRun) -> dict[str, str]:
    """A CSS colour for every true object of a run."""
    truths = (step.truth for step in run.recording.steps if step.truth is not None)
    return colours(pair for truth in truths for pair in zip(truth.ids, truth.labels, strict=True))


def seconds(time_ns: np.ndarray) -> np.ndarray:
    """Nanoseconds as seconds."""
    return time_ns / 1e9


def _scenario(recording: Recording) -> Scenario | None:
    name = recording.manifest.scenario
    return load_scenario(name) if name in list_scenarios() else None
