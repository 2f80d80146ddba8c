"""Figure 5: co-contraction mapped on the actuator: modular steps and constant levels against force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure

from emg2vsa.figures.canvas import ONE_COLUMN_MM, new_figure
from emg2vsa.figures.palette import INK, Look
from emg2vsa.schedules import Schedule


def draw_schedules(schedules: Sequence[Schedule], looks: Mapping[str, Look]) -> Figure:
    """Steps of the modular schedules, dots at the middle of each step; dotted lines are the constant schedules."""
    figure, (axes,) = new_figure(ONE_COLUMN_MM, 72, (12, 4, 11, 12))
    for schedule in schedules:
        look = looks[schedule.specimen]
        edges = schedule.step_force_n
        if schedule.condition == "modular":
            axes.stairs(schedule.stiffness_percent, edges, baseline=None, color=look.colour, linewidth=1.2)
            axes.plot(
                (edges[1:] + edges[:-1]) / 2, schedule.stiffness_percent, linestyle="none", marker=look.marker,
                color=look.colour, markeredgecolor=INK, markeredgewidth=0.4, label=schedule.specimen,
            )  # fmt: skip
        else:
            level = schedule.stiffness_percent[0]
            axes.hlines(level, edges[0], edges[-1], colors=look.colour, linestyles=(0, (1, 1.5)), linewidth=0.9)
    axes.set(xlabel="Force (N)", ylabel="Stiffness preset (% of maximum)", xlim=(0, None), ylim=(0, 100))
    axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=4, columnspacing=1, handletextpad=0.3)
    return figure
