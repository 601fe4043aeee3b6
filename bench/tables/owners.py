"""Which stage and which light owns the rest of the ground error."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.matching import gate_m
from bench.report.charts import Figure, axis, layout
from bench.scores import Score
from bench.scoring.anchors import Sightings, sightings
from bench.scoring.ground import known_rows, rms
from bench.scoring.population import Hits, camera_names, camera_population, fused_population
from bench.scoring.stages import StageErrors, split
from bench.tables.films import Watched
from bench.tables.part import Grid, Part, number, slug
from contracts import FloatArray

STAGES = {"anchor": "#1b6ca8", "calibration": "#c8752b", "location": "#5b6470"}
HEAD = ("light", "positions", "fused x, mm", "fused y, mm", "p95, mm", "anchor", "calibration", "location", "owner")


@dataclass(frozen=True, eq=False)
class Owned:
    """Errors with the light that shone: of N fused positions, (N, 2), and of K positions of single cameras by stage."""

    fused_m: FloatArray
    fused_lights: NDArray[np.str_]
    stages: StageErrors
    stage_lights: NDArray[np.str_]

    def under(self, light: str) -> "Owned":
        """Those that were made under one light."""
        fused, stages = self.fused_lights == light, self.stage_lights == light
        parts = StageErrors(*(getattr(self.stages, f"{name}_m")[stages] for name in STAGES))
        return Owned(self.fused_m[fused], self.fused_lights[fused], parts, self.stage_lights[stages])


def owners(watched: Sequence[Watched]) -> Part:
    """One row per light, and one over all, of one method."""
    everything = owned(watched)
    lights = list(dict.fromkeys(light for one in watched for light in one.lights.values()))
    groups = {light: everything.under(light) for light in lights}
    if len(lights) != 1:
        groups["all"] = everything
    scores = [score for light, group in groups.items() for score in _scores(light, group)]
    rows = tuple(_row(light, group) for light, group in groups.items())
    says = (
        "Fused: root mean square of the position errors per axis. Stages: root mean square, over both axes "
        "together, of the parts into which the error of each single camera falls; they add up vector by vector. The "
        "owner is the largest of them."
    )
    chart = _bars({light: group.stages for light, group in groups.items()})
    return Part("owners", "Who owns the rest", says, (Grid(HEAD, rows),), (chart,), tuple(scores))


def owned(watched: Sequence[Watched]) -> Owned:
    """The errors of all positions of all sequences."""
    fused = [(one, fused_population(one.recording, gate_m(one.recording.manifest.world)).hits) for one in watched]
    seen = [(one, _sightings(one)) for one in watched]
    parts = [split(one.recording, sighted) for one, sighted in seen]
    return Owned(
        np.concatenate([np.empty((0, 2)), *(hits.errors_m for _, hits in fused)]),
        _lights((one, hits) for one, hits in fused),
        StageErrors(
            *(np.concatenate([np.empty((0, 2)), *(getattr(p, f"{name}_m") for p in parts)]) for name in STAGES)
        ),
        _lights((one, sighting.hits) for one, sighted in seen for _, sighting in sighted),
    )


def _sightings(one: Watched) -> list[tuple[str, Sightings]]:
    gate = gate_m(one.recording.manifest.world)
    names = camera_names(one.recording)
    return [(name, sightings(one.recording, camera_population(one.recording, name, gate))) for name in names]


def _lights(hits: Iterable[tuple[Watched, Hits]]) -> NDArray[np.str_]:
    return np.array([one.lights[index] for one, some in hits for index in some.index.tolist()], np.str_)


def _parts(stages: StageErrors) -> dict[str, float]:
    """Root mean square of each stage's part, per axis, metres; NaN where there is none."""
    return {name: rms(known_rows(getattr(stages, f"{name}_m")).ravel()) for name in STAGES}


def _scores(light: str, group: Owned) -> list[Score]:
    fused = group.fused_m
    return [
        *(
            Score.of(f"owners.{slug(light)}.rms_{name}_m", rms(fused[:, k]), "m", len(fused))
            for k, name in enumerate("xy")
        ),
        *(
            Score.of(
                f"owners.{slug(light)}.{name}_rms_m", value, "m", len(known_rows(getattr(group.stages, f"{name}_m")))
            )
            for name, value in _parts(group.stages).items()
        ),
    ]


def _row(light: str, group: Owned) -> tuple[str, ...]:
    fused, parts = group.fused_m, _parts(group.stages)
    known = {name: value for name, value in parts.items() if np.isfinite(value)}
    distances_m = np.linalg.norm(fused, axis=1)
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
