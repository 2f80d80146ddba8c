"""Co-contraction of all people against force: (a) by specimen, (b) how far specimens differ, (c) which pairs differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.companions.whole_curve import WholeCurve
from emg2vsa.figures.canvas import legend_inside, marks, panel_grid, short, show_zero
from emg2vsa.figures.palette import BLUE, GREY, INK, ActivityScale, Look


def draw_whole_curve(
    found: WholeCurve, pairs: Sequence[int], neighbours: Sequence[int], looks: Mapping[str, Look], scale: ActivityScale
) -> Figure:
    """pairs : numbers of those that are drawn, from the top; neighbours : those of them in the colour that is seen."""
    figure, ((curves, statistic, differing),) = panel_grid(1, (1.25, 1, 0.9), 52, (13, 2, 11, 6), (15, 0))
    tests, force_n, ranges = found.tests, (found.from_n + found.to_n) / 2, found.ranges()
    for name, mean, half in zip(found.specimens.tolist(), tests.mean, tests.half_width, strict=True):
        v, half = mean * scale.factor, np.where(np.isfinite(half), half * scale.factor, np.nan)
        curves.fill_between(force_n, v - half, v + half, color=looks[name].colour, alpha=0.25, linewidth=0)
        every = max(1, force_n.size // 8)
        marks(curves, force_n, v, looks[name], linestyle=looks[name].dash, markevery=every, label=short(name))
    curves.set_ylabel(scale.label("Co-contraction"))
    show_zero(curves, tests.mean)
    legend_inside(curves, "upper left")
    statistic.plot(force_n, np.where(np.isinf(tests.f), np.nan, tests.f), color=INK, marker=".")
    if np.isfinite(tests.f_threshold.value):
        statistic.axhline(tests.f_threshold.value, color=INK, linestyle="--", linewidth=0.8)
    for low, high in zip(ranges.from_n[ranges.pair < 0], ranges.to_n[ranges.pair < 0], strict=True):
        statistic.axvspan(low, high, color=BLUE, alpha=0.15, linewidth=0)
    statistic.set(ylabel="F between specimens", yscale="log" if np.any(tests.f > 0) else "linear")
    differing.hlines(-np.arange(len(pairs)), found.from_n[0], found.to_n[-1], colors=GREY, linewidth=0.6)
    for row, pair in enumerate(pairs):
        own = ranges.pair == pair
        colour = BLUE if pair in neighbours else GREY
        differing.hlines(np.full(own.sum(), -row), ranges.from_n[own], ranges.to_n[own], colors=colour, linewidth=4)
    differing.set_yticks(
        -np.arange(len(pairs)), ["–".join(short(name, 6) for name in found.pairs[pair]) for pair in pairs]
    )
    differing.set_ylim(-len(pairs) + 0.4, 0.6)
    differing.grid(axis="y", visible=False)
    for axes in (curves, statistic, differing):
        axes.set(xlabel="Force (N)", xlim=(0, None))
    return figure
