"""Tables of the page, every text escaped."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from bench.recording import Manifest
from bench.report.headline import FIGURES, figure_text, people_read, population
from bench.report.material import ReportedRun
from bench.scores import Score, unit_text, value_text

_TILES = {
    "Vehicles found": ("detection.recall",),
    "False alarms": ("detection.false_alarms",),
    "RMS error east": ("ground.rms_x_m",),
    "RMS error north": ("ground.rms_y_m",),
    "95 % are closer than": ("ground.p95_m",),
    "Inside own 90 % ellipse": ("ground.coverage_90",),
}
_CAMERA_ERRORS = {
    "position": "position_error_m",
    "rotation": "rotation_error_rad",
    "focal length": "focal_error_px",
    "on the image": "reprojection_rms_px",
    "on the floor": "ground_rms_m",
}


def tiles(scores: Mapping[str, Score]) -> str:
    """The headline figures."""
    return "".join(
        f'<div class="tile"><dt>{escape(words)}</dt><dd>{escape(people_read(scores.get(name)))}</dd></div>'
        for words, (name,) in _TILES.items()
    )


def comparison(runs: Sequence[ReportedRun]) -> str:
    """The headline figures of several runs side by side."""
    rows = [[figure.words, *(figure_text(figure, run.scores) for run in runs)] for figure in FIGURES]
    return table(["", *(run.name for run in runs)], rows)


def headline(scores: Mapping[str, Score]) -> str:
    """The headline figures with their populations."""
    rows = [[figure.words, figure_text(figure, scores), str(population(figure, scores))] for figure in FIGURES]
    return table(["", "value", "n"], rows)


def all_scores(scores: Mapping[str, Score]) -> str:
    """Every score, folded by the first part of its name."""
    groups: dict[str, list[Score]] = {}
    for score in scores.values():
        groups.setdefault(score.name.split(".")[0], []).append(score)
    return "".join(
        f"<details><summary>{escape(group)} <span>{len(members)}</span></summary>{_scores_table(members)}</details>"
        for group, members in groups.items()
    )


def cameras(manifest: Manifest, scores: Mapping[str, Score]) -> str:
    """How far each calibrated camera is from the true one."""
    names = [one.camera.name for one in manifest.calibrated_cameras]
    rows = [
        [name, *(people_read(scores.get(f"calibration.{name}.{key}")) for key in _CAMERA_ERRORS.values())]
        for name in names
    ]
    return table(["camera", *_CAMERA_ERRORS], rows) if rows else ""


def what_ran(manifest: Manifest) -> str:
    """Stages and versions."""
    stages = [[stage, name] for stage, name in manifest.stages.items()]
    versions = [[package, version] for package, version in manifest.versions.items()]
    return table(["stage", "served by"], stages) + table(["package", "version"], versions)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """An HTML table; the first column is text, the others are figures."""
    top = "".join(f"<th>{escape(text)}</th>" for text in head)
    body = "".join(f"<tr>{''.join(f'<td>{escape(text)}</td>' for text in row)}</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _scores_table(scores: Sequence[Score]) -> str:
    rows = [[score.name, value_text(score), unit_text(score), str(score.n)] for score in scores]
    return table(["score", "value", "unit", "n"], rows)
