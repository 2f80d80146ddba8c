"""The rig's presses.

Figure 8: initial areas, by specimen and by angle, as differences. Figure 9: the contact at each angle at one force.
Figures 10, 12 and 13: dA/dF against force with its fit, and the rates of the presses. Figure 14: rates under rigid and
human-like actuation. Calibration: stiffness over CASR; its estimates, and Table I, with their intervals.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from casr.spread import fit_power_laws
from casr.spread.rate import MIN_STEP_N
from emg2vsa.arrays import Floats, mean_of
from emg2vsa.calibration.forms import kappa_of, x_of
from emg2vsa.calibration.results import AlgorithmResult, ConditionResult, LawResult
from emg2vsa.figures import canvas
from emg2vsa.figures.canvas import PairBar, draw_bars, draw_box, groups, marks, one_scale, panel_grid, short
from emg2vsa.figures.palette import GREY, GRID, INK, MUTED, YELLOW, Look
from emg2vsa.run_scores import ContactPicture
from emg2vsa.settings import Law

POOLED = Look(GREY, "o", "-")
"""All specimens of an angle together."""


Group = tuple[str, Floats, Look]
"""Name, values (n,) and look of a box."""


def _boxes(axes: Axes, title: str, boxes: Sequence[Group]) -> None:
    for place, (_, values, look) in enumerate(boxes):
        draw_box(axes, place, values, look)
    groups(axes, [name for name, *_ in boxes])
    axes.set_title(title, loc="center")


def draw_areas(panels: Sequence[tuple[str, Sequence[Group]]], bars: Sequence[PairBar]) -> Figure:
    """Differences of areas in percent; ``bars`` over the boxes of the last panel."""
    figure, (row,) = panel_grid(1, [1] * len(panels), 50, (15, 2, 11, 10), (6, 0))
    for axes, (title, boxes) in zip(row, panels, strict=True):
        axes.axhline(0, color=INK, linewidth=0.6)
        _boxes(axes, title, boxes)
    one_scale(row)
    draw_bars(row[-1], bars, "")
    one_scale(row)
    row[0].set_ylabel("Difference of area (%)")
    return figure


_BRIGHTEST = 255


def draw_contacts(pictures: Sequence[tuple[str, ContactPicture]], unit: str) -> Figure:
    """pictures : title and picture of each panel, whose force and area are added to the title."""
    figure, (row,) = panel_grid(1, [1] * len(pictures), 52, (2, 2, 2, 10), (4, 0))
    for axes, (title, picture) in zip(row, pictures, strict=True):
        axes.imshow(picture.image, cmap="gray", vmin=0, vmax=_BRIGHTEST, interpolation="nearest")
        axes.add_patch(Polygon(picture.outline_px, facecolor=YELLOW, alpha=0.25, linewidth=0))
        axes.add_patch(Polygon(picture.outline_px, fill=False, edgecolor=YELLOW, linewidth=1.4))
        axes.set_axis_off()
        axes.set_title(f"{title}, {picture.force_n:.2f} N\n{picture.area_mm2:.3g} {unit}", loc="center")
    return figure


_MARKS = 120
_SHARE_SHOWN = 0.98


@dataclass(frozen=True)
class RateSeries:
    """One specimen of a row. presses : forces (T,) and areas (T,) of the frames of each. casr : (n,) of the presses."""

    name: str
    look: Look
    presses: Sequence[tuple[Floats, Floats]]
    casr: Floats
    exponential: bool = False
    "Whether areas follow equation (1) as printed, A = c exp(D F); else a power law, A = c F^m."

    @property
    def quotients(self) -> tuple[Floats, Floats]:
        """(M,) forces midway and dA/dF from each frame of a press to the next, but for steps of nearly no force."""
        force_n, rate = [np.empty(0)], [np.empty(0)]
        for force, area in self.presses:
            step = np.diff(force)
            known = np.abs(step) >= MIN_STEP_N
            force_n.append((force[:-1] + force[1:])[known] / 2)
            rate.append(np.diff(area)[known] / step[known])
        return np.concatenate(force_n), np.concatenate(rate)

    @property
    def fit(self) -> tuple[Floats, Floats]:
        """(50,) forces and dA/dF of the law through the areas of all presses; (0,) where they have one force."""
        force_n, area = (np.concatenate([np.empty(0), *(press[part] for press in self.presses)]) for part in (0, 1))
        known = (force_n > 0) & (area > 0)
        force_n, area = force_n[known], area[known]
        if not force_n.size or np.ptp(force_n) == 0:
            return np.empty(0), np.empty(0)
        at = np.linspace(force_n.min(), force_n.max(), 50)
        if self.exponential:
            rate, level = np.polyfit(force_n, np.log(area), 1)
            return at, rate * np.exp(level + rate * at)
        return at, fit_power_laws(area, force_n).law.rate(at)


def draw_rates(rows: Sequence[tuple[str, Sequence[RateSeries]]], unit: str) -> Figure:
    """rows : title and specimens, stiffest first; ``unit`` of the area."""
    figure, panels = panel_grid(len(rows), (1.15, 1), 38, (13, 2, 11, 13), (17, 12))
    for (raw, boxes), (title, specimens) in zip(panels, rows, strict=True):
        for series in specimens:
            force_n, rate = series.quotients
            # a step prime to the frames of a press shows all presses and all forces alike
            every = max(1, force_n.size // _MARKS) | 1
            marks(raw, force_n[::every], rate[::every], series.look, 2.5, 0, alpha=0.55)
            raw.plot(*series.fit, color=series.look.colour, linestyle=series.look.dash)
        raw.set(ylabel=f"dA/dF ({unit}/N)", xlim=(0, None))
        raw.set_title(title, loc="center")
        _keep_most(raw, [series.quotients[1] for series in specimens])
        _boxes(boxes, "", [(series.name, series.casr, series.look) for series in specimens])
        boxes.set_ylabel(f"CASR ({unit}/N)")
    panels[-1][0].set_xlabel("Force (N)")
    named = {series.name: series.look for _, specimens in rows for series in specimens}
    for name, look in named.items():
        marks(panels[0][0], [], [], look, linestyle=look.dash, label=short(name))
    figure.legend(loc="upper center", ncols=min(len(named), 8) or 1)
    return figure


def _keep_most(axes: Axes, rates: Sequence[Floats]) -> None:
    """A quotient of two small differences may be anything: the scale leaves the furthest of them out, and says so."""
    together = np.concatenate([np.zeros(1), *rates])
    far = (1 - _SHARE_SHOWN) / 2
    low, high = np.quantile(together, (far, 1 - far))
    room = 0.08 * (high - low) or 1.0
    low, high = min(low - room, 0.0) if low < 0 else 0.0, high + room
    axes.set_ylim(low, high)
    if outside := int(np.count_nonzero((together < low) | (together > high))):
        axes.set_title(f"{outside} off the scale", loc="right", fontsize=7)


_ASIDE = 0.21
_RING = Look(INK, "o", "-")
_RIGID = "left, hollow: rigid (high stiffness)"
_HUMAN_LIKE = "right, filled: human-like (modular stiffness)"


@dataclass(frozen=True)
class ConditionBoxes:
    """One specimen at one angle: scores (n,) of both conditions."""

    name: str
    look: Look
    rigid: Floats
    human_like: Floats
    far: bool = False
    "Whether their means differ by more than two SDs of a difference of two means over mountings."

    @property
    def percent(self) -> Floats:
        """(n,) by which the human-like presses exceed the mean of the rigid ones."""
        return np.asarray(100 * (self.human_like / mean_of(self.rigid) - 1))


def draw_conditions(panels: Sequence[tuple[str, Sequence[ConditionBoxes]]], unit: str, reach: float) -> Figure:
    """panels : title and specimens, stiffest first; ``unit`` of the area. reach : percent that mountings explain.

    Above the levels, left and hollow rigid, right and filled human-like; below how far the human-like presses lie from
    the mean of the rigid ones, with a ring around the mean of those that are ``far``. Each row has one scale.
    """
    figure, (levels, differences) = panel_grid(2, [1] * len(panels), 42, (15, 2, 8, 13), (6, 9))
    for above, below, (title, specimens) in zip(levels, differences, panels, strict=True):
        below.axhline(0, color=INK, linewidth=0.6)
        below.axhspan(-reach, reach, color=GRID, linewidth=0)
        for place, each in enumerate(specimens):
            draw_box(above, place - _ASIDE, each.rigid, each.look, width=0.36, hollow_marks=True)
            draw_box(above, place + _ASIDE, each.human_like, each.look, width=0.36, filled=True)
            if each.far:
                marks(below, place, np.mean(each.percent), _RING, 13, 1.2, markerfacecolor="none")
        groups(above, [each.name for each in specimens])
        above.set_title(title, loc="center")
        _boxes(below, "", [(each.name, each.percent, each.look) for each in specimens])
    for row, name in ((levels, f"CASR ({unit}/N)"), (differences, "Human-like less rigid (%)")):
        one_scale(row)
        row[0].set_ylabel(name)
    for face, label in (("white", _RIGID), (INK, _HUMAN_LIKE)):
        marks(levels[0], [], [], _RING, edge=1, markerfacecolor=face, label=label)
    figure.legend(loc="upper center", ncols=2)
    return figure


_ACROSS = 3
_BEYOND = 0.08


def draw_calibrations(
    panels: Sequence[tuple[str, ConditionResult, AlgorithmResult]], looks: Mapping[str, Look], new: str, known: float
) -> Figure:
    """panels : title, and what the chosen vision algorithm gives; known : stiffness of ``new``, NaN if not."""
    shares = [1] * min(_ACROSS, len(panels))
    figure, grid = panel_grid(-(-len(panels) // _ACROSS), shares, 38, (13, 2, 12, 13), (12, 16))
    axes = [each for row in grid for each in row]
    for each, (title, condition, found) in zip(axes, panels, strict=False):
        _calibration(each, condition, found, looks, new, known)
        each.set_title(title, loc="center")
        each.set_xlabel(f"CASR ({found.casr_unit.replace('2', '²')})")
    for unused in axes[len(panels) :]:
        unused.remove()
    for row in grid:
        row[0].set_ylabel("κ (N/mm)")
    legend = axes[0].get_legend_handles_labels()
    figure.legend(*legend, loc="upper center", ncols=len(looks) + 3, columnspacing=1, handletextpad=0.4)
    return figure


def law_curve(result: LawResult, casr: Floats) -> Floats:
    """Stiffness (n,) in N/mm that the law gives for scores (n,); NaN where it gives none."""
    law = cast(Law, result.law)
    first, second = result.parameters
    level = np.log(first) if law in ("exponential", "power") else first
    return kappa_of(law, level + second * x_of(law, casr))


def _calibration(
    axes: Axes, condition: ConditionResult, found: AlgorithmResult, looks: Mapping[str, Look], new: str, known: float
) -> None:
    scores = [row[np.isfinite(row)] for row in (*found.casr, found.new_casr)]
    together = np.concatenate(scores)
    if not together.size:
        return
    reach = _BEYOND * (together.max() - together.min())
    casr = np.linspace(together.min() - reach, together.max() + reach, 200)
    top = 1.35 * float(np.max(condition.known_kappa))
    for result, dash, colour in ((found.chosen, "-", INK), (found.paper, ":", MUTED)):
        curve = law_curve(result, casr)
        shown = np.where(curve <= top, curve, np.nan)
        axes.plot(casr, shown, color=colour, linestyle=dash, label=f"{result.law}{' (paper)' if dash == ':' else ''}")
    for name, kappa, own in zip(condition.specimens, condition.known_kappa.tolist(), scores, strict=False):
        # all presses, pale, and their mean
        marks(axes, own, np.full(own.size, kappa), looks[name], 2.5, 0, alpha=0.5)
        if own.size:
            marks(axes, float(np.mean(own)), kappa, looks[name], 5, label=name)
    mean, look, chosen = float(mean_of(scores[-1])), looks[new], found.chosen
    axes.vlines(mean, chosen.low, min(chosen.high, top), colors=look.colour, linewidth=1.4)
    if chosen.high > top:
        # the interval goes on beyond the panel
        axes.plot(mean, top, marker="^", markersize=5, color=look.colour, clip_on=False)
    marks(axes, mean, chosen.kappa, look, 6, label=new)
    if np.isfinite(known):
        axes.axhline(known, color=look.colour, linestyle=(0, (1, 1)), linewidth=0.8, label="known κ")
    axes.set_ylim(0, top)


@dataclass(frozen=True)
class Estimate:
    """One row: an estimate with its interval, NaN where there is none. printed : the paper's, without its sign."""

    name: str
    value: float
    low: float
    high: float
    determined: bool
    look: Look
    printed: float = np.nan


