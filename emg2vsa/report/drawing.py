"""A figure of a report: drawn once, saved as SVG and PDF, shown on the page, and told in words."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from emg2vsa.figures.canvas import inline_svg
from emg2vsa.report import html
from emg2vsa.report.table import Table


@dataclass(frozen=True)
class Drawing:
    """One figure; ``description`` is what a reader who does not see it hears, ``table`` the numbers behind it."""

    name: str
    title: str
    caption: str
    description: str
    svg: str
    pdf: bytes
    table: Table | None


def shown(drawing: Drawing) -> str:
    """The figure as HTML, its numbers folded away."""
    svg = inline_svg(drawing.svg, drawing.name.split("_")[0], escape(drawing.title), escape(drawing.description))
    data = html.details("The numbers of this figure", drawing.table.html()) if drawing.table else ""
    return html.figure(svg, drawing.caption, data)
