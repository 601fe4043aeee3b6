"""Puts the page about runs together, section by section."""

from collections.abc import Sequence
from html import escape

from bench.report import tables
from bench.report.charts import Figure, coverage, error_cloud, error_over_time, stage_bars
from bench.report.document import chart, document, section
from bench.report.headline import people_read
from bench.report.material import ReportedRun
from bench.report.mosaic import EXPLANATION, mosaics_html
from bench.report.pictures import picture_html, sample_pictures
from bench.report.plan import SHOWN_HEIGHTS, error_map, magnification, plan


def page(runs: Sequence[ReportedRun]) -> str:
    """The whole page for one run, or several with a comparison before them."""
    charts: dict[str, Figure] = {}
    articles = [_article(run, f"run{k}", charts) for k, run in enumerate(runs)]
    title = runs[0].recording.manifest.title if len(runs) == 1 else f"{len(runs)} runs compared"
    compared = section("Side by side", "", tables.comparison(runs)) if len(runs) > 1 else ""
    heading = f'<header class="page"><h1>{escape(title)}</h1></header>{compared}' if len(runs) > 1 else ""
    return document(title, charts, heading=heading, articles="".join(articles))


def _article(run: ReportedRun, key: str, charts: dict[str, Figure]) -> str:
    """Everything about one run; its charts go into ``charts`` under names that begin with ``key``."""
    sections = [_what_was_seen(run), _plan(run, key, charts), _mosaic(run)]
    if len(run.fused.hits):
        measured = [_errors(run, key, charts), _trust(run, key, charts)]
        sections = [_plan(run, key, charts), *measured, _mosaic(run), _what_was_seen(run)]
    return "".join(["<article>", _head(run), *sections, _all_scores(run), _what_ran(run), "</article>"])


def _head(run: ReportedRun) -> str:
    manifest = run.recording.manifest
    steps = run.recording.steps
    facts = [
        manifest.scenario,
        f"{manifest.world} world",
        f"seed {manifest.seed}",
        f"{len(steps)} frames at {manifest.fps:g} per second",
        f"{len(manifest.cameras)} cameras" if len(manifest.cameras) != 1 else "1 camera",
    ]
    oracles = "".join(
        f'<p class="oracle"><b>Oracle.</b> The stage “{escape(name)}” was given the truth: this is no honest run.</p>'
        for name in manifest.oracles
    )
    return (
        f"<header><h2>{escape(manifest.title)}</h2><p class='facts'>{' · '.join(map(escape, facts))}</p></header>"
        f"{oracles}{_verdict(run)}<dl class='tiles'>{tables.tiles(run.scores)}</dl>"
    )


def _verdict(run: ReportedRun) -> str:
    if not any(step.truth is not None for step in run.recording.steps):
        return '<p class="verdict">Real footage: there is no truth to score against.</p>'
    if run.failures is None:
        return ""
    if not run.failures:
        return '<p class="verdict met">Every expectation of the scenario is met.</p>'
    items = "".join(f"<li>{escape(failure)}</li>" for failure in run.failures)
    return f'<div class="verdict failed">Not met:<ul>{items}</ul></div>'


def _plan(run: ReportedRun, key: str, charts: dict[str, Figure]) -> str:
    says = (
        "Lines: the true paths. Points: the fused positions. Arrows: the headings stated. "
        f"Dotted: what each calibrated camera sees of the floor, as far as {SHOWN_HEIGHTS} times its height. "
        "Drag to enlarge, double-click to return."
    )
    return section("The plan", says, chart(charts, f"{key}-plan", plan(run)))


def _errors(run: ReportedRun, key: str, charts: dict[str, Figure]) -> str:
    times = magnification(run)
    enlarged = f", {times} times enlarged" if times > 1 else ""
    naive = [people_read(run.scores.get(f"ground_z0.rms_{axis}_m")) for axis in "xy"]
    z0 = (
        "Root mean square. Single cameras count where at least 80 % of the vehicle is in sight. "
        f"Had every anchor been taken to lie on the floor (z = 0): {naive[0]} east, {naive[1]} north."
    )
    over_time = chart(charts, f"{key}-time", error_over_time(run))
    over_place = chart(charts, f"{key}-map", error_map(run))
    by_stage = chart(charts, f"{key}-stages", stage_bars(run))
    return (
        section("Error over time", "Fused position minus truth. A gap: not found.", over_time)
        + section("Error over position", f"Lines point to the estimate{enlarged}.", over_place)
        + section("Where the error comes from", z0, by_stage + tables.cameras(run.recording.manifest, run.scores))
    )


def _trust(run: ReportedRun, key: str, charts: dict[str, Figure]) -> str:
    says = (
        "Left: how many positions lie inside their own stated ellipse. On the diagonal the stated covariance is right."
    )
    ellipses = chart(charts, f"{key}-coverage", coverage(run))
    cloud = chart(charts, f"{key}-cloud", error_cloud(run))
    return section("Does it know its own error?", says, f'<div class="pair">{ellipses}{cloud}</div>')


def _mosaic(run: ReportedRun) -> str:
    figures = mosaics_html(run)
    return section("The mosaic", EXPLANATION, figures) if figures else ""


def _what_was_seen(run: ReportedRun) -> str:
    pictures = "".join(picture_html(run, picture) for picture in sample_pictures(run))
    if not pictures:
        return ""
    says = (
        '<span class="key true"></span> true roof and its centre '
        '<span class="key found"></span> what was found, and its anchor'
    )
    return f"<section><h3>What was seen</h3><p class='says'>{says}</p><div class='pictures'>{pictures}</div></section>"


def _all_scores(run: ReportedRun) -> str:
    says = "A dash is a score without a population: nothing was there to measure."
    return section("Scores", says, tables.headline(run.scores) + tables.all_scores(run.scores))


def _what_ran(run: ReportedRun) -> str:
    return section("What ran", "", f'<div class="pair">{tables.what_ran(run.recording.manifest)}</div>')
