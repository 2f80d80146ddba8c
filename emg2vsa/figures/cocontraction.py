"""What the muscles do.

Figure 4: (a) mean fitted trends; (b) the slopes b, with what the tests say of them. Figure 11: the interpolated profile
of the new specimen beside the measured ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.boxes import PairBar, draw_bars, draw_box
from emg2vsa.figures.canvas import ONE_COLUMN_MM, TWO_COLUMNS_MM, new_figure, show_zero
from emg2vsa.figures.palette import INK, NEW, Look
from emg2vsa.profiles import Profile


def draw_cocontraction(
    profiles: Sequence[Profile],
    slopes: Sequence[Floats],
    bars: Sequence[PairBar],
    looks: Sequence[Look],
    scale: ActivityScale,
    bar_legend: str,
) -> Figure:
    """profiles, slopes (n,) and looks belong together, one per specimen; ``bar_legend`` names test and correction."""
    figure, (trends, boxes) = new_figure(TWO_COLUMNS_MM, 72, (13, 2, 11, 6), shares=(1, 1), gap_mm=16)
    for profile, look in zip(profiles, looks, strict=True):
        _trend(trends, profile, look, scale)
    trends.set(xlabel="Force (N)", ylabel=scale.label("Co-contraction"), xlim=(0, None))
    show_zero(trends, [profile.v for profile in profiles])
    trends.set_title("(a)", loc="left")
    falling = sum(profile.b_v < 0 for profile in profiles)
    trends.legend(loc="upper right" if 2 * falling > len(profiles) else "upper left")
    for place, (b, look) in enumerate(zip(slopes, looks, strict=True)):
        draw_box(boxes, place, b * scale.factor, look)
    boxes.set_xticks(range(len(profiles)), [profile.specimen for profile in profiles])
    boxes.set(xlim=(-0.6, len(profiles) - 0.4), ylabel=scale.label("Slope b"))
    boxes.grid(axis="x", visible=False)
    boxes.set_title("(b)", loc="left")
    draw_bars(boxes, bars, bar_legend)
    return figure


def _trend(axes: Axes, profile: Profile, look: Look, scale: ActivityScale) -> None:
    v, sd = profile.v * scale.factor, profile.sd_v * scale.factor
    axes.fill_between(profile.force_n, v - sd, v + sd, color=look.colour, alpha=0.18, linewidth=0)
    every = max(1, profile.force_n.size // 8)
    axes.plot(
        profile.force_n, v, color=look.colour, linestyle=look.dash, marker=look.marker, markevery=every,
        markeredgecolor=INK, markeredgewidth=0.4, label=profile.specimen,
    )  # fmt: skip


def draw_interpolation(
    measured: Sequence[Profile], new: Profile, looks: Mapping[str, Look], scale: ActivityScale, rmse: float
) -> Figure:
    """``rmse`` in stored units, NaN where nobody measured the new specimen."""
    figure, (axes,) = new_figure(ONE_COLUMN_MM, 70, (13, 3, 11, 12))
    for profile in [*measured, new]:
        look = NEW if profile is new else looks[profile.specimen]
        axes.plot(
            profile.force_n, profile.v * scale.factor, color=look.colour, linestyle=look.dash, marker=look.marker,
            markevery=max(1, profile.force_n.size // 8), markeredgecolor=INK, markeredgewidth=0.4,
            label=f"{profile.specimen}{' (interpolated)' if profile.source == 'interpolated' else ''}",
        )  # fmt: skip
    axes.set(xlabel="Force (N)", ylabel=scale.label("Co-contraction"), xlim=(0, None))
    show_zero(axes, [profile.v for profile in [*measured, new]])
    if not np.isnan(rmse):
        said = f"RMSE to measured: {rmse * scale.factor:.3g} {scale.unit}".rstrip()
        axes.text(0.98, 0.03, said, transform=axes.transAxes, ha="right", va="bottom")
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, columnspacing=1, handletextpad=0.4)
    return figure
