"""Remade tables as files."""

from collections.abc import Sequence
from pathlib import Path

from bench.scores import write_scores
from bench.tables.page import tables_page
from bench.tables.part import Part
from contracts import InputError
from contracts.files import write_whole

PAGE_NAME = "tables.html"


def write_parts(title: str, facts: Sequence[str], parts: list[Part], directory: Path) -> list[Part]:
    """Write ``tables.html`` and ``scores.json`` into ``directory``. Raises InputError if that cannot be done."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write the tables into {directory}: {error.strerror}") from error
    write_whole(directory / PAGE_NAME, tables_page(title, facts, parts))
    write_scores(directory / "scores.json", [score for part in parts for score in part.scores])
    return parts
