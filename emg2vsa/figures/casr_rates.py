"""Figures 10, 12 and 13: contact area against force with a power law, and box plots of the rates, row by row."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from casr.spread.power_law import fit_power_law
from emg2vsa.arrays import Floats
from emg2vsa.figures.boxes import draw_box
from emg2vsa.figures.canvas import show_zero
from emg2vsa.figures.grid import panel_grid
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
