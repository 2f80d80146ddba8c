"""Figures at IEEE widths whose files are the same bytes wherever and whenever they are drawn; marks and boxes."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from string import ascii_lowercase
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import ArrayLike

from casr.svg import in_colours_of_page
from emg2vsa.arrays import Floats
from emg2vsa.figures.palette import GRID, INK, Look

ONE_COLUMN_MM = 88.9
TWO_COLUMNS_MM = 181.0
_MM_PER_INCH = 25.4
_ON_SCREEN = 1.6
"How much larger than on paper a figure is shown on a page."

STYLE: dict[str, Any] = {
    "font.family": ["DejaVu Sans"],  # ships with matplotlib: the same text on every machine
    "axes.titley": 1.0,  # else every drawing measures all ticks to find out whether a title is in their way
    **dict.fromkeys(
        ("font.size", "axes.titlesize", "axes.labelsize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize"), 8
    ),
    **dict.fromkeys(("axes.edgecolor", "axes.labelcolor", "text.color", "xtick.color", "ytick.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon", "path.simplify"), False),
    **dict.fromkeys(("axes.grid", "axes.axisbelow"), True),
    "legend.handlelength": 2.6, "axes.linewidth": 0.6, "grid.color": GRID, "grid.linewidth": 0.4,
    "lines.linewidth": 1.2, "lines.markersize": 3.5, "svg.fonttype": "path", "svg.hashsalt": "emg2vsa",
    "pdf.fonttype": 42,
}  # fmt: skip


_BESIDE_CURVES, _SHORT = 4, 8
"""Most names of a legend, and most letters of a name of which three stand side by side."""


def new_figure(
    width_mm: float, height_mm: float, margins_mm: Sequence[float], shares: Sequence[float] = (1,), gap_mm: float = 0.0
) -> tuple[Figure, list[Axes]]:
    """A figure with axes side by side, as wide as their ``shares``. Call it inside ``style()``.

    margins_mm : left, right, bottom, top.
    """
    panel_mm = height_mm - margins_mm[2] - margins_mm[3]
    figure, (row,) = panel_grid(1, shares, panel_mm, margins_mm, (gap_mm, 0.0), width_mm, letters="")
    return figure, row


def panel_grid(
    rows: int, shares: Sequence[float], panel_mm: float, margins_mm: Sequence[float], gaps_mm: tuple[float, float],
    width_mm: float = TWO_COLUMNS_MM, letters: str = ascii_lowercase,
) -> tuple[Figure, list[list[Axes]]]:  # fmt: skip
    """``new_figure`` row by row, with letters.

    panel_mm : height of a panel, mm. margins_mm : left, right, bottom, top. gaps_mm : between columns, between rows.
    """
    left, right, bottom, top = margins_mm
    across, down = gaps_mm
    height_mm = bottom + top + rows * panel_mm + (rows - 1) * down
    figure = Figure(figsize=(width_mm / _MM_PER_INCH, height_mm / _MM_PER_INCH))
    unit = (width_mm - left - right - across * (len(shares) - 1)) / sum(shares)
    lefts = [(left + unit * sum(shares[:column]) + column * across) / width_mm for column in range(len(shares))]
    bottoms = [1 - (top + (row + 1) * panel_mm + row * down) / height_mm for row in range(rows)]
    widths, height = [unit * share / width_mm for share in shares], panel_mm / height_mm
    axes = [[figure.add_axes((x, y, width, height)) for x, width in zip(lefts, widths, strict=True)] for y in bottoms]
    for letter, panel in zip(letters, figure.axes, strict=False):
        panel.set_title(f"({letter})", loc="left")
    return figure, axes


def marks(
    axes: Axes, x: ArrayLike, y: ArrayLike, look: Look, size: float = 3.5, edge: float = 0.4, **more: Any
) -> None:
    """Points in the look of a specimen, with an edge of ink where ``edge`` (in points) is not 0."""
    style: dict[str, Any] = {"linestyle": "none", "marker": look.marker, "markersize": size, "color": look.colour}
    axes.plot(x, y, **style | {"markeredgecolor": INK if edge else "auto", "markeredgewidth": edge} | more)


def short(name: str, most: int = 14) -> str:
    """A name as long as a figure has room for: an ellipsis stands for what is before its last letters."""
    return name if len(name) <= most else f"{name[: most - 1 - most // 3]}…{name[-(most // 3) :]}"


def legend_inside(axes: Axes, loc: Literal["upper left", "upper right"]) -> None:
    """In a corner; of more names than fit beside curves, in three columns above them."""
    names = axes.get_legend_handles_labels()[1]
    n, across = len(names), 3 if max(map(len, names), default=0) <= _SHORT else 2
    if n <= _BESIDE_CURVES and across == 3:
        axes.legend(loc=loc)
        return
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + (high - low) * (0.03 + 0.06 * -(-n // across)))
    axes.legend(loc="upper center", ncols=across, columnspacing=1, handletextpad=0.4, fontsize=6)


def groups(axes: Axes, names: Sequence[str]) -> None:
    """Names at 0, 1, ... below the boxes of groups."""
    axes.set_xticks(range(len(names)), [short(name, max(6, 40 // len(names))) for name in names])
    axes.set_xlim(-0.6, len(names) - 0.4)
    axes.grid(axis="x", visible=False)


def one_scale(row: Sequence[Axes]) -> None:
    """The same vertical scale for all axes of a row, named at the first."""
    low, high = np.transpose([axes.get_ylim() for axes in row])
    for axes in row:
        axes.set_ylim(low.min(), high.max())
        axes.tick_params(labelleft=axes is row[0])


def show_zero(axes: Axes, values: ArrayLike) -> None:
    """Let the vertical axis begin at zero, unless there are values below it."""
    known = np.asarray(values, dtype=np.float64)
    if not np.any(known[np.isfinite(known)] < 0):
        axes.set_ylim(bottom=0)


@contextlib.contextmanager
def style() -> Iterator[None]:
    """Context in which figures are drawn and saved: a matplotlibrc of the user counts for nothing."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)  # type: ignore[arg-type]
        yield


