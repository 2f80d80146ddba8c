"""Figures at IEEE widths whose files are the same bytes wherever and whenever they are drawn."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from string import ascii_lowercase
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from emg2vsa.figures.palette import GRID, INK

ONE_COLUMN_MM = 88.9
TWO_COLUMNS_MM = 181.0
_MM_PER_INCH = 25.4
_ON_SCREEN = 1.6
"How much larger than on paper a figure is shown on a page."

STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib: the same text on every machine
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.titley": 1.0,  # else every drawing measures all ticks to find out whether a title is in their way
    "axes.labelsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 2.6,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.4,
    "lines.linewidth": 1.2,
    "lines.markersize": 3.5,
    "path.simplify": False,
    "svg.fonttype": "path",
    "svg.hashsalt": "emg2vsa",
    "pdf.fonttype": 42,
}


def new_figure(
    width_mm: float, height_mm: float, margins_mm: Sequence[float], shares: Sequence[float] = (1,), gap_mm: float = 0.0
) -> tuple[Figure, list[Axes]]:
    """A figure with axes side by side, as wide as their ``shares``. Call it inside ``style()``.

    margins_mm : left, right, bottom, top.
    """
    panel_mm = height_mm - margins_mm[2] - margins_mm[3]
    figure, (row,) = _panels(width_mm, 1, shares, panel_mm, margins_mm, (gap_mm, 0.0))
    return figure, row


def show_zero(axes: Axes, values: ArrayLike) -> None:
    """Let the vertical axis begin at zero, unless there are values below it."""
    known = np.asarray(values, dtype=np.float64)
    if not np.any(known[np.isfinite(known)] < 0):
        axes.set_ylim(bottom=0)


def style() -> Any:
    """Context in which figures are drawn and saved."""
    return mpl.rc_context(STYLE)  # type: ignore[arg-type]


def svg_text(figure: Figure) -> str:
    """The figure as SVG, without date and without the XML prologue's document type."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return re.sub(r"<!DOCTYPE[^>]*>\s*", "", buffer.getvalue())


def pdf_bytes(figure: Figure) -> bytes:
    """The figure as PDF, text as embedded TrueType, without date."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    return buffer.getvalue()


def width_pt(svg: str) -> float:
    """Width of a drawing, in points of 1/72 inch."""
    return float(re.search(r' width="([0-9.]+)pt"', svg)[1])  # type: ignore[index]


def inline_svg(svg: str, prefix: str, title: str, description: str) -> str:
    """SVG text made part of a page: ids unique by ``prefix``, named and described for those who do not see it.

    ``title`` and ``description`` are HTML-escaped text.
    """
    body = svg[svg.index("<svg") :]
    body = re.sub(r"<metadata>.*?</metadata>\s*", "", body, flags=re.S)
    body = re.sub(r'(\bid="|xlink:href="#|url\(#)', rf"\g<1>{prefix}-", body)
    body = body.replace("xlink:href", "href").replace(' xmlns:xlink="http://www.w3.org/1999/xlink"', "", 1)
    head, rest = body.split(">", 1)
    wide = width_pt(head)
    head = re.sub(r' (width|height)="[^"]*"', "", head)
    widths = f"max-width:{_ON_SCREEN * wide:.0f}pt;min-width:{wide:.0f}pt"
    return (
        f'{head} style="{widths}" role="img" aria-labelledby="{prefix}-title {prefix}-desc">'
        f'<title id="{prefix}-title">{title}</title><desc id="{prefix}-desc">{description}</desc>{rest}'
    )


def panel_grid(
    rows: int, shares: Sequence[float], panel_mm: float, margins_mm: Sequence[float], gaps_mm: tuple[float, float]
) -> tuple[Figure, list[list[Axes]]]:
    """A figure over both columns of the page, and its axes row by row. Call it inside ``style()``.

    shares : widths of the columns, relative. panel_mm : height of a panel. margins_mm : left, right, bottom, top.
    gaps_mm : between columns, between rows.
    """
    figure, axes = _panels(TWO_COLUMNS_MM, rows, shares, panel_mm, margins_mm, gaps_mm)
    for letter, panel in zip(ascii_lowercase, (panel for row in axes for panel in row), strict=False):
        panel.set_title(f"({letter})", loc="left")
    return figure, axes


def _panels(
    width_mm: float,
    rows: int,
    shares: Sequence[float],
    panel_mm: float,
    margins_mm: Sequence[float],
    gaps_mm: tuple[float, float],
) -> tuple[Figure, list[list[Axes]]]:
    left, right, bottom, top = margins_mm
    across, down = gaps_mm
    height_mm = bottom + top + rows * panel_mm + (rows - 1) * down
    figure = Figure(figsize=(width_mm / _MM_PER_INCH, height_mm / _MM_PER_INCH))
    unit = (width_mm - left - right - across * (len(shares) - 1)) / sum(shares)
    lefts = [(left + unit * sum(shares[:column]) + column * across) / width_mm for column in range(len(shares))]
    bottoms = [1 - (top + (row + 1) * panel_mm + row * down) / height_mm for row in range(rows)]
    return figure, [
        [
            figure.add_axes((x, y, unit * share / width_mm, panel_mm / height_mm))
            for x, share in zip(lefts, shares, strict=True)
        ]
        for y in bottoms
    ]
