"""Speed and precision against the size of the tracked region: what paper R's section 3 B says in one sentence."""

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from bench.report.charts import Figure, axis, layout
from bench.scores import Score
from bench.tables.centres import AT_PX, cases, together
from bench.tables.films import Watched, frames_per_second
from bench.tables.part import Grid, Part, number

PAPER_FPS = 400.0  # "by reducing the size of the tracked region", on average
SPEED, PRECISION = "#1b6ca8", "#c8752b"
HEAD = ("region, vehicle sizes", "fps", "centre within 20 px", "within 1 px", "median error, px", "roof overlap")


def region(sizes: Mapping[float, Sequence[Watched]]) -> Part:
    """One row per size of the region.

    sizes: by the region's length over the vehicle's, what a correlation filter by itself made of each sequence.
    """
    measured = {size: _scores(size, watched) for size, watched in sizes.items()}
    rows = [(number(size, "g"), *_cells(scores)) for size, scores in measured.items()]
    paper = ("paper, reduced region", number(PAPER_FPS, "g"), *[number(None)] * (len(HEAD) - 2))
    says = (
        "A correlation filter by itself, started by a detection and never corrected, with regions from little more "
        "than the vehicle to several times its length and width; samples lie equally dense in all of them. Searches "
        "of the whole frame at the start, every 30 frames and on loss are in the time. The paper: “an average of "
        "400 fps can be reached by reducing the size of the tracked region, however, it reduces the precision”."
    )
    return Part(
        "region",
        "Speed and precision against the tracked region",
        says,
        (Grid(HEAD, (*rows, paper)),),
        (_chart(measured),) if measured else (),
        tuple(score for scores in measured.values() for score in scores),
    )


def _scores(size: float, watched: Sequence[Watched]) -> list[Score]:
    seen = together([cases(one.recording) for one in watched])
    seconds = list(chain.from_iterable(one.seconds.values() for one in watched))
    found = seen.distances_px[np.isfinite(seen.distances_px)]
    n, prefix = len(seen), f"region.{size:g}"
    at_20, at_1 = seen.precision(np.array([AT_PX, 1.0])).tolist() if n else (np.nan, np.nan)
    return [
        Score.of(f"{prefix}.fps", frames_per_second(seconds), "1/s", sum(map(len, seconds))),
        Score.of(f"{prefix}.within_20_px", at_20, "1", n),
        Score.of(f"{prefix}.within_1_px", at_1, "1", n),
        Score.of(f"{prefix}.median_px", float(np.median(found)) if len(found) else np.nan, "px", len(found)),
        Score.of(f"{prefix}.overlap", float(seen.overlaps.mean()) if n else np.nan, "1", n),
    ]


def _cells(scores: Sequence[Score]) -> list[str]:
    return [number(score.value, form) for score, form in zip(scores, (".0f", ".4f", ".4f", ".3f", ".3f"), strict=True)]


def _chart(measured: Mapping[float, Sequence[Score]]) -> Figure:
    sizes = list(measured)
    fps, within = ([scores[k].value for scores in measured.values()] for k in (0, 2))
    traces = [
        {"x": sizes, "y": fps, "name": "frames per second", "mode": "lines+markers", "line": {"color": SPEED}},
        {
            "x": sizes,
            "y": [None if value is None else 100 * value for value in within],
            "name": "centre within 1 px, %",
            "mode": "lines+markers",
            "line": {"color": PRECISION},
            "yaxis": "y2",
        },
    ]
    right = axis("within 1 px, %", overlaying="y", side="right", range=[0, 102], showgrid=False)
    left = axis("frames per second", rangemode="tozero")
    return {
        "data": traces,
        "layout": layout(
            340,
            xaxis=axis("region over vehicle"),
            yaxis=left,
            yaxis2=right,
            margin={"l": 56, "r": 56, "t": 12, "b": 44},
        ),
    }
