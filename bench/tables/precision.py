"""The precision plot and a success plot of the trackers, over all sequences together (paper R, figure 18)."""

from collections.abc import Mapping, Sequence
from itertools import chain

import numpy as np

from bench.report.charts import Figure, axis, layout
from bench.scores import Score
from bench.tables.centres import AT_PX, DISTANCE_STEPS_PX, OVERLAP_STEPS, Cases, cases, together
from bench.tables.films import Watched, frames_per_second
from bench.tables.part import Grid, Part, number, slug

COLOURS = ("#1b6ca8", "#c8752b", "#4a8a3a", "#7a4fa3", "#a33f6b", "#3a8f8a", "#5b6470")
HEAD = ("tracker", "centre within 20 px", "within 1 px", "median error, px", "success (area)", "roof overlap", "fps")


def precision(trackers: Mapping[str, Sequence[Watched]]) -> Part:
    """One row and one curve per tracker.

    trackers: by the tracker's name, what it made of each sequence.
    """
    seen = {name: together([cases(one.recording) for one in watched]) for name, watched in trackers.items()}
    scores = [score for name, watched in trackers.items() for score in _scores(name, seen[name], watched)]
    rows = [_row(name, [one for one in scores if one.name.startswith(f"precision.{slug(name)}.")]) for name in trackers]
    says = (
        "Left: share of the vehicles to be found whose roof's centre was placed within a distance in the image. "
        "Right: share whose roof was overlapped by more than a share (IoU of rotated rectangles). A vehicle that is "
        "lost, or is tracked under another's name, is outside of every threshold. Every tracker saw the same "
        "frames. The paper quotes its figure 18 from other videos, so there is no figure of its own to stand beside "
        "these."
    )
    charts = (
        _curves(seen, "distance of the centres, px", DISTANCE_STEPS_PX, "precision", logarithmic=True),
        _curves(seen, "overlap", OVERLAP_STEPS, "success", logarithmic=False),
    )
    return Part("precision", "Precision and success", says, (Grid(HEAD, tuple(rows)),), charts, tuple(scores))


def _scores(name: str, seen: Cases, watched: Sequence[Watched]) -> list[Score]:
    seconds = list(chain.from_iterable(one.seconds.values() for one in watched))
    found = seen.distances_px[np.isfinite(seen.distances_px)]
    n, prefix = len(seen), f"precision.{slug(name)}"
    at_20, at_1 = seen.precision(np.array([AT_PX, 1.0])).tolist() if n else (np.nan, np.nan)
    return [
        Score.of(f"{prefix}.within_20_px", at_20, "1", n),
        Score.of(f"{prefix}.within_1_px", at_1, "1", n),
        Score.of(f"{prefix}.median_px", float(np.median(found)) if len(found) else np.nan, "px", len(found)),
        Score.of(f"{prefix}.success_area", float(seen.success(OVERLAP_STEPS).mean()) if n else np.nan, "1", n),
        Score.of(f"{prefix}.overlap", float(seen.overlaps.mean()) if n else np.nan, "1", n),
        Score.of(f"{prefix}.fps", frames_per_second(seconds), "1/s", sum(map(len, seconds))),
    ]


def _row(name: str, scores: Sequence[Score]) -> tuple[str, ...]:
    forms = (".4f", ".4f", ".3f", ".3f", ".3f", ".1f")
    return (name, *(number(score.value, form) for score, form in zip(scores, forms, strict=True)))


def _curves(seen: Mapping[str, Cases], title: str, steps: np.ndarray, kind: str, *, logarithmic: bool) -> Figure:
    traces = [
        {
            "x": steps.tolist(),
            "y": (100 * (one.precision(steps) if kind == "precision" else one.success(steps))).tolist(),
            "name": name,
            "mode": "lines",
            "line": {"color": COLOURS[k % len(COLOURS)], "width": 2},
            "hovertemplate": f"{name}<br>%{{x:.3g}}: %{{y:.2f}} %<extra></extra>",
        }
        for k, (name, one) in enumerate(seen.items())
        if len(one)
    ]
    scale = {"type": "log", "dtick": 1} if logarithmic else {"range": [0, 1]}
    return {
        "data": traces,
        "layout": layout(360, xaxis=axis(title, **scale), yaxis=axis(f"{kind}, %", range=[0, 102])),
    }
