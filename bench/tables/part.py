"""A part of the remade evaluation, before anybody has decided whether it goes to a terminal, a page or a program."""

from dataclasses import dataclass

from bench.report.charts import Figure
from bench.scores import Score

UNKNOWN = "—"


@dataclass(frozen=True)
class Grid:
    """A table as text: the first column says what, the others are figures."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True, eq=False)
class Part:
    """One table or figure of the paper.

    name: short and stable, for the names of charts. says: what was measured how, in a sentence or two.
    scores: the figures for programs; their names begin with ``name``.
    picture: HTML of a figure that is no chart; on the page only.
    """

    name: str
    title: str
    says: str
    grids: tuple[Grid, ...] = ()
    charts: tuple[Figure, ...] = ()
    scores: tuple[Score, ...] = ()
    picture: str = ""


def slug(name: str) -> str:
    """A method's or light's name as a part of a score's: no spaces in it."""
    return name.replace(" ", "_")


def number(value: float | None, form: str = ".2f", factor: float = 1.0) -> str:
    """``value`` times ``factor`` as text, a dash where it is None or NaN."""
    return UNKNOWN if value is None or value != value else f"{value * factor:{form}}"  # noqa: PLR0124 - NaN alone differs from itself
