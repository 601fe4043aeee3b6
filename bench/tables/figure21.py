"""Figure 21 of paper R: reconstructed against actual positions, and the mean squared error of each axis.

The paper prints "(0,00092, 0,000379) meter". A mean of squares is no length: either the unit is square metres, then
the root is 30 and 19 mm; or the figures are lengths, 0.92 and 0.38 mm. Ours stand beside both.
"""

from collections.abc import Sequence

import numpy as np

from bench.matching import gate_m
from bench.report.charts import INK, Figure, axis, layout
from bench.report.material import colours
from bench.scoring.ground import error_scores
from bench.scoring.population import Hits, fused_population
from bench.tables.films import Watched
from bench.tables.part import Grid, Part, number
from contracts import FloatArray

PAPER_MSE = (0.00092, 0.000379)  # x, y
POINTS = 10  # that the paper's chart shows


def figure21(watched: Sequence[Watched]) -> Part:
    """The fused positions of one method over all sequences."""
    hits = [fused_population(one.recording, gate_m(one.recording.manifest.world)).hits for one in watched]
    errors_m = np.concatenate([np.empty((0, 2)), *(one.errors_m for one in hits)])
    scores = error_scores("figure21", errors_m)
    value = {score.name.partition(".")[2]: score.value for score in scores}
    rows = tuple(
        (
            direction,
            number(value[f"mse_{name}_m2"], ".3g"),
            number(paper, "g"),
            number(value[f"rms_{name}_m"], ".3f", 1e3),
            number(paper**0.5, ".0f", 1e3),
            number(paper, ".2f", 1e3),
        )
        for direction, name, paper in zip(("x (east)", "y (north)"), "xy", PAPER_MSE, strict=True)
    )
    head = (
        "axis",
        "mean squared error, m²",
        "paper",
        "root, mm",
        "paper, if it means m²",
        "paper, if it means m",
    )
    says = (
        f"Fused positions of “{watched[0].method if watched else ''}”, calibrated cameras, every vehicle of which 80 "
        f"% is visible: {len(errors_m)} positions; 95 % are closer than {number(value['p95_m'], '.2f', 1e3)} mm, the "
        f"farthest {number(value['max_m'], '.2f', 1e3)} mm. The paper measured ten points with a caliper. The chart "
        "and the second table show ten of ours, evenly spread over the sequences."
    )
    ten = _spread(hits)
    return Part(
        "figure21",
        "Figure 21: positions on the ground",
        says,
        (Grid(head, rows), _points(ten)),
        (_scatter(ten),),
        tuple(scores),
    )


def _spread(hits: Sequence[Hits]) -> list[tuple[str, FloatArray, FloatArray]]:
    """Label, truth and estimate (2,) of ``POINTS`` positions."""
    everything = [
        (label, truth, estimate)
        for one in hits
        for label, truth, estimate in zip(one.object_labels, one.truths_m, one.estimates_m, strict=True)
    ]
    chosen = np.linspace(0, len(everything) - 1, min(POINTS, len(everything))).round().astype(int)
    return [everything[k] for k in chosen.tolist()]


def _points(ten: Sequence[tuple[str, FloatArray, FloatArray]]) -> Grid:
    rows = tuple(
        (
            label,
            *(number(float(v), ".4f") for v in (truth[0], estimate[0], truth[1], estimate[1])),
            *(number(float(v), "+.2f", 1e3) for v in estimate - truth),
        )
        for label, truth, estimate in ten
    )
    return Grid(("vehicle", "x true, m", "x found", "y true, m", "y found", "x error, mm", "y error, mm"), rows)


def _scatter(ten: Sequence[tuple[str, FloatArray, FloatArray]]) -> Figure:
    paint = colours((label, label) for label, _, _ in ten)
    true = {
        "x": [float(truth[0]) for _, truth, _ in ten],
        "y": [float(truth[1]) for _, truth, _ in ten],
        "name": "actual",
        "mode": "markers",
        "marker": {"color": INK, "size": 15, "symbol": "circle-open"},
        "hovertemplate": "actual %{x:.4f}, %{y:.4f} m<extra></extra>",
    }
    found = {
        "x": [float(estimate[0]) for _, _, estimate in ten],
        "y": [float(estimate[1]) for _, _, estimate in ten],
        "name": "reconstructed",
        "mode": "markers",
        "marker": {"color": [paint[label] for label, _, _ in ten], "size": 7},
        "hovertemplate": "found %{x:.4f}, %{y:.4f} m<extra></extra>",
    }
    return {
        "data": [true, found],
        "layout": layout(340, xaxis=axis("east, m"), yaxis=axis("north, m", scaleanchor="x", scaleratio=1)),
    }
