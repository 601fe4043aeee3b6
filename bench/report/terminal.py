"""The few figures that follow a run in the terminal."""

from collections.abc import Mapping
from pathlib import Path
from typing import Protocol

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bench.recording import Recording
from bench.report.headline import FIGURES, figure_text, population
from bench.scores import Score, by_name


class Outcome(Protocol):
    """What is shown of a finished run."""

    @property
    def directory(self) -> Path:
        """Where the run lies."""
        ...

    @property
    def recording(self) -> Recording:
        """What was recorded."""
        ...

    @property
    def scores(self) -> tuple[Score, ...]:
        """All scores."""
        ...

    @property
    def failures(self) -> tuple[str, ...]:
        """Expectations that were not met, one sentence each."""
        ...


def print_outcome(outcome: Outcome, console: Console | None = None) -> None:
    """Title, oracles if any, headline figures, expectations not met, and where the rest is."""
    console = console or Console()
    manifest = outcome.recording.manifest
    frames = len(outcome.recording.steps)
    console.print(f"\n[bold]{escape(manifest.title)}[/bold]")
    console.print(f"[dim]{escape(manifest.scenario)}, seed {manifest.seed}, {frames} frames[/dim]")
    for oracle in manifest.oracles:
        console.print(f"[bold yellow]oracle[/bold yellow]  the stage '{escape(oracle)}' was given the truth")
    console.print(summary(by_name(outcome.scores)))
    for failure in outcome.failures:
        console.print(f"[bold red]not met[/bold red]  {escape(failure)}")
    console.print(f"[dim]{escape(str(outcome.directory))}[/dim]")


def summary(scores: Mapping[str, Score]) -> Table:
    """The headline figures, one line each."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column()
    table.add_column(justify="right")
    table.add_column(justify="right", style="dim")
    for figure in FIGURES:
        table.add_row(figure.words, figure_text(figure, scores), f"n = {population(figure, scores)}")
    return table