def svg_text(figure: Figure) -> str:
    """The figure as SVG, without date and without the XML prologue's document type."""
    return re.sub(r"<!DOCTYPE[^>]*>\s*", "", _saved(figure, "svg", "Date", "Creator").decode())


def pdf_bytes(figure: Figure) -> bytes:
    """The figure as PDF, text as embedded TrueType, without date."""
    return _saved(figure, "pdf", "CreationDate", "Creator", "Producer")


def _saved(figure: Figure, kind: str, *left_out: str) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format=kind, metadata=dict.fromkeys(left_out))
    return buffer.getvalue()


def width_pt(svg: str) -> float:
    """Width of a drawing, in points of 1/72 inch."""
    return float(re.search(r' width="([0-9.]+)pt"', svg)[1])  # type: ignore[index]


def inline_svg(svg: str, prefix: str, title: str, description: str) -> str:
    """SVG text made part of a page: in its colours, ids unique by ``prefix``, told to those who do not see it.

    ``title`` and ``description`` are HTML-escaped text.
    """
    body = in_colours_of_page(svg[svg.index("<svg") :])
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


_STARS = ((1e-3, "***"), (1e-2, "**"), (5e-2, "*"))


@dataclass(frozen=True)
class PairBar:
    """A bar over two boxes, by their places, with the p it stands for."""

    first: int
    second: int
    p: float


def stars(p: float) -> str:
    """Usual marks of a p: **** <= 1e-4, *** < .001, ** < .01, * < .05, else ns; "" where p is not defined."""
    return "" if np.isnan(p) else "****" if p <= 1e-4 else next((mark for bound, mark in _STARS if p < bound), "ns")


def hazen_box(values: Floats) -> tuple[float, float, float, float, float]:
    """Lower whisker, quartiles, upper whisker of (n,) values. Hazen's quantiles, as MATLAB's boxplot; whiskers within
    1.5 IQR."""
    low, median, high = np.quantile(values, (0.25, 0.5, 0.75), method="hazen")
    reach = 1.5 * (high - low)
    inside = values[(values >= low - reach) & (values <= high + reach)]
    return float(inside.min()), float(low), float(median), float(high), float(inside.max())


def draw_box(
    axes: Axes, place: float, values: Floats, look: Look, *, width: float = 0.5, filled: bool = False,
    hollow_marks: bool = False,
) -> None:  # fmt: skip
    """One box at ``place`` with all finite ``values`` (n,) as marks; nothing where there is none."""
    values = values[np.isfinite(values)]
    if not values.size:
        return
    bottom, low, median, high, top = hazen_box(values)
    left, right = place - width / 2, place + width / 2
    axes.vlines([place, place], [bottom, high], [low, top], colors=INK, linewidth=0.7)
    axes.hlines([bottom, top], place - width / 5, place + width / 5, colors=INK, linewidth=0.7)
    face = to_rgba(look.colour, 0.3) if filled else "none"
    axes.add_patch(Rectangle((left, low), width, high - low, facecolor=face, edgecolor=look.colour, linewidth=1.2))
    axes.hlines(median, left, right, colors=INK, linewidth=1.4)
    # neighbours in rank lie side by side, the same at every run
    pattern = np.tile([-1.0, 0.0, 1.0, -0.5, 0.5], -(-values.size // 5))
    across = place + 0.32 * width * pattern[np.argsort(np.argsort(values, kind="stable"))]
    hollow: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": look.colour, "markeredgewidth": 0.8}
    marks(axes, across, values, look, 3, **hollow if hollow_marks else {})


def draw_bars(axes: Axes, bars: Sequence[PairBar], legend: str) -> None:
    """Bars above everything drawn so far, short ones lowest; ``legend`` names the test over the axes."""
    low, high = axes.get_ylim()
    step = 0.09 * (high - low)
    for level, bar in enumerate(sorted(bars, key=lambda bar: (bar.second - bar.first, bar.first))):
        y = high + (level + 0.3) * step
        axes.plot([bar.first, bar.first, bar.second, bar.second], [y, y + step / 5, y + step / 5, y], color=INK, lw=0.7)
        axes.text((bar.first + bar.second) / 2, y + step / 6, stars(bar.p), ha="center", va="bottom")
    axes.set_ylim(low, high + (len(bars) + 0.6) * step)
    if bars:
        axes.set_title(legend, loc="right", fontsize=7)
