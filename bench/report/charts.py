"""The charts as Plotly figures: plain dictionaries, drawn by the vendored bundle. Errors are shown in millimetres."""

from html import escape
from typing import Any

import numpy as np

from bench.report.material import ReportedRun, run_colours, seconds
from bench.scoring.ground import known_rows, normalised_squares, rms
from bench.scoring.population import Hits
from contracts import FloatArray

Figure = dict[str, Any]

INK, MUTED, GRID, TRACK = "#1d2126", "#6b7077", "#e8e6e1", "#c4beb1"
EAST, NORTH = "#1b6ca8", "#c8752b"
FONT = {"family": "system-ui, 'Segoe UI', 'Helvetica Neue', Arial, sans-serif", "size": 13, "color": INK}


def axis(title: str, **more: Any) -> dict[str, Any]:
    """A quiet axis with a title."""
    plain = {"gridcolor": GRID, "zerolinecolor": TRACK, "linecolor": TRACK, "tickcolor": TRACK, "ticks": "outside"}
    return plain | {"title": {"text": title, "font": {"color": MUTED}, "standoff": 8}, "automargin": True} | more


def layout(height_px: int, **more: Any) -> dict[str, Any]:
    """The look that all charts share."""
    plain = {
        "height": height_px,
        "font": FONT,
        "margin": {"l": 56, "r": 16, "t": 12, "b": 44},
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "hovermode": "closest",
        "legend": {"orientation": "h", "x": 0, "y": 1.02, "yanchor": "bottom", "itemsizing": "constant"},
    }
    return plain | more


def error_over_time(run: ReportedRun) -> Figure:
    """East and north error of every vehicle over time; a gap where it was not found."""
    hits, paint = run.fused.hits, run_colours(run)
    traces = []
    for name in dict.fromkeys(hits.objects):
        rows = rows_of(hits, name)
        time_s, errors_mm = _with_gaps(hits.index[rows], seconds(hits.time_ns[rows]), 1000 * hits.errors_m[rows])
        for k, direction in enumerate(("east", "north")):
            traces.append(
                {
                    "x": time_s,
                    "y": errors_mm[k],
                    "yaxis": f"y{k + 1}" if k else "y",
                    "name": escape(name),
                    "legendgroup": name,
                    "showlegend": k == 0,
                    "mode": "lines",
                    "line": {"color": paint[name], "width": 1.4},
                    "hovertemplate": f"{escape(name)}<br>%{{x:.2f}} s: %{{y:.2f}} mm {direction}<extra></extra>",
                }
            )
    return {
        "data": traces,
        "layout": layout(
            440,
            xaxis=axis("time, s", anchor="y2"),
            yaxis=axis("east, mm", domain=[0.54, 1.0]),
            yaxis2=axis("north, mm", domain=[0.0, 0.46]),
        ),
    }


def error_cloud(run: ReportedRun) -> Figure:
    """Every error as a point, east against north."""
    hits, paint = run.fused.hits, run_colours(run)
    traces = [
        {
            "x": (1000 * hits.errors_m[rows, 0]).tolist(),
            "y": (1000 * hits.errors_m[rows, 1]).tolist(),
            "name": escape(name),
            "mode": "markers",
            "marker": {"color": paint[name], "size": 5, "opacity": 0.45},
            "hovertemplate": f"{escape(name)}<br>%{{x:.2f}} mm east, %{{y:.2f}} mm north<extra></extra>",
        }
        for name in dict.fromkeys(hits.objects)
        for rows in [rows_of(hits, name)]
    ]
    square = {"scaleanchor": "x", "scaleratio": 1}
    return {
        "data": traces,
        "layout": layout(380, xaxis=axis("east, mm"), yaxis=axis("north, mm", **square)),
    }


