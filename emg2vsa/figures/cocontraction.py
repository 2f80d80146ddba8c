"""What muscles do. Figure 4: trends and slopes. Figure 5: schedules. Figure 11: an interpolated profile. Residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.figures import canvas
from emg2vsa.figures.palette import BLUE, INK, NEW, ActivityScale, Look
from emg2vsa.profiles import Profile
from emg2vsa.schedules import Schedule

_TWO_PANELS: Any = {"panel_mm": 53, "margins_mm": (13, 2, 11, 6), "gaps_mm": (16, 0)}
_BAND: Any = {"alpha": 0.18, "linewidth": 0}
_SHORT = 8
"""Letters of names of which three stand in one column of a paper."""


def draw_cocontraction(
    profiles: Sequence[Profile],
    slopes: Sequence[Floats],
    bars: Sequence[canvas.PairBar],
    looks: Sequence[Look],
    scale: ActivityScale,
    bar_legend: str,
) -> Figure:
    """profiles, slopes (n,) and looks belong together, one per specimen; ``bar_legend`` names test and correction."""
    figure, ((trends, boxes),) = canvas.panel_grid(1, (1, 1), **_TWO_PANELS)
    own = zip(profiles, looks, strict=True)
    _trends(trends, [(profile, profile.specimen, look, profile.sd_v) for profile, look in own], scale)
    falling = sum(profile.b_v < 0 for profile in profiles)
    canvas.legend_inside(trends, "upper right" if 2 * falling > len(profiles) else "upper left")
    for place, (b, look) in enumerate(zip(slopes, looks, strict=True)):
        canvas.draw_box(boxes, place, b * scale.factor, look)
    canvas.groups(boxes, [profile.specimen for profile in profiles])
    boxes.set_ylabel(scale.label("Slope b"))
    canvas.draw_bars(boxes, bars, bar_legend)
    return figure


def _trends(axes: Axes, profiles: Sequence[tuple[Profile, str, Look, Floats | None]], scale: ActivityScale) -> None:
    """Each profile with its name, its look, and half of its band."""
    for profile, name, look, half_v in profiles:
        every = max(1, profile.force_n.size // 8)
        v = profile.v * scale.factor
        canvas.marks(axes, profile.force_n, v, look, linestyle=look.dash, markevery=every, label=canvas.short(name, 22))
        if half_v is not None:
            half = half_v * scale.factor
            axes.fill_between(profile.force_n, v - half, v + half, color=look.colour, **_BAND)
    axes.set(xlabel="Force (N)", ylabel=scale.label("Co-contraction"), xlim=(0, None))
    canvas.show_zero(axes, [profile.v for profile, *_ in profiles])


def draw_interpolation(
    measured: Sequence[Profile], new: Profile, half_v: Floats, looks: Mapping[str, Look], scale: ActivityScale
) -> Figure:
    """An interpolated profile beside the measured ones (paper, Fig. 11). half_v : (G,) of the band of ``new``, V."""
    across = 3 if max(len(profile.specimen) for profile in measured) <= _SHORT else 1
    top = 4 + 4 * -(-(len(measured) + 1) // across)
    figure, (axes,) = canvas.new_figure(canvas.ONE_COLUMN_MM, 58 + top, (13, 3, 11, top))
    of_measured = [(profile, profile.specimen, looks[profile.specimen], None) for profile in measured]
    _trends(axes, [*of_measured, (new, f"{new.specimen} (interpolated)", NEW, half_v)], scale)
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=across, columnspacing=1, handletextpad=0.4)
    return figure


def draw_schedules(schedules: Sequence[Schedule], looks: Mapping[str, Look]) -> Figure:
    """Left, steps of the modular schedules; right, constant levels of each specimen. Bands are their intervals."""
    specimens = list(dict.fromkeys(schedule.specimen for schedule in schedules))
    top = 2 + 4 * -(-len(specimens) // 4)
    figure, (steps, levels) = canvas.new_figure(canvas.ONE_COLUMN_MM, 64 + top, (14, 2, 11, top), (3, 1), 3)
    for schedule in schedules:
        if schedule.condition == "modular":
            edges, look = schedule.step_force_n, looks[schedule.specimen]
            if schedule.interval_percent is not None:
                low, high = np.append(schedule.interval_percent, schedule.interval_percent[:, -1:], axis=1)
                steps.fill_between(edges, low, high, step="post", color=look.colour, **_BAND)
            steps.stairs(schedule.stiffness_percent, edges, baseline=None, color=look.colour, linewidth=1.0)
            middle = (edges[1:] + edges[:-1]) / 2
            canvas.marks(steps, middle, schedule.stiffness_percent, look, label=canvas.short(schedule.specimen, 9))
    for place, specimen in enumerate(specimens):
        across, look = (place - 0.3, place + 0.3), looks[specimen]
        constant = {s.condition: s for s in schedules if s.specimen == specimen and s.condition != "modular"}
        for interval in (s.interval_percent for s in constant.values() if s.interval_percent is not None):
            levels.fill_between(across, *interval[:, 0], color=look.colour, **_BAND)
        if mean := constant.pop("constant-mean", None):
            canvas.marks(levels, place, mean.stiffness_percent[0], look, 5)
        if ends := [float(s.stiffness_percent[0]) for s in constant.values()]:
            levels.hlines(ends, *across, colors=look.colour, linewidth=1.6)
            levels.vlines(place, min(ends), max(ends), colors=look.colour, linestyles=(0, (1, 1.5)), linewidth=1.0)
    steps.set(xlabel="Force (N)", ylabel="Stiffness preset (% of maximum)", xlim=(0, None), ylim=(0, 100))
    levels.set(xlabel="Constant", xlim=(-0.7, len(specimens) - 0.3), ylim=(0, 100), xticks=[])
    levels.tick_params(axis="y", left=False, labelleft=False)
    levels.spines["left"].set_visible(False)
    placed: Any = {"loc": "upper center", "bbox_to_anchor": (0.55, 1), "ncols": 4}
    figure.legend(*steps.get_legend_handles_labels(), columnspacing=1, handletextpad=0.3, **placed)
    return figure


def draw_mixed_residuals(fitted: Floats, residual: Floats, quantile: Floats, scale: ActivityScale) -> Figure:
    """(a) Residuals over the SD of repetitions against normal quantiles; (b) against fitted slopes; (n,) each."""
    figure, ((normal, level),) = canvas.panel_grid(1, (1, 1), **_TWO_PANELS)
    points: dict[str, Any] = {"color": BLUE, "linestyle": "none", "marker": "o", "markeredgewidth": 0, "alpha": 0.6}
    points["rasterized"] = residual.size > 2000  # a page with 100 000 shapes opens slowly
    ends = [float(quantile.min()), float(quantile.max())]
    normal.plot(ends, ends, color=INK, linestyle="--", linewidth=0.8)
    normal.plot(quantile, residual, **points)
    normal.set(xlabel="Normal quantile", ylabel="Residual / SD of repetitions")
    level.axhline(0, color=INK, linestyle="--", linewidth=0.8)
    level.plot(fitted * scale.factor, residual, **points)
    level.set(xlabel=scale.label("Fitted b"), ylabel="Residual / SD of repetitions")
    return figure
