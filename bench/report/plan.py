"""The world from above: track, cameras, truth, estimates, and the error where it happened."""

from collections.abc import Iterator
from html import escape
from typing import Any

import numpy as np
import shapely

from bench.report.charts import INK, MUTED, TRACK, Figure, axis, layout, rows_of
from bench.report.material import ReportedRun, run_colours
from contracts import Camera, FloatArray
from georef.blind_spots import view

_TRACK_STEP_M = 0.02
_HEAT = [[0.0, "#f6dfae"], [0.35, "#eb9a4b"], [0.7, "#c2402a"], [1.0, "#5d0f1e"]]
_CHART_WIDTH_PX, _EDGE_M = 1000, 0.05
_HEADING_NS = 500_000_000  # between two headings drawn along a path
_ARROW = 0.05  # of the plan's width: as long as an error at the 95 % quantile is drawn at most
SHOWN_HEIGHTS = 8  # a camera's view is drawn as far from its foot as so many times its height
_FINENESS = 1e-4  # of that distance: so exactly the view's outline is drawn
_MAGNIFICATIONS = np.array([1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000])

Trace = dict[str, Any]


def plan(run: ReportedRun) -> Figure:
    """Track, what each camera sees of the floor, the true paths and the fused positions."""
    traces = [*_background(run), *_truths(run), *_estimates(run), _headings(run), *_misses(run), *_false_alarms(run)]
    return {"data": traces, "layout": _plan_layout(traces)}


def error_map(run: ReportedRun) -> Figure:
    """The distance between position and truth where it happened, with the error drawn enlarged."""
    hits = run.fused.hits
    distances_mm = 1000 * np.linalg.norm(hits.errors_m, axis=1)
    top_mm = float(np.quantile(distances_mm, 0.99)) if len(hits) else 1.0
    points: Trace = {
        "x": hits.truths_m[:, 0].tolist(),
        "y": hits.truths_m[:, 1].tolist(),
        "mode": "markers",
        "showlegend": False,
        "marker": {
            "size": 6,
            "color": distances_mm.tolist(),
            "colorscale": _HEAT,
            "cmin": 0,
            "cmax": max(top_mm, 1e-6),
            "colorbar": {"title": {"text": "mm"}, "thickness": 10, "len": 0.8, "outlinewidth": 0},
        },
        "text": [
            f"{escape(name)}<br>{mm:.2f} mm" for name, mm in zip(hits.objects, distances_mm.tolist(), strict=True)
        ],
        "hovertemplate": "%{text}<extra></extra>",
    }
    background = list(_background(run))
    return {"data": [*background, *_arrows(run), points], "layout": _plan_layout([*background, points])}


def magnification(run: ReportedRun) -> int:
    """How many times enlarged errors are drawn on the plan: a round number that keeps them short."""
    hits = run.fused.hits
    large_m = float(np.quantile(np.linalg.norm(hits.errors_m, axis=1), 0.95)) if len(hits) else 0.0
    places: Trace = {"x": hits.truths_m[:, 0].tolist(), "y": hits.truths_m[:, 1].tolist()}
    low, high = _extents([*_background(run), places])
    fits = _MAGNIFICATIONS[_MAGNIFICATIONS * large_m <= _ARROW * float((high - low).max())]
    return int(fits[-1]) if len(fits) else 1


def outline_on_floor(camera: Camera) -> FloatArray:
    """The border of what the camera sees of the floor within ``SHOWN_HEIGHTS`` times its height, closed lines (P, 2).

    A row of NaN ends each line; nothing where it sees no floor so near.
    """
    farthest_m = SHOWN_HEIGHTS * float(camera.pose.position_m[2])
    seen = view(camera, farthest_m).simplify(_FINENESS * farthest_m)
    rings = [shapely.get_coordinates(part.exterior) for part in shapely.get_parts(seen) if not part.is_empty]
    return np.concatenate([np.empty((0, 2)), *(np.vstack([ring, [np.nan, np.nan]]) for ring in rings)])


def _background(run: ReportedRun) -> Iterator[Trace]:
    for section in run.plant.sections.values() if run.plant else ():
        points_m = section.curve.points(_TRACK_STEP_M)
        yield _line(points_m, {"color": TRACK, "width": 3}, hoverinfo="skip")
    if run.plant:
        spots = {name: switch.spot_m for name, switch in run.plant.switches.items()}
        yield {
            "x": [x for x, _ in spots.values()],
            "y": [y for _, y in spots.values()],
            "mode": "text",
            "text": [escape(name) for name in spots],
            "textfont": {"color": MUTED, "size": 11},
            "showlegend": False,
            "hoverinfo": "skip",
        }
    for calibrated in run.recording.manifest.calibrated_cameras:
        outline_m = outline_on_floor(calibrated.camera)
        name = f"camera {escape(calibrated.camera.name)}"
        line = {"color": MUTED, "width": 1, "dash": "dot"}
        yield _line(outline_m, line, hovertemplate=f"{name}<extra></extra>")


def _truths(run: ReportedRun) -> Iterator[Trace]:
    truths = [step.truth for step in run.recording.steps if step.truth is not None]
    for name in dict.fromkeys(one for truth in truths for one in truth.ids):
        places = [truth.positions_m[truth.ids.index(name), :2] for truth in truths if name in truth.ids]
        yield _line(
            np.array(places), {"color": INK, "width": 1.2}, hovertemplate=f"truth of {escape(name)}<extra></extra>"
        )


