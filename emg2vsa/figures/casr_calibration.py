"""Calibration: stiffness over CASR through the known specimens, and the new one read off the curve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.calibration.forms import kappa_of, x_of
from emg2vsa.calibration.results import AlgorithmResult, ConditionResult, LawResult
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import INK, MUTED, Look
from emg2vsa.settings import Law

_ACROSS = 3
_BEYOND = 0.08


def draw_calibrations(
    panels: Sequence[tuple[str, ConditionResult, AlgorithmResult]],
    looks: Mapping[str, Look],
    new: str,
    known_new: float,
) -> Figure:
    """panels : title, and what the chosen vision algorithm gives; known_new : stiffness of ``new``, NaN if unknown."""
    rows = -(-len(panels) // _ACROSS)
    figure, grid = panel_grid(rows, [1] * min(_ACROSS, len(panels)), 44, (13, 2, 12, 13), (12, 16))
    axes = [each for row in grid for each in row]
    for each, (title, condition, found) in zip(axes, panels, strict=False):
        _panel(each, condition, found, looks, new, known_new)
        each.set_title(title, loc="center")
        each.set_xlabel(f"CASR ({found.casr_unit.replace('2', '²')})")
    for unused in axes[len(panels) :]:
        unused.remove()
    for row in grid:
        row[0].set_ylabel("κ (N/mm)")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncols=max(1, len(labels)), columnspacing=1, handletextpad=0.4)
    return figure


def law_curve(result: LawResult, casr: Floats) -> Floats:
    """Stiffness (n,) in N/mm that the law gives for scores (n,); NaN where it gives none."""
    law = cast(Law, result.law)
    first, second = result.parameters
    level = np.log(first) if law in ("exponential", "power") else first
    return kappa_of(law, level + second * x_of(law, casr))


def _panel(
    axes: Axes,
    condition: ConditionResult,
    found: AlgorithmResult,
    looks: Mapping[str, Look],
    new: str,
    known_new: float,
) -> None:
    scores = [row[np.isfinite(row)] for row in (*found.casr, found.new_casr)]
    together = np.concatenate(scores)
    if not together.size:
        return
    reach = _BEYOND * (together.max() - together.min())
    casr = np.linspace(together.min() - reach, together.max() + reach, 200)
    top = 1.35 * float(np.max(condition.known_kappa))
    for result, dash, colour in ((found.chosen, "-", INK), (found.paper, ":", MUTED)):
        curve = law_curve(result, casr)
        shown = np.where(curve <= top, curve, np.nan)
        axes.plot(casr, shown, color=colour, linestyle=dash, label=f"{result.law}{' (paper)' if dash == ':' else ''}")
    for name, kappa, own in zip(condition.specimens, condition.known_kappa.tolist(), scores, strict=False):
        _presses(axes, own, kappa, looks[name], name)
    mean, kappa = float(np.mean(scores[-1])) if scores[-1].size else np.nan, found.chosen.kappa
    axes.vlines(mean, found.chosen.low, min(found.chosen.high, top), colors=looks[new].colour, linewidth=1.4)
    if found.chosen.high > top:
        # the interval goes on beyond the panel
        axes.plot(mean, top, marker="^", markersize=5, color=looks[new].colour, clip_on=False)
    axes.plot(
        mean, kappa, linestyle="none", marker=looks[new].marker, markersize=6, color=looks[new].colour,
        markeredgecolor=INK, markeredgewidth=0.4, label=new,
    )  # fmt: skip
    if np.isfinite(known_new):
        axes.axhline(known_new, color=looks[new].colour, linestyle=(0, (1, 1)), linewidth=0.8, label="known κ")
    axes.set_ylim(0, top)


def _presses(axes: Axes, scores: Floats, kappa: float, look: Look, name: str) -> None:
    """All presses, pale, and their mean."""
    axes.plot(
        scores, np.full(scores.size, kappa), linestyle="none", marker=look.marker, markersize=2.5, alpha=0.5,
        color=look.colour, markeredgewidth=0,
    )  # fmt: skip
    if scores.size:
        axes.plot(
            float(np.mean(scores)), kappa, linestyle="none", marker=look.marker, markersize=5, color=look.colour,
            markeredgecolor=INK, markeredgewidth=0.4, label=name,
        )  # fmt: skip
