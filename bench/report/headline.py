"""The figures that matter first, in words and in units that people read: millimetres, per cent."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from bench.scores import Score, unit_text, value_text


@dataclass(frozen=True)
class Figure:
    """One line of the summary: what it is in words, and the scores that say it (one, or one per axis)."""

    words: str
    scores: tuple[str, ...]


def _axes(words: str, prefix: str, name: str = "rms") -> Figure:
    return Figure(words, (f"{prefix}.{name}_x_m", f"{prefix}.{name}_y_m"))


FIGURES = (
    Figure("Found", ("detection.recall",)),
    Figure("Right among found", ("detection.precision",)),
    Figure("Missed", ("detection.misses",)),
    Figure("False alarms", ("detection.false_alarms",)),
    Figure("Right labels", ("label.accuracy",)),
    Figure("Identity switches", ("track.id_switches",)),
    Figure("Right direction", ("direction.correct",)),
    Figure("Said to stand, of standing", ("direction.standing_correct",)),
    Figure("False changes of direction", ("direction.flips",)),
    Figure("Heading error, RMS", ("direction.heading_rms_rad",)),
    Figure("Speed error, RMS", ("speed.rms_mps",)),
    _axes("Ground error, RMS east, north", "ground"),
    _axes("Ground error, mean east, north", "ground", "mean"),
    Figure("Ground error, 95 % below", ("ground.p95_m",)),
    Figure("Ground error, largest", ("ground.max_m",)),
    Figure("Inside own 90 % ellipse", ("ground.coverage_90",)),
    _axes("Of which the anchor causes", "stage.anchor"),
    _axes("Of which the calibration causes", "stage.calibration"),
    _axes("Had all lain at z = 0", "ground_z0"),
)

_THOUSANDTHS = {"m": "mm", "m/s": "mm/s", "rad": "mrad"}


def people_read(score: Score | None) -> str:
    """Value and unit for people: below one in thousandths, ratios in per cent; an em dash without value."""
    if score is None or score.value is None:
        return "—"
    if score.unit in _THOUSANDTHS and abs(score.value) < 1:
        return f"{1000 * score.value:z.2f} {_THOUSANDTHS[score.unit]}"
    if score.unit == "1":
        return f"{100 * score.value:.4g} %"
    if score.unit == "px":
        return f"{score.value:.2f} px"
    return f"{value_text(score)} {unit_text(score)}".rstrip()


def figure_text(figure: Figure, scores: Mapping[str, Score]) -> str:
    """The figure's values, a comma between axes."""
    return ", ".join(people_read(scores.get(name)) for name in figure.scores)


def population(figure: Figure, scores: Mapping[str, Score]) -> int:
    """How much the figure summarises."""
    counts: Sequence[int] = [scores[name].n for name in figure.scores if name in scores]
    return max(counts, default=0)
