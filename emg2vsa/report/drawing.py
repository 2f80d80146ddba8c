"""A figure of a report: drawn once, saved as SVG or PDF, shown on the page, told in words, set by LaTeX."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property
from html import escape

from matplotlib.figure import Figure

from casr import html
from emg2vsa.figures.canvas import ONE_COLUMN_MM, inline_svg, pdf_bytes, style, svg_text, width_pt
from emg2vsa.report.latex import latex_text


@dataclass(frozen=True)
class Drawing:
    """One figure; ``description`` is what a reader who does not see it hears."""

    name: str
    title: str
    caption: str
    description: str
    figure: Figure

    @cached_property
    def svg(self) -> str:
        with style():
            return svg_text(self.figure)

    def pdf(self) -> bytes:
        """Twice as slow as the SVG, and only wanted for a paper."""
        with style():
            return pdf_bytes(self.figure)


def shown(drawing: Drawing) -> str:
    """The figure as HTML."""
    svg = inline_svg(drawing.svg, drawing.name.split("_")[0], escape(drawing.title), escape(drawing.description))
    return html.figure(svg, drawing.caption)


def figure_tex(drawing: Drawing) -> str:
    r"""A figure environment, over both columns where the drawing is wider than one.

    The PDF is sought in ``\emgfolder``, the folder that holds ``figures``: the current one unless the paper says else.
    The figure keeps the study's number, unless the paper defines ``\emgfigure`` as a command that ignores it.
    """
    figure = "figure*" if width_pt(drawing.svg) > ONE_COLUMN_MM * 72 / 25.4 + 1 else "figure"
    numbered, caption = re.fullmatch(r"(?:Fig\. (\w+)\. )?(.*)", drawing.caption, re.S).groups()  # type: ignore[union-attr]
    lines = (
        "% takes the package graphicx", r"\providecommand{\emgfolder}{.}",
        r"\providecommand{\emgfigure}[1]{\renewcommand{\thefigure}{#1}}", rf"\begin{{{figure}}}", r"\centering",
        *([rf"\emgfigure{{{numbered}}}"] if numbered else []),
        rf"\includegraphics[width=\linewidth]{{\emgfolder/figures/{drawing.name}.pdf}}",
        rf"\caption{{{latex_text(caption)}}}", rf"\label{{fig:{drawing.name}}}", rf"\end{{{figure}}}", "",
    )  # fmt: skip
    return "\n".join(lines)
