"""Box plots as MATLAB draws them, with every value as a mark, and bars that say which boxes differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Rectangle

from emg2vsa.arrays import Floats
from emg2vsa.figures.palette import INK, Look

_STARS = ((1e-4, "****"), (1e-3, "***"), (1e-2, "**"), (5e-2, "*"))


@dataclass(frozen=True)
class PairBar:
    """A bar over two boxes, by their places, with the p it stands for."""

    first: int
    second: int
    p: float


def stars(p: float) -> str:
    """Usual marks of a p: **** <= 1e-4, *** < .001, ** < .01, * < .05, else ns; "" where p is not defined."""
    if np.isnan(p):
        return ""
    return next((mark for bound, mark in _STARS if p < bound or (bound == 1e-4 and p == bound)), "ns")


def hazen_box(values: Floats) -> tuple[float, float, float, float, float]:
    """Lower whisker, quartiles, upper whisker. Hazen's quantiles, as MATLAB's boxplot; whiskers within 1.5 IQR."""
    low, median, high = np.quantile(values, (0.25, 0.5, 0.75), method="hazen")
    reach = 1.5 * (high - low)
    inside = values[(values >= low - reach) & (values <= high + reach)]
    return float(inside.min()), float(low), float(median), float(high), float(inside.max())


def draw_box(
    axes: Axes,
    place: float,
    values: Floats,
    look: Look,
    *,
    width: float = 0.5,
    filled: bool = False,
    hollow_marks: bool = False,
) -> None:
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
    inside, edge, edge_width = ("white", look.colour, 0.8) if hollow_marks else (look.colour, INK, 0.4)
    axes.plot(
        across, values, linestyle="none", marker=look.marker, markersize=3, markerfacecolor=inside,
        markeredgecolor=edge, markeredgewidth=edge_width,
    )  # fmt: skip


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
