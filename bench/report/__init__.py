"""What people read of a run: a summary in the terminal and one self-contained HTML page."""

from collections.abc import Sequence
from pathlib import Path

from bench.report.material import read_run
from bench.report.page import page
from contracts import InputError
from contracts.files import write_whole


def write_report(directories: Sequence[Path], path: Path) -> None:
    """Write one page about the runs in ``directories``; it needs no network and no other file.

    Several runs are compared first, then shown one after the other.
    Raises InputError if a run cannot be read or the page cannot be written; then no page is left behind.
    """
    if not directories:
        raise InputError("a report needs at least one run directory")
    write_whole(path, page([read_run(directory) for directory in directories]))
