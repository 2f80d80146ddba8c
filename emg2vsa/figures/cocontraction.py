"""Figure 4: what the muscles do. (a) mean fitted trends; (b) the slopes b, with what the tests say of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from emg2vsa.arrays import Floats
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.canvas import TWO_COLUMNS_MM, new_figure, show_zero
from emg2vsa.figures.palette import INK, Look
from emg2vsa.profiles import Profile

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


def hazen_box(b: Floats) -> tuple[float, float, float, float, float]:
    """Lower whisker, quartiles, upper whisker. Hazen's quantiles, as MATLAB's boxplot; whiskers within 1.5 IQR."""
    low, median, high = np.quantile(b, (0.25, 0.5, 0.75), method="hazen")
    reach = 1.5 * (high - low)
    inside = b[(b >= low - reach) & (b <= high + reach)]
    return float(inside.min()), float(low), float(median), float(high), float(inside.max())


def draw_cocontraction(
    profiles: Sequence[Profile],
    slopes: Sequence[Floats],
    bars: Sequence[PairBar],
    looks: Sequence[Look],
    scale: ActivityScale,
    bar_legend: str,
) -> Figure:
    """profiles, slopes (n,) and looks belong together, one per specimen; ``bar_legend`` names test and correction."""
    figure, (trends, boxes) = new_figure(TWO_COLUMNS_MM, 72, (13, 2, 11, 6), shares=(1, 1), gap_mm=16)
    for profile, look in zip(profiles, looks, strict=True):
        _trend(trends, profile, look, scale)
    trends.set(xlabel="Force (N)", ylabel=scale.label("Co-contraction"), xlim=(0, None))
    show_zero(trends, [profile.v for profile in profiles])
    trends.set_title("(a)", loc="left")
    falling = sum(profile.b_v < 0 for profile in profiles)
    trends.legend(loc="upper right" if 2 * falling > len(profiles) else "upper left")
    for place, (b, look) in enumerate(zip(slopes, looks, strict=True)):
        if b.size:
            _box(boxes, place, b * scale.factor, look)
    boxes.set_xticks(range(len(profiles)), [profile.specimen for profile in profiles])
    boxes.set(xlim=(-0.6, len(profiles) - 0.4), ylabel=scale.label("Slope b"))
    boxes.grid(axis="x", visible=False)
    boxes.set_title("(b)", loc="left")
    _bars(boxes, bars, bar_legend)
    return figure


def _trend(axes: Axes, profile: Profile, look: Look, scale: ActivityScale) -> None:
    v, sd = profile.v * scale.factor, profile.sd_v * scale.factor
    axes.fill_between(profile.force_n, v - sd, v + sd, color=look.colour, alpha=0.18, linewidth=0)
    every = max(1, profile.force_n.size // 8)
    axes.plot(
        profile.force_n, v, color=look.colour, linestyle=look.dash, marker=look.marker, markevery=every,
        markeredgecolor=INK, markeredgewidth=0.4, label=profile.specimen,
    )  # fmt: skip


def _box(axes: Axes, place: int, b: Floats, look: Look) -> None:
    bottom, low, median, high, top = hazen_box(b)
    axes.vlines([place, place], [bottom, high], [low, top], colors=INK, linewidth=0.7)
    axes.hlines([bottom, top], place - 0.1, place + 0.1, colors=INK, linewidth=0.7)
    box = Rectangle((place - 0.25, low), 0.5, high - low, facecolor="none", edgecolor=look.colour, linewidth=1.2)
    axes.add_patch(box)
    axes.hlines(median, place - 0.25, place + 0.25, colors=INK, linewidth=1.4)
    # neighbours in rank lie side by side, the same at every run
    across = (
        place + 0.16 * np.tile([-1.0, 0.0, 1.0, -0.5, 0.5], -(-b.size // 5))[np.argsort(np.argsort(b, kind="stable"))]
    )
    axes.plot(
        across, b, linestyle="none", marker=look.marker, markersize=3, color=look.colour,
        markeredgecolor=INK, markeredgewidth=0.4,
    )  # fmt: skip


def _bars(axes: Axes, bars: Sequence[PairBar], legend: str) -> None:
    low, high = axes.get_ylim()
    step = 0.09 * (high - low)
    for level, bar in enumerate(sorted(bars, key=lambda bar: (bar.second - bar.first, bar.first))):
        y = high + (level + 0.3) * step
        axes.plot([bar.first, bar.first, bar.second, bar.second], [y, y + step / 5, y + step / 5, y], color=INK, lw=0.7)
        axes.text((bar.first + bar.second) / 2, y + step / 6, stars(bar.p), ha="center", va="bottom")
    axes.set_ylim(low, high + (len(bars) + 0.6) * step)
    if bars:
        axes.set_title(legend, loc="right", fontsize=7)
