"""What the mixed model leaves: are the residuals normal, and do they scatter alike at every level?"""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.canvas import TWO_COLUMNS_MM, new_figure
from emg2vsa.figures.palette import BLUE, INK

MOST_DRAWN = 2000
"""Points that are drawn one by one; more are one picture, as a page with 100 000 shapes opens slowly."""


def draw_mixed_residuals(fitted: Floats, residual: Floats, quantile: Floats, scale: ActivityScale) -> Figure:
    """(a) Residuals over the SD of repetitions against normal quantiles; (b) against fitted slopes; (n,) each."""
    figure, (normal, level) = new_figure(TWO_COLUMNS_MM, 66, (13, 2, 11, 6), shares=(1, 1), gap_mm=16)
    points: dict[str, Any] = {"color": BLUE, "linestyle": "none", "marker": "o", "markeredgewidth": 0, "alpha": 0.6}
    points["rasterized"] = residual.size > MOST_DRAWN
    ends = [float(quantile.min()), float(quantile.max())]
    normal.plot(ends, ends, color=INK, linestyle="--", linewidth=0.8)
    normal.plot(quantile, residual, **points)
    normal.set(xlabel="Normal quantile", ylabel="Residual / SD of repetitions")
    normal.set_title("(a)", loc="left")
    level.axhline(0, color=INK, linestyle="--", linewidth=0.8)
    level.plot(fitted * scale.factor, residual, **points)
    level.set(xlabel=scale.label("Fitted b"), ylabel="Residual / SD of repetitions")
    level.set_title("(b)", loc="left")
    return figure
