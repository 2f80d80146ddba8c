"""Time against error of a case, and time against size of a family, as SVG 600 px wide.

How processor time grows with size: exponents with their standard errors.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from matplotlib.ticker import LogFormatterMathtext, LogLocator, NullLocator
from matplotlib.transforms import Bbox

from benchmarks.bench.results import AreaResult, CaseResult, Row
from benchmarks.bench.tables import slug
from casr.atomic import write_bytes_atomic
from casr.palette import BLUE, GREEN, GREY, GRID, INK, MUTED, PURPLE, RED, SKY, YELLOW


@dataclass(frozen=True)
class Growth:
    """One way over the cases of a family. exponent : slope of log time over log size; se : its standard error, NaN
    with two sizes."""

    label: str
    ours: bool
    sizes: tuple[float, ...]
    median_ms: tuple[float, ...]
    exponent: float
    se: float


def growths(cases: Sequence[CaseResult]) -> list[Growth]:
    """Of every way that was measured at two sizes or more."""
    points: dict[tuple[str, bool], list[tuple[float, float]]] = {}
    for case in cases:
        for row in case.rows:
            if row.median_ms:
                points.setdefault((row.label, row.ours), []).append((case.size, row.median_ms))
    grown = []
    for (label, ours), known in points.items():
        if len({size for size, _ in known}) > 1:
            sizes, times = zip(*sorted(known), strict=True)
            grown.append(Growth(label, ours, sizes, times, *exponent(known)))
    return grown


def exponent(points: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Least-squares slope of log y over log x, and its standard error."""
    x, y = np.log(np.array(points)).T
    dx = x - x.mean()
    slope = float(dx @ y / (dx @ dx))
    left = y - y.mean() - slope * dx
    se = np.sqrt(left @ left / (x.size - 2) / (dx @ dx)) if x.size > 2 else np.nan
    return slope, float(se)


WIDTH_IN = 6.25  # 450 points, which browsers show as 600 px
STYLE = {
    "font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "bench",
    "svg.fonttype": "none", "font.family": ["DejaVu Sans", "sans-serif"], "text.color": INK, "axes.labelcolor": INK,
    "axes.edgecolor": MUTED, "xtick.color": INK, "ytick.color": INK, "axes.axisbelow": True,
}  # fmt: skip
LINES = (BLUE, RED, GREEN, PURPLE, YELLOW, SKY, GREY)
MARKERS, DASHES = "osD^vPX", ("-", "--", "-.", ":")
SHIFTS_PT = [(7, 0), (-7, 0), (0, 10), (0, -10)] + [
    (side * far, k * 11) for far in (6, 14) for k in (1, -1, 2, -2, 3, -3, 4, -4) for side in (1, -1)
]
"Where a label may stand beside its point, most wanted first."


def write_plots(area: AreaResult, folder: Path) -> dict[str, list[str]]:
    """Write the plots of an area; names of the files by case and by family."""
    written: dict[str, list[str]] = {}
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]
        for case in area.cases:
            points = [row for row in case.rows if row.median_ms and row.error is not None and np.isfinite(row.error)]
            if len(points) > 2:
                name = f"{area.name}-{slug(case.name)}.svg"
                _write(pareto_plot(case, points), folder / name)
                written.setdefault(case.name, []).append(name)
        for family in dict.fromkeys(case.family for case in area.cases if case.family):
            cases = [case for case in area.cases if case.family == family]
            grown = growths(cases)
            if grown:
                name = f"{area.name}-growth-{slug(family)}.svg"
                _write(growth_plot(family, cases[0].size_unit, grown), folder / name)
                written.setdefault(family, []).append(name)
    return written


def write_picture(area: AreaResult, folder: Path) -> str:
    """The one plot that the page of an area shows: of its first family by size, else of its first case."""
    with tempfile.TemporaryDirectory() as made:
        names = [name for group in write_plots(area, Path(made)).values() for name in group]
        grown = [name for name in names if name.startswith(f"{area.name}-growth-")]
        for name in (grown or names)[:1]:
            write_bytes_atomic(folder / f"{area.name}.svg", (Path(made) / name).read_bytes())
    return f"{area.name}.svg" if names else ""


