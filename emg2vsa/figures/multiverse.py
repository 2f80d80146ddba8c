"""Where verdicts hang on choices: claims by kinds of choice, and the share of paths that keep each verdict."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import Verdict
from emg2vsa.figures.canvas import TWO_COLUMNS_MM, new_figure
from emg2vsa.figures.palette import INK
from emg2vsa.figures.verdicts import COLOURS

_ROW_MM, _LABELS_MM, _LETTERS = 5.6, 72, 52
_PALEST, _DARKEST = 0.06, 0.5
"""Opacity of a cell whose verdict no path keeps, and of one whose verdict all keep."""


def draw_paths(says: Sequence[str], verdicts: Sequence[Verdict], kinds: Sequence[str], share: Floats) -> Figure:
    """share : (C, K) of the paths of each of K kinds, of all in the first one; NaN where none bears on the claim."""
    rows, columns = share.shape
    height_mm = _ROW_MM * rows + 27
    figure, (axes,) = new_figure(TWO_COLUMNS_MM, height_mm, (_LABELS_MM, 14, 2, 25))
    axes.set(xlim=(-0.5, columns - 0.5), ylim=(rows - 0.5, -0.5), yticks=[])
    axes.grid(visible=False)
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.xaxis.tick_top()
    axes.set_xticks(range(columns), list(kinds), rotation=50, ha="left", rotation_mode="anchor", fontsize=7)
    axes.tick_params(length=0)
    axes.get_xticklabels()[0].set_fontweight("bold")
    for row, (claim, verdict) in enumerate(zip(says, verdicts, strict=True)):
        text = fill(f"{claim[0].upper()}{claim[1:]}", _LETTERS)
        axes.text(-0.7, row, text, ha="right", va="center", fontsize=6.5, linespacing=0.95)
        for column in np.flatnonzero(np.isfinite(share[row])).tolist():
            kept = float(share[row, column])
            colour = to_rgba(COLOURS[verdict], _PALEST + (_DARKEST - _PALEST) * kept)
            axes.add_patch(Rectangle((column - 0.48, row - 0.46), 0.96, 0.92, facecolor=colour, edgecolor="none"))
            weight = "normal" if column else "bold"
            axes.text(column, row, _percent(kept), ha="center", va="center", fontsize=6.5, weight=weight, color=INK)
    return figure


def _percent(share: float) -> str:
    """Whole percent; 100 and 0 are all and none."""
    return str(int(np.clip(round(100 * share), int(share > 0), 100 - int(share < 1))))
