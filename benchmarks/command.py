"""What benchmarks have in common as commands: how long they measure, and how they say what they found."""

import argparse
from collections.abc import Callable, Sequence

from rich.console import Console

from bench.scores import Score, table, to_json


def run(title: str, doc: str | None, measure: Callable[[int], Sequence[Score]], *, frames: int) -> None:
    """A benchmark that is asked for nothing but how many frames to take; ``frames`` if it is not said."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--frames", type=int, default=frames)
    arguments = parser.parse_args()
    show(measure(arguments.frames), title=title, json=arguments.json)


def show(scores: Sequence[Score], *, title: str, json: bool) -> None:
    """Print the scores for people, or as JSON and nothing else."""
    if json:
        print(to_json(scores))
    else:
        Console().print(table(scores, title=title))
