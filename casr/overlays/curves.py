"""Area against force with its slope, and growth frame by frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from casr.overlays.canvas import BLUE, GREEN, MUTED, ORANGE, Picture, plot

if TYPE_CHECKING:
    from casr.spread import SpreadRate


def area_curve(
    force_n: NDArray[np.float64], area: NDArray[np.float64], unit: str, rate: SpreadRate | None
) -> Picture:
    """Contact area against force; the slope rule's line and its interval through the middle of the points.

    force_n, area : (T,).
    """
    figure, axes = plot("force (N)", f"contact area ({unit})")
    axes.plot(force_n, area, ".", color=BLUE, markersize=7, label="frame")
    caption = "Contact area of each frame against its force."
    known = np.isfinite(force_n) & np.isfinite(area)
    if rate is not None and rate.rule == "slope" and known.any():
        ends = np.array([force_n[known].min(), force_n[known].max()])
        middle = (float(np.median(force_n[known])), float(np.median(area[known])))
        line, low, high = (middle[1] + slope * (ends - middle[0]) for slope in (rate.value, rate.low, rate.high))
        x = np.linspace(*ends, 50)
        spread = [middle[1] + np.outer([rate.low, rate.high], x - middle[0])]
        axes.fill_between(x, *(f(spread[0], axis=0) for f in (np.min, np.max)), color=ORANGE, alpha=0.3, linewidth=0)
        axes.plot(ends, line, color=ORANGE, linewidth=2.2, label=f"slope {rate.value:.3g} {rate.unit}")
        caption += f" The line's slope is the CASR; shaded: its interval, {rate.low:.3g} to {rate.high:.3g} {rate.unit}."
    axes.legend(loc="upper left")
    return Picture("area_over_force", "Contact area against force", caption, figure)


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
