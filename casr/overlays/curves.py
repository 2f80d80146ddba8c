"""Area against force with its rate, and growth frame by frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from casr.overlays.canvas import BLUE, GREEN, MUTED, ORANGE, Picture, plot, styled
from casr.spread import readable

if TYPE_CHECKING:
    from casr.spread import PowerLaw, SpreadRate


@styled
def area_curve(force_n: NDArray[np.float64], area: NDArray[np.float64], unit: str, rate: SpreadRate | None) -> Picture:
    """Contact area against force, and a line whose slope is the rate, with its interval; by a power law, that too.

    force_n, area : (T,).
    """
    figure, axes = plot("force (N)", f"contact area ({readable(unit)})")
    axes.plot(force_n, area, ".", color=BLUE, markersize=7, label="frame")
    caption = "Contact area of each frame against its force."
    if rate is not None and rate.rule != "paper":
        caption += " The slope of the line is the CASR."
        ends, middle = _line_through(force_n, area)
        if rate.law is not None and rate.window_n is not None:
            ends, middle = _chord(rate.law, rate.window_n)
            forces = np.linspace(*rate.window_n, 200)
            axes.plot(forces, rate.law.area(forces), color=MUTED, linewidth=1.2, label="power law")
            caption += " It joins two forces on the power law through the frames."
        away = ends - ends.mean()
        if rate.low is not None and rate.high is not None:
            sides = middle + np.outer([rate.low, rate.high], away)
            axes.fill_between(ends, sides[0], sides[1], color=ORANGE, alpha=0.3, linewidth=0)
            caption += f" Shaded: its 95 % interval, {rate.low:.3g} to {rate.high:.3g} {readable(rate.unit)}."
        words = f"CASR, {rate.value:.3g} {readable(rate.unit)}"
        axes.plot(ends, middle + rate.value * away, color=ORANGE, linewidth=2.2, label=words)
    axes.legend(loc="upper left")
    return Picture("area_over_force", "Contact area against force", caption, figure)


@styled
def growth_curve(frames: NDArray[np.int_], log_growth: NDArray[np.float64]) -> Picture:
    """Growth of each step and their sum, D_cum. frames : (T,); log_growth : (T-1,)."""
    figure, axes = plot("frame", "log growth of the contact region")
    total = np.concatenate([[0.0], np.cumsum(log_growth)])
    axes.bar(frames[1:], log_growth, color=GREEN, width=0.9, label="of one step")
    axes.plot(frames, total, color=BLUE, linewidth=2.2, label="sum since first contact")
    axes.axhline(0, color=MUTED, linewidth=0.8)
    axes.legend(loc="upper left")
    return Picture(
        "growth",
        "Growth frame by frame",
        f"Sum at the end {total[-1]:.3f}: the area grew to {np.exp(total[-1]):.2f} times its initial size.",
        figure,
    )


def _line_through(force_n: NDArray[np.float64], area: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(2,) lowest and highest force, N, and the mean area over that range: the least-squares line goes through it."""
    known = np.flatnonzero(np.isfinite(force_n) & np.isfinite(area))
    order = known[np.argsort(force_n[known], kind="stable")]
    force_n, area = force_n[order], area[order]
    ends = force_n[[0, -1]]
    return ends, float(np.trapezoid(area, force_n) / (ends[1] - ends[0]))


def _chord(law: PowerLaw, window_n: tuple[float, float]) -> tuple[NDArray[np.float64], float]:
    """(2,) forces, N, and the mean of the areas there."""
    ends = np.array(window_n)
    return ends, float(law.area(ends).mean())
