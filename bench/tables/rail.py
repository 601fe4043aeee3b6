"""``gantry tables rail``: paper R's evaluation, remade on the sequences whose truth is known."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track

from bench.plugins import require_methods
from bench.recording import Manifest
from bench.tables.figure15 import figure15
from bench.tables.figure19 import figure19
from bench.tables.figure21 import figure21
from bench.tables.films import Film, Watched, film, watch
from bench.tables.outlines import OutlineDetector, Outlines, outlines
from bench.tables.owners import owners
from bench.tables.part import Part
from bench.tables.precision import precision
from bench.tables.region import region
from bench.tables.table1 import table1
from bench.tables.table3 import table3
from bench.tables.written import write_parts
from bench.wiring import TABLE_DETECTORS, TABLE_REGIONS, TABLE_TRACKERS, Stages
from contracts import FloatArray, InputError
from scenarios.loader import list_scenarios, load_scenario
from scenarios.schema import RailScenario, Scenario

TITLE = "Paper R's tables, remade"
DETECTORS_EVERY = 5  # steps: detectors have no memory, and some of them are slow
LEAST_STEPS = 20  # that detectors are shown, if the film has so many


@dataclass
class Evaluation:
    """What every method made of every sequence so far, by the method's name, in the order of the sequences."""

    manifests: list[Manifest] = field(default_factory=list)
    detectors: dict[str, list[Watched]] = field(default_factory=dict)
    masks: dict[str, list[Outlines]] = field(default_factory=dict)
    trackers: dict[str, list[Watched]] = field(default_factory=dict)
    regions: dict[float, list[Watched]] = field(default_factory=dict)
    mosaic: Part | None = None  # of the first sequence with the most cameras
    _cameras_shown: int = 0

    def add(self, shown: Film) -> None:
        """Show a film to every detector and tracker; the film itself is not kept."""
        self.manifests.append(shown.manifest)
        still = shown.thinned(min(DETECTORS_EVERY, max(1, len(shown.steps) // LEAST_STEPS)))
        for name, detector in TABLE_DETECTORS.items():
            stages = Stages(detector=detector)
            self.detectors.setdefault(name, []).append(watch(still, name, stages.make_perceiver))
            self.masks.setdefault(name, []).append(outlines(still, _detectors(stages, still)))
        for name, stages in TABLE_TRACKERS.items():
            make_perceiver = partial(stages.make_perceiver, centrelines_m=_centrelines_m(shown))
            self.trackers.setdefault(name, []).append(watch(shown, name, make_perceiver))
        for size, make_filter in TABLE_REGIONS.items():
            self.regions.setdefault(size, []).append(watch(shown, f"region {size:g}", make_filter))
        *_, own = self.trackers.values()
        if len(shown.manifest.true_cameras) > self._cameras_shown:
            self.mosaic, self._cameras_shown = figure15(shown, own[-1]), len(shown.manifest.true_cameras)

    def parts(self) -> list[Part]:
        """All tables and figures. The first tracker is detection in every frame, the last one the chain's own."""
        detection, *_ = self.trackers.values()
        *_, own = self.trackers.values()
        parts = [
            table3(self.detectors, self.masks),
            precision(self.trackers),
            figure19(own, detection),
            region(self.regions),
            figure21(own),
            owners(own),
            table1(self.manifests),
        ]
        return [*parts, self.mosaic] if self.mosaic else parts


def _centrelines_m(shown: Film) -> Sequence[FloatArray]:
    survey = shown.manifest.survey
    return survey.centrelines_m if survey else ()


def _detectors(stages: Stages, shown: Film) -> dict[str, OutlineDetector]:
    """A detector for each camera of a film."""
    detectors: dict[str, OutlineDetector] = {}
    for calibrated in shown.manifest.calibrated_cameras:
        detector: Any = stages.make_detector(calibrated.camera)
        require_methods(detector, OutlineDetector, name=str(stages.detector))
        detectors[calibrated.camera.name] = detector
    return detectors


def sequences(names: Sequence[str], split: str | None = None) -> list[RailScenario]:
    """The scenarios of these names, or, where none is given, all of the library that are marked with ``split``.

    split: ``"test"`` where neither names nor a split are given.
    Raises InputError if both are given, if no scenario of the rail has that mark, or for one of the road.
    """
    if names and split:
        raise InputError(f"--split {split} chooses scenarios by itself: name none beside it")
    if names:
        return [_of_the_rail(name) for name in names]
    wanted = split or "test"
    library = [load_scenario(name) for name in list_scenarios()]
    chosen = [one for one in library if isinstance(one, RailScenario) and one.split == wanted]
    if not chosen:
        raise InputError(f'no scenario of the library has split = "{wanted}"')
    return chosen


def _of_the_rail(name: str) -> RailScenario:
    scenario = load_scenario(name)
    if not isinstance(scenario, RailScenario):
        raise InputError(f"{name} is no scenario of the rail")
    return scenario


def evaluate(scenarios: Sequence[Scenario], *, frames: int | None = None, quiet: bool = False) -> Evaluation:
    """Film every scenario, at most ``frames`` frames of each camera if given, and show it to all methods.

    Raises InputError if there is no scenario or no frame.
    """
    if frames is not None and frames < 1:
        raise InputError(f"--frames {frames}: at least one frame has to be filmed")
    if not scenarios:
        raise InputError("there is no sequence to make the tables from; name scenarios")
    evaluation = Evaluation()
    for scenario in track(scenarios, "tables", disable=quiet, console=Console(stderr=True)):
        evaluation.add(film(scenario, frames=frames))
    return evaluation


def write_tables(evaluation: Evaluation, directory: Path) -> list[Part]:
    """Write ``tables.html`` and ``scores.json`` into ``directory``. Raises InputError if that cannot be done."""
    return write_parts(TITLE, facts(evaluation), evaluation.parts(), directory)


def facts(evaluation: Evaluation) -> Sequence[str]:
    """What was filmed, in a few words each."""
    *_, own = evaluation.trackers.values()
    moments = sum(len(one.recording.steps) for one in own)
    images = sum(len(times) for one in own for times in one.seconds.values())
    lights = dict.fromkeys(light for one in own for light in one.lights.values())
    return (
        f"{len(evaluation.manifests)} sequences",
        f"{moments} moments",
        f"{images} frames",
        f"lights: {', '.join(lights)}",
    )
