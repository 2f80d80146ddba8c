"""The contact area spread rate.

Figures 10, 12 and 13: dA/dF from frame to frame against force with its fit, and box plots of the rates of the presses,
row by row. Figure 14: rates by specimen at each angle, pressed rigidly and as people do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from casr.spread.curves import fit_power_law
from casr.spread.rate import MIN_STEP_N
from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import draw_box
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import INK, Look

_MARKS = 120
_SHARE_SHOWN = 0.98


@dataclass(frozen=True)
class RateSeries:
    """One specimen of a row. presses : forces (T,) and areas (T,) of the frames of each. casr : (n,) of the presses."""

    name: str
    look: Look
    presses: Sequence[tuple[Floats, Floats]]
    casr: Floats
    exponential: bool = False
    "Whether areas follow equation (1) as printed, A = c exp(D F); else a power law, A = c F^m."

    @property
    def quotients(self) -> tuple[Floats, Floats]:
        """(M,) forces midway and dA/dF from each frame of a press to the next, but for steps of nearly no force."""
        force_n, rate = [np.empty(0)], [np.empty(0)]
        for force, area in self.presses:
            step = np.diff(force)
            known = np.abs(step) >= MIN_STEP_N
            force_n.append((force[:-1] + force[1:])[known] / 2)
            rate.append(np.diff(area)[known] / step[known])
        return np.concatenate(force_n), np.concatenate(rate)

    @property
    def fit(self) -> tuple[Floats, Floats]:
        """(50,) forces and dA/dF of the law through the areas of all presses; (0,) where they have one force."""
        force_n, area = (np.concatenate([np.empty(0), *(press[part] for press in self.presses)]) for part in (0, 1))
        known = (force_n > 0) & (area > 0)
        force_n, area = force_n[known], area[known]
        if not force_n.size or np.ptp(force_n) == 0:
            return np.empty(0), np.empty(0)
        at = np.linspace(force_n.min(), force_n.max(), 50)
        if self.exponential:
            rate, level = np.polyfit(force_n, np.log(area), 1)
            return at, rate * np.exp(level + rate * at)
        law = fit_power_law(area, force_n).law
        return at, law.exponent * law.area(at) / at


def draw_rates(rows: Sequence[tuple[str, Sequence[RateSeries]]], unit: str) -> Figure:
    """rows : title and specimens, stiffest first; ``unit`` of the area."""
    figure, panels = panel_grid(len(rows), (1.15, 1), 46, (13, 2, 11, 13), (17, 12))
    for (raw, boxes), (title, specimens) in zip(panels, rows, strict=True):
        for series in specimens:
            _raw(raw, series)
        for place, series in enumerate(specimens):
            draw_box(boxes, place, series.casr, series.look)
        raw.set(ylabel=f"dA/dF ({unit}/N)", xlim=(0, None))
        _keep_most(raw, [series.quotients[1] for series in specimens])
        boxes.set_xticks(range(len(specimens)), [series.name for series in specimens])
        boxes.set(xlim=(-0.6, len(specimens) - 0.4), ylabel=f"CASR ({unit}/N)")
        boxes.grid(axis="x", visible=False)
        raw.set_title(title, loc="center")
    panels[-1][0].set_xlabel("Force (N)")
    _one_scale([boxes for _, boxes in panels])
    named = {series.name: series.look for _, specimens in rows for series in specimens}
    for name, look in named.items():
        panels[0][0].plot(
            [], [], color=look.colour, linestyle=look.dash, marker=look.marker, markeredgecolor=INK,
            markeredgewidth=0.4, label=name,
        )  # fmt: skip
    figure.legend(loc="upper center", ncols=len(named) or 1)
    return figure


_LEAST_SPAN = 0.15


def _one_scale(column: Sequence[Axes]) -> None:
    """The same scale for all, unless that would leave the boxes of one of them flat."""
    low, high = np.transpose([axes.get_ylim() for axes in column])
    if (high - low).min() < _LEAST_SPAN * (high.max() - low.min()):
        return
    for axes in column:
        axes.set_ylim(low.min(), high.max())


def _keep_most(axes: Axes, rates: Sequence[Floats]) -> None:
    """A quotient of two small differences may be anything: the scale leaves the furthest of them out, and says so."""
    together = np.concatenate([np.zeros(1), *rates])
    far = (1 - _SHARE_SHOWN) / 2
    low, high = np.quantile(together, (far, 1 - far))
    room = 0.08 * (high - low) or 1.0
    low, high = min(low - room, 0.0) if low < 0 else 0.0, high + room
    axes.set_ylim(low, high)
    if outside := int(np.count_nonzero((together < low) | (together > high))):
        axes.set_title(f"{outside} beyond", loc="right", fontsize=7)


def _raw(axes: Axes, series: RateSeries) -> None:
    force_n, rate = series.quotients
    if not force_n.size:
        return
    # a step prime to the frames of a press shows all presses and all forces alike
    every = max(1, force_n.size // _MARKS) | 1
    axes.plot(
        force_n[::every], rate[::every], linestyle="none", marker=series.look.marker, markersize=2.5,
        color=series.look.colour, alpha=0.55, markeredgewidth=0,
    )  # fmt: skip
    axes.plot(*series.fit, color=series.look.colour, linestyle=series.look.dash)


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
