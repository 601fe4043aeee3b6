"""Which stage and which light owns the rest of the ground error."""

from collections.abc import Sequence

import numpy as np

from bench.matching import gate_m
from bench.report.charts import Figure, axis, layout
from bench.scores import Score
from bench.scoring.anchors import sightings
from bench.scoring.ground import known_rows, rms
from bench.scoring.population import camera_names, camera_population, fused_population
from bench.scoring.stages import StageErrors, split
from bench.tables.films import Watched
from bench.tables.part import Grid, Part, number
from contracts import FloatArray

STAGES = {"anchor": "#1b6ca8", "calibration": "#c8752b", "location": "#5b6470"}
HEAD = ("light", "positions", "fused x, mm", "fused y, mm", "p95, mm", "anchor", "calibration", "location", "owner")


def owners(watched: Sequence[Watched]) -> Part:
    """One row per light, and one over all, of one method."""
    lights = list(dict.fromkeys(one.light for one in watched))
    groups = [(light, [one for one in watched if one.light == light]) for light in lights]
    if len(lights) != 1:
        groups.append(("all", list(watched)))
    parts = {light: (_fused(group), stage_errors(group)) for light, group in groups}
    scores = [score for light, (fused, stages) in parts.items() for score in _scores(light, fused, stages)]
    rows = tuple(_row(light, fused, stages) for light, (fused, stages) in parts.items())
    says = (
        "Fused: root mean square of the position errors per axis. Stages: root mean square, over both axes "
        "together, of the parts into which the error of each single camera falls; they add up vector by vector. The "
        "owner is the largest of them."
    )
    chart = _bars({light: stages for light, (_, stages) in parts.items()})
    return Part("owners", "Who owns the rest", says, (Grid(HEAD, rows),), (chart,), tuple(scores))


def stage_errors(watched: Sequence[Watched]) -> StageErrors:
    """The stages' parts of the errors of all cameras of all sequences."""
    parts = [_split(one) for one in watched]
    return StageErrors(*(np.concatenate([np.empty((0, 2)), *(getattr(p, f"{s}_m") for p in parts)]) for s in STAGES))


def _split(one: Watched) -> StageErrors:
    gate = gate_m(one.recording.manifest.world)
    seen = [
        (name, sightings(one.recording, camera_population(one.recording, name, gate)))
        for name in camera_names(one.recording)
    ]
    return split(one.recording, seen)


def _fused(watched: Sequence[Watched]) -> FloatArray:
    errors = [fused_population(one.recording, gate_m(one.recording.manifest.world)).hits.errors_m for one in watched]
    return np.concatenate([np.empty((0, 2)), *errors])


def _parts(stages: StageErrors) -> dict[str, float]:
    """Root mean square of each stage's part, per axis, metres; NaN where there is none."""
    return {name: rms(known_rows(getattr(stages, f"{name}_m")).ravel()) for name in STAGES}


def _scores(light: str, fused: FloatArray, stages: StageErrors) -> list[Score]:
    return [
        *(Score.of(f"owners.{light}.rms_{axis_}_m", rms(fused[:, k]), "m", len(fused)) for k, axis_ in enumerate("xy")),
        *(
            Score.of(f"owners.{light}.{name}_rms_m", value, "m", len(known_rows(getattr(stages, f"{name}_m"))))
            for name, value in _parts(stages).items()
        ),
    ]


def _row(light: str, fused: FloatArray, stages: StageErrors) -> tuple[str, ...]:
    parts = _parts(stages)
    distances_m = np.linalg.norm(fused, axis=1)
    known = {name: value for name, value in parts.items() if np.isfinite(value)}
    return (
        light,
        str(len(fused)),
        *(number(rms(fused[:, k]), ".3f", 1e3) for k in range(2)),
        number(float(np.quantile(distances_m, 0.95)) if len(fused) else None, ".3f", 1e3),
        *(number(value, ".3f", 1e3) for value in parts.values()),
        max(known, key=lambda name: known[name]) if known else number(None),
    )


def _bars(stages: dict[str, StageErrors]) -> Figure:
    lights = list(stages)
    traces = [
        {
            "type": "bar",
            "x": lights,
            "y": [1e3 * value if np.isfinite(value) else None for value in values],
            "name": name,
            "marker": {"color": colour},
            "hovertemplate": f"%{{x}}<br>{name}: %{{y:.3f}} mm<extra></extra>",
        }
        for name, colour in STAGES.items()
        for values in [[_parts(stages[light])[name] for light in lights]]
    ]
    vertical = axis("RMS per axis, mm", rangemode="tozero")
    return {
        "data": traces,
        "layout": layout(320, barmode="group", bargap=0.35, xaxis=axis("", ticks=""), yaxis=vertical),
    }
