"""The parts of a remade evaluation on a terminal and as one self-contained page."""

from collections.abc import Sequence
from html import escape

from rich.console import Console
from rich.table import Table

from bench.report import tables
from bench.report.charts import Figure
from bench.report.document import chart, document, section
from bench.tables.part import Grid, Part

LEAST_WIDTH = 120  # columns, where nobody says how many there are


def print_parts(parts: Sequence[Part], console: Console | None = None) -> None:
    """Every part's title, explanation and tables."""
    console = console or Console()
    if not console.is_terminal:
        console.width = max(console.width, LEAST_WIDTH)
    for part in (part for part in parts if part.grids):
        console.print(f"\n[bold]{part.title}[/bold]")
        console.print(part.says, style="dim", highlight=False, markup=False)
        for grid in part.grids:
            console.print(_terminal(grid))


def tables_page(title: str, facts: Sequence[str], parts: Sequence[Part]) -> str:
    """All parts with their charts. facts: what was filmed and how much, in a few words each."""
    charts: dict[str, Figure] = {}
    sections = [section(part.title, part.says, _content(part, charts)) for part in parts]
    header = (
        f"<header><h2>{escape(title)}</h2><p class='facts'>{' · '.join(escape(fact) for fact in facts)}</p></header>"
    )
    return document(title, charts, articles=f"<article>{header}{''.join(sections)}</article>")


def _content(part: Part, charts: dict[str, Figure]) -> str:
    drawn = [chart(charts, f"{part.name}-{k}", figure) for k, figure in enumerate(part.charts)]
    shown = f'<div class="pair">{"".join(drawn)}</div>' if len(drawn) > 1 else "".join(drawn)
    return "".join(tables.table(grid.head, grid.rows) for grid in part.grids) + shown + part.picture


def _terminal(grid: Grid) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for k, name in enumerate(grid.head):
        table.add_column(name, justify="right" if k else "left")
    for row in grid.rows:
        table.add_row(*row)
    return table
