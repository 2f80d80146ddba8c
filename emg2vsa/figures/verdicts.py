"""Every claim on data, by question: its interval in units of the smallest difference that matters, and its verdict."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.claims.claim import Judged, Verdict
from emg2vsa.figures.canvas import TWO_COLUMNS_MM, new_figure
from emg2vsa.figures.palette import GREEN, INK, MUTED, RED

COLOURS: dict[Verdict, str] = {"holds": GREEN, "refuted": RED, "not determined": MUTED}
_DARK = "#2f6b4a"
"""Green that can be read as a word."""
_MARKERS: dict[Verdict, str] = {"holds": "o", "refuted": "X", "not determined": "D"}
_LOW, _HIGH = -12.0, 40.0
"""Of the axis; an interval that goes on beyond it ends in an arrow."""
_TICKS = (-10, -2, -1, 0, 1, 2, 10, 30)
_ROW_MM, _LABELS_MM, _VERDICTS_MM = 5.6, 84, 26
_LETTERS = 58


def draw_verdicts(judged: Sequence[Judged]) -> Figure:
    """The region of each claim is shaded: an interval wholly inside it holds."""
    rows: list[Judged | str] = []
    for question, of in groupby(judged, lambda each: each.claim.question):
        rows += [question, *of]
    height_mm = _ROW_MM * len(rows) + 16
    figure, (axes,) = new_figure(TWO_COLUMNS_MM, height_mm, (_LABELS_MM, _VERDICTS_MM, 11, 5))
    axes.set_xscale("symlog", linthresh=2, linscale=1.2)
    axes.set(xlim=(_LOW, _HIGH), ylim=(len(rows) - 0.5, -0.5), yticks=[], xticks=_TICKS)
    axes.set_xticklabels([f"{tick:g}" for tick in _TICKS])
    axes.minorticks_off()
    axes.set_xlabel("Estimate and interval; 1: smallest difference that matters")
    axes.spines["left"].set_visible(False)
    for place, row in enumerate(rows):
        if isinstance(row, str):
            _label(axes, place, row[0].upper() + row[1:], weight="bold")
        else:
            _draw(axes, place, row)
    return figure


def _label(axes: Axes, place: float, text: str, **more: Any) -> None:
    axes.text(
        -0.02, place, fill(text, _LETTERS), transform=axes.get_yaxis_transform(), ha="right", va="center",
        fontsize=7, linespacing=0.95, **more,
    )  # fmt: skip


def _draw(axes: Axes, place: float, each: Judged) -> None:
    claim, colour = each.claim, COLOURS[each.verdict]
    left, right = (0.0, _HIGH) if claim.asserts == "more" else (_LOW, 1.0)
    axes.fill_between([left, right], place - 0.42, place + 0.42, color=GREEN, alpha=0.13, linewidth=0)
    _label(axes, place, claim.says)
    axes.text(
        1.02, place, each.verdict, transform=axes.get_yaxis_transform(), ha="left", va="center",
        color=_DARK if each.verdict == "holds" else colour, weight="bold", fontsize=7,
    )  # fmt: skip
    low, value, high = (end / claim.margin for end in (each.low, claim.found.estimate, each.high))
    if np.isfinite(value) and not np.isnan(low):
        axes.plot([max(low, _LOW), min(high, _HIGH)], [place, place], color=INK, linewidth=1.0)
        for beyond, edge, marker in ((low < _LOW, _LOW, "<"), (high > _HIGH, _HIGH, ">")):
            if beyond:
                axes.plot(edge, place, marker=marker, color=INK, markersize=4, clip_on=False)
        at = min(max(value, _LOW), _HIGH)
        axes.plot(at, place, marker=_MARKERS[each.verdict], color=colour, markersize=5, linestyle="none")