def coverage(run: ReportedRun) -> Figure:
    """Share of positions inside their own ellipse, for every size of ellipse: on the diagonal, the covariance is right.

    A position with squared Mahalanobis distance d lies inside every ellipse of probability above 1 - exp(-d / 2).
    """
    squares = normalised_squares(run.fused.hits)
    inside_at = np.sort(1.0 - np.exp(-0.5 * squares[np.isfinite(squares)]))
    stated = np.linspace(0.0, 1.0, 101)
    found = np.searchsorted(inside_at, stated, side="right") / max(1, len(inside_at))
    at_90 = float(found[90])
    return {
        "data": [
            {
                "x": [0, 100],
                "y": [0, 100],
                "mode": "lines",
                "line": {"color": TRACK, "dash": "dot"},
                "hoverinfo": "skip",
            },
            {
                "x": (100 * stated).tolist(),
                "y": (100 * found).tolist(),
                "mode": "lines",
                "line": {"color": INK, "width": 2},
                "hovertemplate": "%{x:.0f} % ellipse: %{y:.1f} % inside<extra></extra>",
            },
            {
                "x": [90],
                "y": [100 * at_90],
                "mode": "markers+text",
                "marker": {"color": INK, "size": 9},
                "text": [f"{100 * at_90:.1f} %"],
                "textposition": "bottom right" if at_90 > 0.2 else "top right",
                "cliponaxis": False,
                "hoverinfo": "skip",
            },
        ],
        "layout": layout(
            380,
            showlegend=False,
            margin={"l": 56, "r": 48, "t": 12, "b": 44},
            xaxis=axis("stated, %", range=[0, 101]),
            yaxis=axis("inside, %", range=[0, 104]),
        ),
    }


def stage_bars(run: ReportedRun) -> Figure:
    """RMS error by the stage that caused it, east and north, beside the whole error of single cameras and of all."""
    parts = run.stages
    rows = [
        ("all cameras fused", run.fused.hits.errors_m),
        ("single cameras", parts.anchor_m + parts.calibration_m + parts.location_m),
        ("caused by the anchor", parts.anchor_m),
        ("caused by the calibration", parts.calibration_m),
        ("caused by the location", parts.location_m),
    ]
    names = [name for name, _ in rows]
    traces = [
        {
            "type": "bar",
            "orientation": "h",
            "y": names,
            "x": values_mm,
            "name": name,
            "marker": {"color": colour},
            "text": [f"{value:.2f}" for value in values_mm],
            "textposition": "outside",
            "cliponaxis": False,
            "hovertemplate": "%{y}: %{x:.3f} mm " + name + "<extra></extra>",
        }
        for k, (name, colour) in enumerate((("east", EAST), ("north", NORTH)))
        for values_mm in [[_rms_mm(errors, k) for _, errors in rows]]
    ]
    return {
        "data": traces,
        "layout": layout(
            360,
            barmode="group",
            bargap=0.35,
            bargroupgap=0.08,
            xaxis=axis("RMS error, mm", rangemode="tozero"),
            yaxis=axis("", autorange="reversed", ticks="", gridcolor="rgba(0,0,0,0)"),
            margin={"l": 56, "r": 48, "t": 12, "b": 44},
        ),
    }


def rows_of(hits: Hits, name: str) -> np.ndarray:
    """The rows of one object."""
    return np.flatnonzero([one == name for one in hits.objects])


def _rms_mm(errors_m: FloatArray, axis_index: int) -> float:
    rows = known_rows(errors_m)
    return 1000 * rms(rows[:, axis_index]) if len(rows) else 0.0


def _with_gaps(index: np.ndarray, time_s: np.ndarray, errors_mm: np.ndarray) -> tuple[list[Any], list[list[Any]]]:
    """Lists with a None where frames are missing, so that no line is drawn across."""
    breaks = np.flatnonzero(np.diff(index) > 1) + 1
    pieces = [piece.tolist() for piece in np.split(time_s, breaks)]
    sides = [[piece.tolist() for piece in np.split(errors_mm[:, k], breaks)] for k in range(2)]
    return _joined(pieces), [_joined(side) for side in sides]


def _joined(pieces: list[list[float]]) -> list[Any]:
    return [value for piece in pieces for value in [*piece, None]][:-1]
