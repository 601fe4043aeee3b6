"""Figure 19 of paper R: the speed of tracking against detection in every frame, sequence by sequence."""

from collections.abc import Sequence

import numpy as np

from bench.report.charts import MUTED, TRACK, Figure, axis, layout
from bench.scores import Score
from bench.tables.films import Watched, frames_per_second
from bench.tables.part import Grid, Part, number

PAPER_ONE_CAMERA_FPS, PAPER_TWO_CAMERAS_FPS, PAPER_DETECTION_FPS = 94.0, 50.0, 34.0
DETECTION, TRACKING = "#c8752b", "#1b6ca8"


def figure19(tracking: Sequence[Watched], detection: Sequence[Watched]) -> Part:
    """One row per sequence; both watched the same sequences in the same order."""
    pairs = list(zip(tracking, detection, strict=True))
    rows = [
        (
            ours.sequence,
            ours.light,
            number(one_camera_fps([ours]), ".0f"),
            number(one_camera_fps([plain]), ".0f"),
            number(one_camera_fps([ours]) / one_camera_fps([plain]), ".1f"),
            number(all_cameras_fps([ours]), ".0f"),
            number(all_cameras_fps([plain]), ".0f"),
        )
        for ours, plain in pairs
    ]
    head = ("sequence", "light", "tracking, 1 camera", "detection", "ratio", "tracking, all cameras", "detection")
    whole = (
        "all",
        "",
        number(one_camera_fps(tracking), ".0f"),
        number(one_camera_fps(detection), ".0f"),
        number(one_camera_fps(tracking) / one_camera_fps(detection), ".1f"),
        number(all_cameras_fps(tracking), ".0f"),
        number(all_cameras_fps(detection), ".0f"),
    )
    paper = (
        "paper (i5-8250U)",
        "",
        *(number(value, ".0f") for value in (PAPER_ONE_CAMERA_FPS, PAPER_DETECTION_FPS)),
        number(PAPER_ONE_CAMERA_FPS / PAPER_DETECTION_FPS, ".1f"),
        number(PAPER_TWO_CAMERAS_FPS, ".0f"),
        number(None),
    )
    method = tracking[0].method if tracking else ""
    says = (
        f"Frames per second of processor time on one thread, frames in memory: “{method}” against the same detector "
        "in every frame. One camera: the rig's first. All cameras: moments per second, where every camera's frame "
        "of the moment is looked at."
    )
    return Part(
        "figure19",
        "Figure 19: tracking against pure detection",
        says,
        (Grid(head, (*rows, whole, paper)),),
        (_bars(tracking, detection),) if pairs else (),
        (
            Score.of("figure19.tracking_fps", one_camera_fps(tracking), "1/s", _frames(tracking)),
            Score.of("figure19.detection_fps", one_camera_fps(detection), "1/s", _frames(detection)),
            Score.of("figure19.tracking_all_cameras_fps", all_cameras_fps(tracking), "1/s", _frames(tracking)),
            Score.of("figure19.detection_all_cameras_fps", all_cameras_fps(detection), "1/s", _frames(detection)),
        ),
    )


def one_camera_fps(watched: Sequence[Watched]) -> float:
    """Frames of the first camera per second, over all sequences."""
    return frames_per_second([next(iter(one.seconds.values())) for one in watched if one.seconds])


def all_cameras_fps(watched: Sequence[Watched]) -> float:
    """Moments per second, each with the frames of all its cameras, over all sequences."""
    return frames_per_second([np.sum(list(one.seconds.values()), axis=0) for one in watched if one.seconds])


def _frames(watched: Sequence[Watched]) -> int:
    return sum(len(next(iter(one.seconds.values()), ())) for one in watched)


def _bars(tracking: Sequence[Watched], detection: Sequence[Watched]) -> Figure:
    names = [one.sequence for one in tracking]
    traces = [
        {
            "type": "bar",
            "x": names,
            "y": [one_camera_fps([one]) for one in watched],
            "name": name,
            "marker": {"color": colour},
            "hovertemplate": f"%{{x}}<br>{name}: %{{y:.0f}} fps<extra></extra>",
        }
        for name, watched, colour in (("tracking", tracking, TRACKING), ("detection", detection, DETECTION))
    ]
    line = {"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": PAPER_ONE_CAMERA_FPS, "y1": PAPER_ONE_CAMERA_FPS}
    note = {
        "xref": "paper",
        "x": 1,
        "xanchor": "right",
        "y": PAPER_ONE_CAMERA_FPS,
        "yanchor": "bottom",
        "text": "paper's hybrid",
        "showarrow": False,
        "font": {"color": MUTED, "size": 11},
    }
    return {
        "data": traces,
        "layout": layout(
            380,
            barmode="group",
            bargap=0.3,
            xaxis=axis("", ticks=""),
            yaxis=axis("frames per second", rangemode="tozero"),
            shapes=[line | {"line": {"color": TRACK, "dash": "dot"}}],
            annotations=[note],
        ),
    }