def draw_estimates(
    panels: Sequence[tuple[str, Sequence[Estimate]]], label: str, truth: float, known: Mapping[str, float] | None = None
) -> Figure:
    """panels : title and rows, the same rows in each. truth : a line. An interval ends in an arrow at the panel's edge.

    known : stiffness of specimens, the ticks of a logarithmic scale; without them a scale of errors in percent.
    """
    names = [each.name for each in panels[0][1]]
    height, margins = 4 + 7 * len(names), (6 + 1.55 * max(map(len, names)), 3, 16 if known else 12, 6)
    if len(panels) == 1:
        figure, row = canvas.new_figure(canvas.ONE_COLUMN_MM, height + 22, margins)
    else:
        figure, (row,) = panel_grid(1, [1] * len(panels), height, margins, (4, 0))
    limits = (min(known.values()) / 1.8, 3.5 * max(known.values())) if known else (-100.0, 100.0)
    for axes, (title, estimates) in zip(row, panels, strict=True):
        axes.axvline(truth, color=INK, linewidth=0.8, linestyle=(0, (4, 2)))
        for place, each in enumerate(estimates):
            _estimate(axes, place, each, limits)
        if known:
            axes.set_xscale("log")
            axes.set_xticks(list(known.values()), [f"{name}\n{kappa:g}" for name, kappa in known.items()])
            axes.minorticks_off()
        else:
            axes.set_xticks([-50, 0, 50])
        axes.set(xlim=limits, ylim=(len(names) - 0.4, -0.6), xlabel=label)
        axes.set_yticks(range(len(names)), names if axes is row[0] else [""] * len(names))
        axes.set_title(title, loc="center")
    return figure


def _estimate(axes: Axes, place: int, each: Estimate, limits: tuple[float, float]) -> None:
    if np.isfinite(each.printed):
        ends = [-each.printed, each.printed]
        axes.plot(ends, [place + 0.28] * 2, color=MUTED, linewidth=0.8, marker="|", markersize=5)
    colour = each.look.colour if each.determined else GREY
    if np.isfinite(each.value):
        ends = np.clip([each.low, each.high], *limits).tolist()
        axes.plot(ends, [place] * 2, color=colour, linewidth=1.4)
        for end, clipped, marker in zip((each.low, each.high), ends, "<>", strict=True):
            if end != clipped:
                axes.plot(clipped, place, marker=marker, markersize=4, color=colour, clip_on=False)
        face = colour if each.determined else "white"
        value = min(max(each.value, limits[0]), limits[1])
        marks(axes, value, place, each.look, 5, 0.8, markerfacecolor=face, markeredgecolor=colour, clip_on=False)
    if not each.determined and (np.isfinite(each.value) or each.low == each.low):
        axes.text(0.99 * limits[1], place - 0.2, "not determined", ha="right", va="bottom", color=MUTED, fontsize=6)
