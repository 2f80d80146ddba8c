"""Area against force with its rate, and growth frame by frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from casr.overlays.canvas import BLUE, FAINT, GREEN, MUTED, ORANGE, Picture, plot, styled
from casr.spread import readable
from casr.spread.correlated_errors import normal_quantile
from casr.spread.rate import CONFIDENCE

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from casr.score import Score
    from casr.spread import PowerLaw


@styled
def area_curve(score: Score) -> Picture:
    """Areas by both quantities against force; the front with its interval, and a line whose slope is the CASR."""
    assert score.force_n is not None
    unit, force_n, front = readable(score.area_unit), score.force_n, score.front
    figure, axes = plot("force (N)", f"area ({unit})")
    counts = front.determined & (score.front_doubt == "")
    reach = np.exp(normal_quantile(CONFIDENCE) * front.relative_sd)
    caption = "Front: contact area of each frame. Skin: the area of the first contact's skin."
    if not counts.all():
        axes.plot(force_n[~counts], front.area[~counts], "x", color=FAINT, markersize=5, label="front, not determined")
        caption += " Grey: the front is not determined, these frames do not count."
    if counts.any():
        order = np.flatnonzero(counts)[np.argsort(force_n[counts], kind="stable")]
        sides = (front.area / reach)[order], (front.area * reach)[order]
        axes.fill_between(force_n[order], *sides, color=BLUE, alpha=0.15, linewidth=0)
        axes.plot(force_n[counts], front.area[counts], ".", color=BLUE, markersize=7, label="front")
        caption += " Shaded: 95 % of each area."
    axes.plot(force_n, score.skin.area, ".", color=GREEN, markersize=5, label="skin")
    caption += _line_of_rate(axes, score)
    axes.set_ylim(bottom=0)
    axes.legend(loc="upper left")
    return Picture("area_over_force", "Area against force", caption, figure)


def _line_of_rate(axes: Axes, score: Score) -> str:
    """Draw the CASR by the quantity of the score; what that is, in words."""
    rate, force_n = score.rate, score.force_n
    if rate is None or force_n is None or rate.rule == "paper":
        return ""
    ends, middle = _line_through(force_n, score.area)
    said = f" The slope of the line is the CASR ({score.settings.quantity})."
    if rate.law is not None and rate.window_n is not None:
        ends, middle = _chord(rate.law, rate.window_n)
        forces = np.linspace(*rate.window_n, 200)
        axes.plot(forces, rate.law.area(forces), color=MUTED, linewidth=1.2, label="power law")
        said += " It joins two forces on the power law through the frames."
    words = f"CASR ({score.settings.quantity}), {rate.value:.3g} {readable(rate.unit)}"
    axes.plot(ends, middle + rate.value * (ends - ends.mean()), color=ORANGE, linewidth=2.2, label=words)
    total = score.interval
    return said + (
        f" Its total 95 % interval: {total.low:.3g} to {total.high:.3g} {readable(rate.unit)}." if total else ""
    )


@styled
def growth_curve(frames: NDArray[np.int_], log_growth: NDArray[np.float64]) -> Picture:
    """Growth of each step and their sum, D_cum. frames : (T,); log_growth : (T-1,)."""
    figure, axes = plot("frame", "log growth of the skin")
    total = np.concatenate([[0.0], np.cumsum(log_growth)])
    axes.bar(frames[1:], log_growth, color=GREEN, width=0.9, label="of one step")
    axes.plot(frames, total, color=BLUE, linewidth=2.2, label="sum since first contact")
    axes.axhline(0, color=MUTED, linewidth=0.8)
    axes.legend(loc="upper left")
    return Picture(
        "growth",
        "Growth of the skin frame by frame",
        f"Sum at the end {total[-1]:.3f}: the skin of the first contact grew to {np.exp(total[-1]):.2f} times its initial size.",
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
