"""One HTML file with its look, its script and its data inside; what goes into it is for others to say."""

import json
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from string import Template

from bench.report.charts import Figure

_ASSETS = files("bench.report") / "assets"


def document(title: str, charts: Mapping[str, Figure], *, heading: str = "", articles: str) -> str:
    """The whole page. ``heading`` and ``articles`` are HTML; ``charts`` by the names that ``chart`` gave them."""
    return Template(_asset("page.html")).substitute(
        title=escape(title),
        style=_asset("page.css"),
        heading=heading,
        articles=articles,
        charts=_script_json(charts),
        plotly=_asset("plotly-basic.min.js"),
        script=_asset("page.js"),
    )


def section(title: str, says: str, content: str) -> str:
    """A part of the page with a title, an explanation in plain text and content in HTML."""
    explained = f'<p class="says">{escape(says)}</p>' if says else ""
    return f"<section><h3>{escape(title)}</h3>{explained}{content}</section>"


def chart(charts: dict[str, Figure], name: str, figure: Figure) -> str:
    """The place of a chart in the page; its figure goes into ``charts``."""
    charts[name] = figure
    return f'<div class="chart" id="{name}" style="min-height:{figure["layout"]["height"]}px"></div>'


def _script_json(value: object) -> str:
    """JSON that may stand inside a script element: no tag can begin in it."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _asset(name: str) -> str:
    return (_ASSETS / name).read_text(encoding="utf-8")
