"""Figure 5: co-contraction mapped on the actuator: modular steps and constant levels against force."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.figures.canvas import ONE_COLUMN_MM, new_figure
from emg2vsa.figures.palette import INK, Look
from emg2vsa.schedules import Schedule


def draw_schedules(schedules: Sequence[Schedule], looks: Mapping[str, Look]) -> Figure:
    """Left, the steps of the modular schedules, marked at their middle; right, the constant levels of each specimen."""
    figure, (steps, levels) = new_figure(ONE_COLUMN_MM, 74, (14, 2, 11, 10), shares=(3, 1), gap_mm=3)
    specimens = list(dict.fromkeys(schedule.specimen for schedule in schedules))
    for schedule in schedules:
        if schedule.condition == "modular":
            _steps(steps, schedule, looks[schedule.specimen])
    for place, specimen in enumerate(specimens):
        constant = {s.condition: float(s.stiffness_percent[0]) for s in schedules if s.specimen == specimen}
        constant.pop("modular", None)
        _levels(levels, place, constant, looks[specimen])
    steps.set(xlabel="Force (N)", ylabel="Stiffness preset (% of maximum)", xlim=(0, None), ylim=(0, 100))
    levels.set(xlabel="Constant", xlim=(-0.7, len(specimens) - 0.3), ylim=(0, 100), xticks=[])
    levels.tick_params(axis="y", left=False, labelleft=False)
    levels.spines["left"].set_visible(False)
    marks, names = steps.get_legend_handles_labels()
    if marks:
        figure.legend(
            marks, names, loc="upper center", bbox_to_anchor=(0.55, 1), ncols=4, columnspacing=1, handletextpad=0.3
        )
    return figure


def _steps(axes: Axes, schedule: Schedule, look: Look) -> None:
    edges = schedule.step_force_n
    axes.stairs(schedule.stiffness_percent, edges, baseline=None, color=look.colour, linewidth=1.0)
    axes.plot(
        (edges[1:] + edges[:-1]) / 2, schedule.stiffness_percent, linestyle="none", marker=look.marker,
        color=look.colour, markeredgecolor=INK, markeredgewidth=0.4, label=schedule.specimen,
    )  # fmt: skip


def _levels(axes: Axes, place: int, percent: Mapping[str, float], look: Look) -> None:
    """percent : level by condition, of one specimen."""
    ends = [percent[name] for name in ("constant-min", "constant-max") if name in percent]
    axes.hlines(ends, place - 0.3, place + 0.3, colors=look.colour, linewidth=1.6)
    if len(ends) > 1:
        axes.vlines(place, min(ends), max(ends), colors=look.colour, linestyles=(0, (1, 1.5)), linewidth=1.0)
    if "constant-mean" in percent:
        axes.plot(
            place, percent["constant-mean"], linestyle="none", marker=look.marker, markersize=5, color=look.colour,
            markeredgecolor=INK, markeredgewidth=0.4,
        )  # fmt: skip