def pareto_plot(case: CaseResult, points: Sequence[Row]) -> Figure:
    """Every way by its number in the table; a line joins those that no other beats in time and error."""
    errors = _above_zero([row.error or 0.0 for row in points])
    times = [row.median_ms or 0.0 for row in points]
    figure = Figure(figsize=(WIDTH_IN, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel="processor time, ms")
    axes.set_ylabel(f"error, {case.error_unit}")
    front = front_of(times, errors)
    axes.plot([times[i] for i in front], [errors[i] for i in front], "-", color=MUTED, lw=1, zorder=1)
    for row, x, y in zip(points, times, errors, strict=True):
        colour, marker = (BLUE, "o") if row.ours else (RED if row.work == "equal" else GREY, "s")
        axes.plot(x, y, marker, color=colour, ms=6, mfc=colour if row.work == "equal" else "white", mew=1.4)
    axes.margins(0.16, 0.16)
    _few_ticks(axes, times, errors)
    axes.grid(True, which="major", color=GRID, lw=0.5)
    axes.set_title(
        "blue: ours; filled: equal work; hollow: as used; line: unbeaten", fontsize=9, loc="left", color=MUTED
    )
    figure.draw_without_rendering()
    numbers = {row.label: i for i, row in enumerate(case.rows, 1)}
    labels = [f"{numbers[row.label]} {row.library}" for row in points]
    _label(axes, labels, times, errors, [row.ours for row in points])
    return figure


def growth_plot(family: str, size_unit: str, grown: Sequence[Growth]) -> Figure:
    """Time against size, with the exponent and its standard error in the legend."""
    figure = Figure(figsize=(WIDTH_IN, 3.0 + 0.2 * len(grown)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel=size_unit, ylabel="processor time, ms")
    for i, way in enumerate(grown):
        error = f" ± {way.se:.2f}" if np.isfinite(way.se) else ""
        axes.plot(
            way.sizes, way.median_ms, color=LINES[i % len(LINES)], marker=MARKERS[i % len(MARKERS)], ms=5,
            ls=DASHES[i // len(LINES) % len(DASHES)], lw=2.2 if way.ours else 1.2,
            label=f"{way.label}: exponent {way.exponent:.2f}{error}",
        )  # fmt: skip
    _few_ticks(axes, [size for way in grown for size in way.sizes], [ms for way in grown for ms in way.median_ms])
    axes.grid(True, which="major", color=GRID, lw=0.5)
    axes.set_title(family, fontsize=9, loc="left", color=MUTED)
    figure.legend(loc="outside lower left", fontsize=8.5, frameon=False)
    return figure


def front_of(times: Sequence[float], errors: Sequence[float]) -> list[int]:
    """Indices of the ways that no other equals in one and beats in the other, by time."""
    front: list[int] = []
    for i in sorted(range(len(times)), key=lambda i: (times[i], errors[i])):
        if not front or errors[i] < errors[front[-1]]:
            front.append(i)
    return front


def _above_zero(errors: Sequence[float]) -> list[float]:
    """Errors for a logarithmic axis: an exact way stands a decade below the least error above zero."""
    known = [error for error in errors if error > 0]
    floor = min(known) / 10 if known else 1e-17
    return [error if error > 0 else floor for error in errors]


def _few_ticks(axes: Axes, x: Sequence[float], y: Sequence[float]) -> None:
    """Ticks at 1, 2, 5 within two decades, else at decades; plain numbers where they are short."""
    for axis, values in ((axes.xaxis, x), (axes.yaxis, y)):
        decades = np.log10(max(values) / min(values))
        axis.set_major_locator(LogLocator(subs=(1, 2, 5) if decades < 2 else (1,), numticks=9))
        axis.set_minor_locator(NullLocator())
        if min(values) > 1e-3 and max(values) < 1e6:
            axis.set_major_formatter("{x:g}")
        else:
            axis.set_major_formatter(LogFormatterMathtext(labelOnlyBase=False))


def _label(axes: Axes, labels: Sequence[str], x: Sequence[float], y: Sequence[float], ours: Sequence[bool]) -> None:
    """Names beside the points, each where it covers least of what stands there."""
    renderer = axes.get_figure().canvas.get_renderer()  # type: ignore[union-attr]
    centres = axes.transData.transform(np.column_stack([x, y]))
    taken = [Bbox.from_extents(px - 4, py - 4, px + 4, py + 4) for px, py in centres]
    for i in np.argsort(x):
        label = axes.annotate(
            labels[i], (x[i], y[i]), (0, 0), textcoords="offset points", va="center", fontsize=8.5, in_layout=False,
            color=BLUE if ours[i] else INK, fontweight="bold" if ours[i] else "normal",
        )  # fmt: skip

        def crowding(shift: tuple[int, int], label: Annotation = label) -> float:
            box = _moved(label, shift).get_window_extent(renderer)
            outside = box.x0 < axes.bbox.x0 or box.x1 > axes.bbox.x1 or box.y0 < axes.bbox.y0 or box.y1 > axes.bbox.y1
            return float(box.count_overlaps(taken) + 10 * outside)

        best = min(SHIFTS_PT, key=crowding)
        taken.append(_moved(label, best).get_window_extent(renderer))


def _moved(label: Annotation, shift_pt: tuple[int, int]) -> Annotation:
    label.set_position(shift_pt)
    label.set_horizontalalignment("center" if shift_pt[0] == 0 else "left" if shift_pt[0] > 0 else "right")
    return label


def _write(figure: Figure, path: Path) -> None:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    write_bytes_atomic(path, buffer.getvalue())
