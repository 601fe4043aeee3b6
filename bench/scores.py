"""A score: one number with its name, unit and population."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
from rich.table import Table

from contracts import InputError
from contracts.files import write_whole


@dataclass(frozen=True)
class Score:
    """One figure about a run.

    name: dotted and stable, for example ``ground.rms_x_m``.
    value: None where there was nothing to measure; never 0 for lack of a population.
    unit: ``m``, ``px``, ``rad``, ... ; ``1`` for a ratio, ``count`` for a number of things.
    n: size of the population that ``value`` summarises.
    valid: whether ``value`` says anything.
    """

    name: str
    value: float | None
    unit: str
    n: int
    valid: bool

    def __post_init__(self) -> None:
        if self.n < 0:
            raise InputError(f"Score {self.name}: a population of {self.n} is negative")
        if self.valid != (self.value is not None and math.isfinite(self.value)):
            raise InputError(f"Score {self.name}: value {self.value} and valid = {self.valid} contradict each other")

    @classmethod
    def of(cls, name: str, value: float, unit: str, n: int) -> "Score":
        """``value`` over a population of ``n``; not valid if that is empty or the value is not finite."""
        if n > 0 and math.isfinite(value):
            return cls(name, float(value), unit, int(n), True)
        return cls(name, None, unit, int(n), False)


def by_name(scores: Iterable[Score]) -> dict[str, Score]:
    """Scores by their names. Raises InputError if two have the same one."""
    named: dict[str, Score] = {}
    for score in scores:
        if score.name in named:
            raise InputError(f"two scores are named {score.name}")
        named[score.name] = score
    return named


def to_json(scores: Sequence[Score]) -> str:
    """A list of ``{name, value, unit, n, valid}``; a score that is not valid has the value null."""
    return msgspec.json.format(msgspec.json.encode(list(scores)), indent=2).decode()


def from_json(text: str | bytes, *, source: str = "scores") -> tuple[Score, ...]:
    """The inverse of ``to_json``. Raises InputError naming ``source``."""
    try:
        return tuple(msgspec.json.decode(text, type=list[Score], strict=True))
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise InputError(f"{source} is not a list of scores: {error}") from error


def write_scores(path: Path, scores: Sequence[Score]) -> None:
    """Write ``scores.json``. Raises InputError if it cannot be written."""
    write_whole(path, to_json(scores) + "\n")


def read_scores(path: Path) -> tuple[Score, ...]:
    """Read ``scores.json``. Raises InputError if it is missing or broken."""
    try:
        return from_json(path.read_bytes(), source=str(path))
    except OSError as error:
        raise InputError(f"cannot read the scores {path}: {error.strerror}") from error


def value_text(score: Score) -> str:
    """The value as people read it: four significant digits, counts whole, an em dash where there is none."""
    if score.value is None:
        return "—"
    if score.unit == "count":
        return f"{score.value:.0f}"
    return f"{score.value:.4g}"


def unit_text(score: Score) -> str:
    """The unit as people read it; nothing for ratios and counts."""
    return {"1": "", "count": "", "m2": "m²"}.get(score.unit, score.unit)


def table(scores: Iterable[Score], *, title: str | None = None) -> Table:
    """The scores as a table for the terminal."""
    rows = Table(title=title, title_justify="left", box=None, pad_edge=False)
    rows.add_column("score")
    rows.add_column("value", justify="right")
    rows.add_column("unit")
    rows.add_column("n", justify="right", style="dim")
    for score in scores:
        rows.add_row(
            score.name, value_text(score), unit_text(score), str(score.n), style=None if score.valid else "dim"
        )
    return rows
