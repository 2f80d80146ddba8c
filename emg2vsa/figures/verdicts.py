"""Every claim on data, by question: its interval in units of the smallest difference that matters, and its verdict."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from casr.palette import BAD, GOOD
from emg2vsa.claims.claim import Judged, Verdict
from emg2vsa.figures.canvas import new_figure
from emg2vsa.figures.palette import GREEN, INK, MUTED, RED

COLOURS: dict[Verdict, str] = {"holds": GREEN, "refuted": RED, "not determined": MUTED}
_WORDS_IN: dict[Verdict, str] = {"holds": GOOD, "refuted": BAD, "not determined": MUTED}
_MARKERS: dict[Verdict, str] = {"holds": "o", "refuted": "X", "not determined": "D"}
_LOW, _HIGH = -12.0, 40.0
"""Ends of the axis; an interval that goes on beyond it ends in an arrow."""
_TICKS = (-10, -2, -1, 0, 1, 2, 10, 30)
_WIDTH_MM, _ROW_MM = 100.0, 6.4
"""A telephone shows the whole width."""
_LETTERS = 76
"""Most letters of a claim; longer ones end in an ellipsis."""
_WORDS, _LINE = -0.2, 0.25
"""Places in a row of its words and its interval."""


def draw_verdicts(judged: Sequence[Judged]) -> Figure:
    """The region of each claim is shaded: an interval wholly inside it holds."""
    rows: list[Judged | str] = []
    for question, of in groupby(judged, lambda each: each.claim.question):
        rows += [question, *of]
    figure, (axes,) = new_figure(_WIDTH_MM, _ROW_MM * len(rows) + 14, (3, 27, 11, 3))
    axes.set_xscale("symlog", linthresh=2, linscale=1.2)
    axes.set(xlim=(_LOW, _HIGH), ylim=(len(rows) - 0.4, -0.4), yticks=[], xticks=_TICKS)
    axes.set_xticklabels([f"{tick:g}" for tick in _TICKS])
    axes.minorticks_off()
    axes.set_xlabel("Estimate and interval; 1: smallest difference that matters", loc="left")
    axes.spines["left"].set_visible(False)
    for place, row in enumerate(rows):
        if isinstance(row, str):
            _say(axes, 0, place + 0.1, row[0].upper() + row[1:], weight="bold")
        else:
            _draw(axes, place, row)
    return figure


def _say(axes: Axes, across: float, place: float, text: str, **more: Any) -> None:
    axes.text(across, place, text, transform=axes.get_yaxis_transform(), va="center", fontsize=7, **more)


def _draw(axes: Axes, place: float, each: Judged) -> None:
    claim, colour = each.claim, COLOURS[each.verdict]
    _say(
        axes, 0, place + _WORDS, claim.says if len(claim.says) <= _LETTERS else f"{claim.says[: _LETTERS - 1]}…"
    )  # above its line, so that it may be longer than the axes are wide
    at = place + _LINE
    _say(axes, 1.04, at, each.verdict, color=_WORDS_IN[each.verdict], weight="bold")
    left, right = (0.0, _HIGH) if claim.asserts == "more" else (_LOW, 1.0)
    axes.fill_between([left, right], at - 0.18, at + 0.18, color=GREEN, alpha=0.18, linewidth=0)
    low, value, high = (end / claim.margin for end in (each.low, claim.found.estimate, each.high))
    if np.isfinite(value) and not np.isnan(low):
        axes.plot([max(low, _LOW), min(high, _HIGH)], [at, at], color=INK, linewidth=1.0)
        for beyond, edge, marker in ((low < _LOW, _LOW, "<"), (high > _HIGH, _HIGH, ">")):
            if beyond:
                axes.plot(edge, at, marker=marker, color=INK, markersize=4, clip_on=False)
        where = min(max(value, _LOW), _HIGH)
        axes.plot(where, at, marker=_MARKERS[each.verdict], color=colour, markersize=4.5, linestyle="none")
