"""Area against force with its rate, and growth frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from casr.palette import BLUE, FAINT, GREEN, MUTED, YELLOW
from casr.scored import Score
from casr.spread import readable
from casr.spread.intervals import CONFIDENCE, normal_quantile
from casr.svg import Picture, plot


def area_curve(score: Score) -> Picture:
    """Areas by both quantities against force, without a force log frame by frame.

    The front comes with its interval, and with a force log there is a line whose slope is the CASR.
    """
    by_force = score.force_n is not None
    x = np.asarray(score.frames, dtype=np.float64) if score.force_n is None else score.force_n
    front, skin = score.front, score.skin.area
    counts = front.determined & (score.front_doubt == "")
    reach = np.exp(normal_quantile(CONFIDENCE) * front.relative_sd)
    rate = _drawn_rate(score)
    law = rate.law if rate else np.empty((0, 2))
    heights = np.concatenate([[0.0], skin, np.where(counts, front.area * reach, front.area), law[:, 1]])
    label = "force (N)" if by_force else "frame"
    labels = (label, f"area ({readable(score.area_unit)})")
    axes = plot(labels, np.concatenate([[0.0] * by_force, x, law[:, 0]]), heights)
    caption = "Front: contact area of each frame. Skin: the area of the first contact's skin."
    if counts.any():
        order = np.flatnonzero(counts)[np.argsort(x[counts], kind="stable")]
        axes.band(x[order], (front.area / reach)[order], (front.area * reach)[order], BLUE)
        caption += " Shaded: 95 % of each area."
    if rate is not None:
        if law.size:
            axes.line(law, MUTED, width=2.4, label="power law")
        axes.line(rate.chord, YELLOW, width=4.4, label=rate.label)
        caption += rate.caption
    if not counts.all():
        axes.crosses(np.column_stack([x, front.area])[~counts], FAINT, label="front, not determined")
        caption += " Grey: the front is not determined, these frames do not count."
    if counts.any():
        axes.dots(np.column_stack([x, front.area])[counts], BLUE, label="front")
    axes.dots(np.column_stack([x, skin]), GREEN, size=8, label="skin")
    title = "Area against force" if by_force else "Area frame by frame"
    return Picture("area_curve", title, caption, axes)


@dataclass(frozen=True)
class _DrawnRate:
    """law, chord : (N, 2), where there is one, and (2, 2) points of force and area."""

    law: NDArray[np.float64]
    chord: NDArray[np.float64]
    label: str
    caption: str


def _drawn_rate(score: Score) -> _DrawnRate | None:
    """The CASR by the quantity of the score, as a line; None for the paper's sum, which is no slope."""
    rate, force_n = score.rate, score.force_n
    if rate is None or force_n is None or rate.rule == "paper":
        return None
    ends, middle = _line_through(force_n, score.area)
    law = np.empty((0, 2))
    said = f" The slope of the line is the CASR ({score.settings.quantity})."
    if rate.law is not None and rate.window_n is not None:
        ends = np.array(rate.window_n)
        middle = float(rate.law.area(ends).mean())
        forces = np.linspace(*rate.window_n, 100)
        law = np.column_stack([forces, rate.law.area(forces)])
        said += " It joins two forces on the power law through the frames."
    if score.interval is not None:
        said += (
            f" Its total 95 % interval: {score.interval.low:.3g} to {score.interval.high:.3g} {readable(rate.unit)}."
        )
    chord = np.column_stack([ends, middle + rate.value * (ends - ends.mean())])
    label = f"CASR ({score.settings.quantity}), {rate.value:.3g} {readable(rate.unit)}"
    return _DrawnRate(law, chord, label, said)


def growth_curve(frames: NDArray[np.int_], log_growth: NDArray[np.float64]) -> Picture:
    """Growth of each step and their sum, D_cum. frames : (T,); log_growth : (T-1,)."""
    total = np.concatenate([[0.0], np.cumsum(log_growth)])
    axes = plot(("frame", "log growth of the skin"), frames, np.concatenate([total, log_growth]))
    axes.bars(np.asarray(frames[1:], dtype=np.float64), log_growth, GREEN, label="of one step")
    axes.level(0.0, dash="")
    axes.line(np.column_stack([frames, total]), BLUE, width=4.4, label="sum since first contact")
    grew = f"the skin of the first contact grew to {np.exp(total[-1]):.2f} times its initial size."
    return Picture("growth", "Growth of the skin frame by frame", f"Sum at the end {total[-1]:.3f}: {grew}", axes)


def _line_through(force_n: NDArray[np.float64], area: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """(2,) lowest and highest force, N, and the mean area over that range: the least-squares line goes through it."""
    known = np.flatnonzero(np.isfinite(force_n) & np.isfinite(area))
    order = known[np.argsort(force_n[known], kind="stable")]
    force_n, area = force_n[order], area[order]
    ends = force_n[[0, -1]]
    return ends, float(np.trapezoid(area, force_n) / (ends[1] - ends[0]))
