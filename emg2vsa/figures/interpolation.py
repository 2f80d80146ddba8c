"""Figure 11: the interpolated profile of the new specimen beside the measured ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.canvas import ONE_COLUMN_MM, new_figure, show_zero
from emg2vsa.figures.palette import INK, NEW, Look
from emg2vsa.profiles import Profile


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
