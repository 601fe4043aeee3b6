"""The command ``gantry``. Heavy imports stay inside the commands, so that ``gantry --help`` answers at once.

Exit status: 0 fine, 1 an expectation failed or two runs differ, 2 wrong input (one sentence, no traceback), 128 and
the signal's number when stopped from outside: 130 by Ctrl-C.
"""

import signal
import sys
from enum import StrEnum
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from bench.commands import owners
from contracts.errors import GantryError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bench.jobs import Outcome
    from bench.scores import Score
    from bench.tables.part import Part

EXPECTATION_FAILED = 1
WRONG_INPUT = 2
_STOPPING = (signal.SIGINT, signal.SIGTERM)

app = typer.Typer(
    help="A test bench for overhead cameras: simulate, film, see, locate, and score against exact truth.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

tables = typer.Typer(help="Remake the papers' tables on frames whose truth is known.", no_args_is_help=True)
app.add_typer(tables, name="tables")

app.add_typer(owners.app, name="calibrate")
app.command()(owners.locate)
app.command()(owners.views)

RunDirectory = Annotated[Path, typer.Argument(help="A run directory.", metavar="RUN")]


class Contract(StrEnum):
    """What ``gantry check`` can examine."""

    DETECTOR = "detector"
    TRACKER = "tracker"
    PERCEIVER = "perceiver"
    ANALYST = "analyst"


class ExportFormat(StrEnum):
    """What ``gantry export`` writes."""

    MOT = "mot"
    COCO = "coco"
    GEOJSON = "geojson"
    IMAGES = "images"


@app.command("list")
def list_() -> None:
    """List the scenarios of the library."""
    from rich.console import Console
    from rich.table import Table

    from scenarios.loader import list_scenarios, load_scenario

    table = Table("scenario", "world", "split", "title", box=None)
    for name in list_scenarios():
        scenario = load_scenario(name)
        table.add_row(name, scenario.world, scenario.split or "", scenario.title)
    Console().print(table)


@app.command()
def run(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Names or TOML files.", metavar="SCENARIO...")] = None,
    detector: Annotated[
        str | None, typer.Option(help="In every frame: hbp, crd, ccr, gmm, or your own: my_pkg.mod:Mine.")
    ] = None,
    tracker: Annotated[str | None, typer.Option(help="Your own: my_pkg.mod:Mine.")] = None,
    perceiver: Annotated[
        str | None, typer.Option(help="Detector and tracker in one: hybrid, kcf, mosse, or your own: my_pkg.mod:Mine.")
    ] = None,
    model: Annotated[Path | None, typer.Option(help="Colour models from gantry learn.")] = None,
    locator: Annotated[
        str | None, typer.Option(help="ray; map, the road's own; or plane0, the naive projection to z = 0.")
    ] = None,
    analyst: Annotated[str | None, typer.Option(help="Your own: my_pkg.mod:Mine.")] = None,
    oracle: Annotated[list[str] | None, typer.Option(help="Give a stage the truth: detect, calibrate, locate.")] = None,
    calibrator: Annotated[str | None, typer.Option(help="Of the road: picks (by hand), or frames alone.")] = None,
    renderer: Annotated[str, typer.Option(help="layered, or full: slow, its oracle.")] = "layered",
    seed: Annotated[int | None, typer.Option(help="Instead of the scenario's own.")] = None,
    noise_seed: Annotated[int | None, typer.Option(help="Of the sensors alone; nothing else changes.")] = None,
    out: Annotated[Path | None, typer.Option(help="Run directory; runs/NAME if not given.")] = None,
    frames: Annotated[bool, typer.Option("--frames", help="Record the frames themselves.")] = False,
    video: Annotated[Path | None, typer.Option(help="Real footage instead of a scenario.")] = None,
    camera: Annotated[Path | None, typer.Option(help="Camera file of the real footage.")] = None,
    fps: Annotated[float | None, typer.Option(help="Frames per second of a folder of images.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the scores as JSON and nothing else.")] = False,
) -> None:
    """Run scenarios through the chain and score them, or send real footage through the same chain."""
    from bench.jobs import run_footage, run_scenario
    from bench.report.terminal import print_outcome
    from bench.scores import to_json
    from bench.wiring import Stages
    from contracts import InputError
    from perception.colour_models import SHIPPED
    from scenarios.loader import load_scenario

    stages = Stages(
        detector=detector,
        tracker=tracker,
        perceiver=perceiver,
        model=model or SHIPPED,
        locator=locator,
        analyst=analyst,
        calibrator=calibrator,
        oracles=tuple(oracle or ()),
        renderer=renderer,
    )
    if bool(scenarios) == bool(video) or bool(video) != bool(camera):
        raise InputError("run takes either scenarios, or --video FILE together with --camera CAM.yaml")
    if video:
        _refuse("footage is what it is: leave {} away", seed=seed, noise_seed=noise_seed, calibrator=calibrator)
    else:
        _refuse("a scenario says its own frames per second: leave {} away", fps=fps)
    outcomes = []
    if video and camera:
        outcomes.append(
            run_footage(
                video, camera, stages, out or Path("runs") / video.stem, fps=fps, keep_frames=frames, quiet=json
            )
        )
    for scenario in [load_scenario(name) for name in scenarios or ()]:
        several = out is not None and len(scenarios or ()) > 1
        directory = (out / scenario.name if several else out) if out else Path("runs") / scenario.name
        outcomes.append(
            run_scenario(scenario, stages, directory, seed=seed, noise_seed=noise_seed, keep_frames=frames, quiet=json)
        )
    if json:
        print(to_json(_all_scores(outcomes)))
    else:
        for outcome in outcomes:
            print_outcome(outcome)
    if any(outcome.failures for outcome in outcomes):
        raise typer.Exit(EXPECTATION_FAILED)


@app.command()
def score(
    directory: RunDirectory,
    json: Annotated[bool, typer.Option("--json", help="Print the scores as JSON and nothing else.")] = False,
) -> None:
    """Score a recorded run again; nothing is simulated."""
    from bench.jobs import rescore
    from bench.report.terminal import print_outcome
    from bench.scores import to_json

    outcome = rescore(directory)
    if json:
        print(to_json(outcome.scores))
    else:
        print_outcome(outcome)


@app.command()
def report(
    directories: Annotated[list[Path], typer.Argument(help="Run directories.", metavar="RUN...")],
    out: Annotated[Path | None, typer.Option(help="HTML file; report.html in the first run if not given.")] = None,
) -> None:
    """Write the HTML report of one run, or compare several."""
    from bench.report import write_report

    path = out or directories[0] / "report.html"
    write_report(directories, path)
    print(path)


@app.command()
def diff(
    first: RunDirectory,
    second: RunDirectory,
) -> None:
    """Name the first frame and stage in which two runs differ, or say that they are equal."""
    from bench.diff import first_difference
    from bench.recording_file import load_recording

    difference = first_difference(load_recording(first), load_recording(second))
    print(difference or "equal")
    if difference:
        raise typer.Exit(EXPECTATION_FAILED)


@app.command()
def export(
    directory: RunDirectory,
    to: Annotated[ExportFormat, typer.Option(help="Format.")],
    out: Annotated[Path | None, typer.Option(help="Directory; RUN/export-FORMAT if not given.")] = None,
) -> None:
    """Write a recorded run in a format that other tools read."""
    from bench.export import export_run

    print(export_run(directory, to.value, out or directory / f"export-{to.value}"))


@app.command()
def check(
    contract: Annotated[Contract, typer.Argument(help="What it claims to be.")],
    path: Annotated[str, typer.Argument(help="my_pkg.mod:Mine", metavar="PATH")],
    frames: Annotated[Path | None, typer.Option(help="Try it on this run's recorded frames, too.")] = None,
    camera: Annotated[str | None, typer.Option(help="The camera whose frames are taken.")] = None,
) -> None:
    """Examine whether a plug-in keeps the contract of its stage."""
    from bench.check import check_plugin
    from bench.recording_file import load_frames
    from contracts import InputError

    if (frames is None) != (camera is None):
        raise InputError("check takes --frames RUN together with --camera NAME")
    shown = list(load_frames(frames, camera)) if frames and camera else []
    findings = check_plugin(contract.value, path, shown)
    for finding in findings:
        print(finding)
    if findings:
        raise typer.Exit(EXPECTATION_FAILED)
    print(f"{path} keeps the contract of {'an' if contract is Contract.ANALYST else 'a'} {contract.value}")


@app.command()
def learn(
    frames: Annotated[
        list[Path], typer.Argument(help="Runs recorded with --frames, or COCO files.", metavar="FRAMES...")
    ],
    out: Annotated[Path, typer.Option(help="The model file to write.")],
    baselines: Annotated[Path | None, typer.Option(help="The file of the baselines' colours to write, too.")] = None,
) -> None:
    """Learn the vehicles' colour models from training frames."""
    from bench.learn import learn_models

    learn_models(frames, out, baselines=baselines)
    print(out)


@tables.command("rail")
def tables_rail(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Names or TOML files.", metavar="SCENARIO...")] = None,
    split: Annotated[str | None, typer.Option(help="All so marked: test (if none is named) or train.")] = None,
    frames: Annotated[int | None, typer.Option(help="Film at most so many frames of each camera.")] = None,
    out: Annotated[Path, typer.Option(help="Directory of the page and the scores.")] = Path("runs/tables-rail"),
    json: Annotated[bool, typer.Option("--json", help="Print the scores as JSON and nothing else.")] = False,
) -> None:
    """Remake the rail paper's tables and figures, each figure beside the paper's."""
    from bench.tables.rail import evaluate, sequences, write_tables

    parts = write_tables(evaluate(sequences(scenarios or (), split), frames=frames, quiet=json), out)
    _show_tables(parts, out, json=json)


@tables.command("road")
def tables_road(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Names or TOML files.", metavar="SCENARIO...")] = None,
    seeds: Annotated[int, typer.Option(help="Hang the cameras anew so many times.")] = 1,
    out: Annotated[Path, typer.Option(help="Directory of the page and the scores.")] = Path("runs/tables-road"),
    json: Annotated[bool, typer.Option("--json", help="Print the scores as JSON and nothing else.")] = False,
) -> None:
    """Remake the traffic paper's localisation table, and show what its protocol hides."""
    from bench.tables.road import evaluate, roads, write_tables

    chosen = roads(scenarios or ())
    _show_tables(write_tables(evaluate(chosen, seeds=seeds, quiet=json), chosen, out), out, json=json)


@app.command()
def plant(
    name: Annotated[str, typer.Argument(help="Name or TOML file of a plant.")],
    out: Annotated[Path, typer.Option(help="The SVG file to write.")],
) -> None:
    """Draw a plant to scale."""
    from contracts.files import write_whole
    from rail.drawing import plant_svg
    from scenarios.plant_file import load_plant

    write_whole(out, plant_svg(load_plant(name)))
    print(out)


@app.command("map")
def map_(
    scenario: Annotated[str, typer.Argument(help="Name or TOML file of a scenario of the road.")],
    out: Annotated[Path, typer.Option(help="The GeoJSON file to write.")],
) -> None:
    """Write the HD map that the owners of a road's cameras have, its survey's errors included."""
    from contracts import InputError
    from georef.hd_map_file import write_map
    from scenarios.loader import load_scenario
    from scenarios.schema import RoadScenario
    from scenarios.worlds import maps_of

    chosen = load_scenario(scenario)
    if not isinstance(chosen, RoadScenario):
        raise InputError(f"{scenario} is no scenario of the road: it has no map")
    _, owners_map = maps_of(chosen)
    write_map(out, owners_map)
    print(out)


def _refuse(reason: str, **options: object) -> None:
    """Raise InputError for the first of ``options`` that was given, named in ``reason`` as the command line says it."""
    from contracts import InputError

    for name, value in options.items():
        if value is not None:
            raise InputError(reason.format(f"--{name.replace('_', '-')} {value}"))


def _show_tables(parts: "Sequence[Part]", out: Path, *, json: bool) -> None:
    from bench.scores import to_json
    from bench.tables.page import print_parts
    from bench.tables.written import PAGE_NAME

    if json:
        print(to_json([score for part in parts for score in part.scores]))
    else:
        print_parts(parts)
        print(out / PAGE_NAME)


def _all_scores(outcomes: "Sequence[Outcome]") -> "list[Score]":
    """The scores of all runs; each name begins with its scenario's where there are several runs."""
    from dataclasses import replace

    if len(outcomes) == 1:
        return list(outcomes[0].scores)
    return [
        replace(score, name=f"{outcome.recording.manifest.scenario}.{score.name}")
        for outcome in outcomes
        for score in outcome.scores
    ]


class Stopped(SystemExit):
    """The command was told to end by a signal, whose number is on top of 128 in the exit status."""


def _stop(number: int, _: FrameType | None) -> None:
    """End as an error would, so that what is half-made is cleared away; another signal must not disturb that."""
    for each in _STOPPING:
        signal.signal(each, signal.SIG_IGN)
    raise Stopped(128 + number)


def main() -> None:
    """Entry point: an error that Gantry raises on purpose, or a stop from outside, is one sentence and no traceback."""
    for number in _STOPPING:
        if signal.getsignal(number) is not signal.SIG_IGN:  # as a shell does for what runs in the background
            signal.signal(number, _stop)
    try:
        app()
    except GantryError as error:
        print(f"gantry: {error}", file=sys.stderr)
        sys.exit(WRONG_INPUT)
    except Stopped:
        print("gantry: stopped before the end", file=sys.stderr)
        raise
