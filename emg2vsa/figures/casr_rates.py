"""The contact area spread rate.

Figures 10, 12 and 13: contact area against force with a power law, and box plots of the rates, row by row. Figure 14:
rates by specimen at each angle, pressed rigidly and as people do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from casr.spread.power_law import fit_power_law
from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import draw_box
from emg2vsa.figures.canvas import panel_grid, show_zero
from emg2vsa.figures.palette import INK, Look

_MARKS = 90


@dataclass(frozen=True)
class RateSeries:
    """One specimen of a row. force_n, area : (M,) frames of all presses. casr : (n,) of the presses."""

    name: str
    look: Look
    force_n: Floats
    area: Floats
    casr: Floats


def draw_rates(rows: Sequence[tuple[str, Sequence[RateSeries]]], unit: str) -> Figure:
    """rows : title and specimens, stiffest first; ``unit`` of the area."""
    figure, panels = panel_grid(len(rows), (1.15, 1), 46, (13, 2, 11, 13), (17, 12))
    for (raw, boxes), (title, specimens) in zip(panels, rows, strict=True):
        for series in specimens:
            _raw(raw, series)
        for place, series in enumerate(specimens):
            draw_box(boxes, place, series.casr, series.look)
        raw.set(ylabel=f"Contact area ({unit})", xlim=(0, None))
        show_zero(raw, np.concatenate([s.area for s in specimens]) if specimens else [])
        boxes.set_xticks(range(len(specimens)), [series.name for series in specimens])
        boxes.set(xlim=(-0.6, len(specimens) - 0.4), ylabel=f"CASR ({unit}/N)")
        boxes.grid(axis="x", visible=False)
        raw.set_title(title, loc="center")
    panels[-1][0].set_xlabel("Force (N)")
    named = {series.name: series.look for _, specimens in rows for series in specimens}
    for name, look in named.items():
        panels[0][0].plot(
            [], [], color=look.colour, linestyle=look.dash, marker=look.marker, markeredgecolor=INK,
            markeredgewidth=0.4, label=name,
        )  # fmt: skip
    figure.legend(loc="upper center", ncols=len(named) or 1)
    return figure


def curve_of(series: RateSeries) -> tuple[Floats, Floats]:
    """(50,) forces and areas of the power law through the frames of all presses; (0,) where they have one force."""
    known = (series.force_n > 0) & (series.area > 0)
    force_n, area = series.force_n[known], series.area[known]
    if not force_n.size or np.ptp(force_n) == 0:
        return np.empty(0), np.empty(0)
    at = np.linspace(force_n.min(), force_n.max(), 50)
    return at, fit_power_law(area, force_n).law.area(at)


def _raw(axes: Axes, series: RateSeries) -> None:
    if not series.force_n.size:
        return
    # a step prime to the frames of a press shows all presses and all forces alike
    every = max(1, series.force_n.size // _MARKS) | 1
    axes.plot(
        series.force_n[::every], series.area[::every], linestyle="none", marker=series.look.marker, markersize=2.5,
        color=series.look.colour, alpha=0.55, markeredgewidth=0,
    )  # fmt: skip
    axes.plot(*curve_of(series), color=series.look.colour, linestyle=series.look.dash)


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

    @property
    def percent(self) -> Floats:
        """(n,) by which the human-like presses exceed the mean of the rigid ones."""
        rigid = self.rigid[np.isfinite(self.rigid)]
        return 100 * (self.human_like / rigid.mean() - 1) if rigid.size else np.empty(0)


def draw_conditions(panels: Sequence[tuple[str, Sequence[ConditionBoxes]]], unit: str) -> Figure:
    """panels : title and specimens, stiffest first; ``unit`` of the area.

    Above the levels, left and hollow rigid, right and filled human-like; below how far the human-like presses lie from
    the mean of the rigid ones. Each row has one scale.
    """
    figure, (levels, differences) = panel_grid(2, [1] * len(panels), 42, (15, 2, 8, 13), (6, 9))
    for above, below, (title, specimens) in zip(levels, differences, panels, strict=True):
        below.axhline(0, color=INK, linewidth=0.6)
        for place, each in enumerate(specimens):
            draw_box(above, place - _ASIDE, each.rigid, each.look, width=0.36, hollow_marks=True)
            draw_box(above, place + _ASIDE, each.human_like, each.look, width=0.36, filled=True)
            draw_box(below, place, each.percent, each.look, filled=True)
        for axes in (above, below):
            axes.set_xticks(range(len(specimens)), [each.name for each in specimens])
            axes.set_xlim(-0.6, len(specimens) - 0.4)
            axes.grid(axis="x", visible=False)
        above.set_title(title, loc="center")
    for row, name in ((levels, f"CASR ({unit}/N)"), (differences, "Human-like less rigid (%)")):
        low, high = np.transpose([axes.get_ylim() for axes in row])
        for axes in row:
            axes.set_ylim(low.min(), high.max())
            axes.tick_params(labelleft=axes is row[0])
        row[0].set_ylabel(name)
    figure.legend(
        handles=[
            Line2D([], [], marker="o", linestyle="none", markerfacecolor="white", markeredgecolor=INK, label=_RIGID),
            Line2D([], [], marker="o", linestyle="none", markerfacecolor=INK, markeredgecolor=INK, label=_HUMAN_LIKE),
        ],
        loc="upper center",
        ncols=2,
    )
    return figure