def _estimates(run: ReportedRun) -> Iterator[Trace]:
    hits, paint = run.fused.hits, run_colours(run)
    for name in dict.fromkeys(hits.objects):
        places = hits.estimates_m[rows_of(hits, name)]
        yield _markers(name, places, {"color": paint[name], "size": 5, "opacity": 0.7})
    if not run.fused.frames:  # real footage: no truth to match with
        places = [step.fused.positions_m[step.fused.valid] for step in run.recording.steps]
        yield _markers("positions", np.concatenate([np.empty((0, 2)), *places]), {"color": INK, "size": 4})


def _headings(run: ReportedRun) -> Trace:
    """Now and then an arrow the way that each vehicle was said to go."""
    rows: list[tuple[float, float, float]] = []
    next_ns = 0
    for step in run.recording.steps:
        if step.time_ns < next_ns:
            continue
        next_ns = step.time_ns + _HEADING_NS
        known = dict(zip(step.motions.ids.tolist(), step.motions.headings_rad.tolist(), strict=True))
        headings_rad = np.array([known.get(identity, np.nan) for identity in step.fused.ids.tolist()])
        drawn = step.fused.valid & np.isfinite(headings_rad)
        clockwise_deg = 90.0 - np.degrees(headings_rad[drawn])  # from north, as the markers are turned
        rows += np.column_stack([step.fused.positions_m[drawn], clockwise_deg]).tolist()
    return {
        "x": [row[0] for row in rows],
        "y": [row[1] for row in rows],
        "mode": "markers",
        "marker": {"symbol": "arrow", "size": 13, "color": INK, "angle": [row[2] for row in rows]},
        "showlegend": False,
        "hoverinfo": "skip",
    }


def _misses(run: ReportedRun) -> Iterator[Trace]:
    places = [frame.truth.positions_m[frame.matching.misses, :2] for frame in run.fused.frames]
    marker = {"color": "rgba(0,0,0,0)", "size": 10, "line": {"color": "#b3261e", "width": 1.5}}
    yield from _if_any("missed", places, marker)


def _false_alarms(run: ReportedRun) -> Iterator[Trace]:
    places = [frame.ground.positions_m[frame.matching.false_alarms] for frame in run.fused.frames]
    yield from _if_any("false alarm", places, {"color": "#b3261e", "size": 8, "symbol": "x-thin-open"})


def _if_any(name: str, places: list[FloatArray], marker: dict[str, Any]) -> Iterator[Trace]:
    together = np.concatenate([np.empty((0, 2)), *places])
    if len(together):
        yield _markers(name, together, marker)


def _arrows(run: ReportedRun) -> Iterator[Trace]:
    hits = run.fused.hits
    tips_m = hits.truths_m + magnification(run) * hits.errors_m
    x, y = ([v for a, b in zip(hits.truths_m[:, k], tips_m[:, k], strict=True) for v in (a, b, None)] for k in (0, 1))
    line = {"color": "#8a8378", "width": 0.8}
    yield {"x": x, "y": y, "mode": "lines", "line": line, "showlegend": False, "hoverinfo": "skip"}


def _line(points_m: FloatArray, line: dict[str, Any], **more: Any) -> Trace:
    x, y = ([value if np.isfinite(value) else None for value in points_m[:, k].tolist()] for k in (0, 1))
    return {"x": x, "y": y, "mode": "lines", "line": line, "showlegend": False} | more


def _markers(name: str, places_m: FloatArray, marker: dict[str, Any]) -> Trace:
    finite = places_m[np.isfinite(places_m).all(axis=1)]
    return {
        "x": finite[:, 0].tolist(),
        "y": finite[:, 1].tolist(),
        "mode": "markers",
        "name": escape(name),
        "marker": marker,
        "hovertemplate": f"{escape(name)}<br>%{{x:.3f}} m east, %{{y:.3f}} m north<extra></extra>",
    }


def _plan_layout(traces: list[Trace]) -> dict[str, Any]:
    """Equal scales, in a chart as high as the traces are for their width."""
    low, high = _extents(traces)
    (width_m, height_m) = high - low + 2 * _EDGE_M
    height_px = int(np.clip(_CHART_WIDTH_PX * height_m / width_m, 240, 620)) + 90
    ranges = [[a - _EDGE_M, b + _EDGE_M] for a, b in zip(low.tolist(), high.tolist(), strict=True)]
    return layout(
        height_px,
        xaxis=axis("east, m", zeroline=False, range=ranges[0], constrain="domain"),
        yaxis=axis("north, m", zeroline=False, range=ranges[1], scaleanchor="x", scaleratio=1, constrain="domain"),
    )


def _extents(traces: list[Trace]) -> tuple[FloatArray, FloatArray]:
    """Least and largest east and north (2,) of all traces."""
    low, high = zip(*(_extent([value for trace in traces for value in trace[key]]) for key in "xy"), strict=True)
    return np.array(low), np.array(high)


def _extent(values: list[float | None]) -> tuple[float, float]:
    known = [value for value in values if value is not None]
    return min(known, default=-1.0), max(known, default=1.0)
