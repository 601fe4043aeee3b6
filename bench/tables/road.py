"""``gantry tables road``: paper T's evaluation, remade on frames whose truth is known."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.progress import track

from bench.tables.part import Part
from bench.tables.ranges import ByCalibrator, errors_by_place, flat_ground, ranges
from bench.tables.road_film import CALIBRATORS, FilmedCamera, film_road
from bench.tables.road_picture import road_picture
from bench.tables.tablea1 import Projected, lane_paths, project_lanes, table_a1
from bench.tables.written import write_parts
from contracts import InputError
from scenarios.loader import load_scenario
from scenarios.schema import RoadScenario

TITLE = "Paper T's tables, remade"
DEFAULT = ("crossroads-day", "avenue-day", "merge-day", "roundabout-day")


@dataclass
class RoadEvaluation:
    """What every calibrator made of every camera so far."""

    lanes: dict[str, list[Projected]] = field(default_factory=lambda: {name: [] for name in CALIBRATORS})
    places: ByCalibrator = field(default_factory=lambda: {name: [] for name in CALIBRATORS})
    flat: ByCalibrator = field(default_factory=lambda: {name: [] for name in CALIBRATORS})  # where the road climbs
    refused: dict[str, int] = field(default_factory=lambda: dict.fromkeys(CALIBRATORS, 0))
    cameras: int = 0
    picture: Part | None = None  # of the first camera that finds a lane

    def add(self, filmed: FilmedCamera) -> None:
        """Project the lanes of one camera, and every place that it sees."""
        self.cameras += 1
        paths = lane_paths(filmed)
        for name in CALIBRATORS:
            if isinstance(filmed.found[name], str):
                self.refused[name] += 1
                continue
            self.lanes[name] += project_lanes(filmed, paths, name, filmed.scenario.seed)
            self.places[name].append(errors_by_place(filmed, name))
            if filmed.ground is not None:
                self.flat[name].append(errors_by_place(filmed, name, flat=True))
        if self.picture is None and paths:
            self.picture = road_picture(filmed, paths)

    def parts(self) -> list[Part]:
        """All tables and the picture."""
        parts = [table_a1(self.lanes), ranges(self.places, self.refused)]
        if any(self.flat.values()):
            parts.append(flat_ground(self.flat, self.refused))
        return [*parts, self.picture] if self.picture else parts


def roads(names: Sequence[str]) -> list[RoadScenario]:
    """The scenarios of these names, or one of each network by day. Raises InputError for a scenario of the rail."""
    chosen = []
    for name in names or DEFAULT:
        scenario = load_scenario(name)
        if not isinstance(scenario, RoadScenario):
            raise InputError(f"{name} is no scenario of the road")
        chosen.append(scenario)
    return chosen


def evaluate(scenarios: Sequence[RoadScenario], *, seeds: int = 1, quiet: bool = False) -> RoadEvaluation:
    """Film every scenario under its own seed and the next ones, each with cameras hung anew, and calibrate them.

    Raises InputError without any seed.
    """
    if seeds < 1:
        raise InputError(f"--seeds {seeds}: at least one is needed")
    evaluation = RoadEvaluation()
    runs = [(scenario, scenario.seed + k) for scenario in scenarios for k in range(seeds)]
    for scenario, seed in track(runs, "tables", disable=quiet, console=Console(stderr=True)):
        for filmed in film_road(scenario, seed=seed):
            evaluation.add(filmed)
    return evaluation


def write_tables(evaluation: RoadEvaluation, scenarios: Sequence[RoadScenario], directory: Path) -> list[Part]:
    """Write the page and ``scores.json`` into ``directory``. Raises InputError if that cannot be done."""
    networks = ", ".join(dict.fromkeys(scenario.network for scenario in scenarios))
    return write_parts(TITLE, [f"networks: {networks}", f"{evaluation.cameras} cameras"], evaluation.parts(), directory)
