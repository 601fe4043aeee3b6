"""``make accuracy``: film the whole rail, hold every expectation, and write the figures into docs/accuracy.md.

Each figure comes with the command that makes it, so that a reader can run it alone.
"""

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from bench.jobs import Outcome, run_scenario
from bench.scores import Score, by_name
from bench.wiring import Stages
from contracts.files import write_whole
from scenarios.loader import list_scenarios, load_scenario
from scenarios.schema import RailScenario

DOCUMENT = Path(__file__).parents[1] / "docs" / "accuracy.md"
BEGIN, END = "<!-- figures: begin -->", "<!-- figures: end -->"
RUNS = Path("runs/accuracy")
MAIN_JOB = "oval-two-vehicles"
TRAINING_PREFIX = "train-"
COLUMNS = {  # heading -> (score, factor to the printed unit, format)
    "recall": ("detection.recall", 1.0, "{:.4f}"),
    "precision": ("detection.precision", 1.0, "{:.4f}"),
    "RMS x, mm": ("ground.rms_x_m", 1e3, "{:.2f}"),
    "RMS y, mm": ("ground.rms_y_m", 1e3, "{:.2f}"),
    "p95, mm": ("ground.p95_m", 1e3, "{:.2f}"),
    "z = 0: RMS x, mm": ("ground_z0.rms_x_m", 1e3, "{:.2f}"),
    "z = 0: RMS y, mm": ("ground_z0.rms_y_m", 1e3, "{:.2f}"),
    "in own 90 % ellipse": ("ground.coverage_90", 1.0, "{:.3f}"),
}


def main() -> None:
    """Run everything, rewrite the figures, and exit with 1 where an expectation failed."""
    main_job = list(_main_job_by_oracle())
    library = [_filmed(name) for name in list_scenarios() if _has_film(name)]
    text = DOCUMENT.read_text(encoding="utf-8")
    head, _, rest = text.partition(BEGIN)
    _, _, tail = rest.partition(END)
    figures = "\n\n".join([_table("stages", main_job), _table("scenario", library)])
    write_whole(DOCUMENT, f"{head}{BEGIN}\n\n{figures}\n\n{END}{tail}")
    failures = [f"{command}: {failure}" for command, outcome in library for failure in outcome.failures]
    for failure in failures:
        print(failure, file=sys.stderr)
    sys.exit(1 if failures else 0)


def _has_film(name: str) -> bool:
    """Training films are for learning; the road has no detector of its own, `gantry tables road` measures it."""
    return not name.startswith(TRAINING_PREFIX) and isinstance(load_scenario(name), RailScenario)


def _main_job_by_oracle() -> Iterator[tuple[str, Outcome]]:
    """The main job with its honest chain and with each stage replaced by the truth: who owns the error."""
    scenario = load_scenario(MAIN_JOB)
    for oracles in [(), ("calibrate",), ("detect",), ("detect", "calibrate")]:
        flags = "".join(f" --oracle {oracle}" for oracle in oracles)
        directory = RUNS / "-".join((MAIN_JOB, *oracles))
        yield f"`gantry run {MAIN_JOB}{flags}`", run_scenario(scenario, Stages(oracles=oracles), directory)


def _filmed(name: str) -> tuple[str, Outcome]:
    return f"`gantry run {name}`", run_scenario(load_scenario(name), Stages(), RUNS / name)


def _table(first: str, outcomes: Sequence[tuple[str, Outcome]]) -> str:
    rows = [f"| {' | '.join([first, *COLUMNS])} |", f"|{' --- |' * (len(COLUMNS) + 1)}"]
    for command, outcome in outcomes:
        scores = by_name(outcome.scores)
        cells = [_cell(scores, *column) for column in COLUMNS.values()]
        rows.append(f"| {' | '.join([command, *cells])} |")
    return "\n".join(rows)


def _cell(scores: Mapping[str, Score], name: str, factor: float, form: str) -> str:
    score = scores.get(name)
    return "-" if score is None or score.value is None else form.format(score.value * factor)


if __name__ == "__main__":
    main()
