"""Figure 14: CASR by specimen at each angle, pressed rigidly and as people do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import draw_box
from emg2vsa.figures.grid import panel_grid
from emg2vsa.figures.palette import INK, Look

_ASIDE = 0.21
_RIGID = "left, hollow: rigid (high stiffness)"
_HUMAN_LIKE = "right, filled: human-like (modular stiffness)"


@dataclass(frozen=True)
class ConditionBoxes:
    """One specimen at one angle: scores (n,) of both conditions."""

    name: str
    look: Look
    rigid: Floats
    human_like: Floats


def draw_conditions(panels: Sequence[tuple[str, Sequence[ConditionBoxes]]], unit: str) -> Figure:
    """panels : title and specimens, stiffest first; ``unit`` of the area. Left and hollow is rigid, right and
    filled human-like."""
    figure, (row,) = panel_grid(1, [1] * len(panels), 52, (13, 2, 8, 13), (13, 0))
    for axes, (title, specimens) in zip(row, panels, strict=True):
        for place, each in enumerate(specimens):
            draw_box(axes, place - _ASIDE, each.rigid, each.look, width=0.36, hollow_marks=True)
            draw_box(axes, place + _ASIDE, each.human_like, each.look, width=0.36, filled=True)
        axes.set_xticks(range(len(specimens)), [each.name for each in specimens])
        axes.set_xlim(-0.6, len(specimens) - 0.4)
        axes.grid(axis="x", visible=False)
        axes.set_title(title, loc="center")
    row[0].set_ylabel(f"CASR ({unit}/N)")
    figure.legend(
        handles=[
            Line2D([], [], marker="o", linestyle="none", markerfacecolor="white", markeredgecolor=INK, label=_RIGID),
            Line2D([], [], marker="o", linestyle="none", markerfacecolor=INK, markeredgecolor=INK, label=_HUMAN_LIKE),
        ],
        loc="upper center",
        ncols=2,
    )
    return figure
