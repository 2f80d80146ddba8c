"""Time against error on logarithmic axes, the front of unbeaten methods drawn; PNG and SVG."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from benchmarks.tactile.metrics import pareto_front
from casr.atomic import write_bytes_atomic

INK, OURS, PEER = "#1a1a1a", "#0072B2", "#7A7A7A"
STYLE = {"font.size": 8, "svg.hashsalt": "casr", "axes.spines.top": False, "axes.spines.right": False}
SHIFTS_PT = [(6, 0), (-6, 0), (6, 8), (6, -8), (-6, 8), (-6, -8)] + [
    (side * 10, k * 10) for k in (2, -2, 3, -3, 4, -4) for side in (1, -1)
]
"Where a label may stand beside its point, most wanted first."


@dataclass(frozen=True)
class Point:
    """One method: time in ms, error in percent, both above 0."""

    name: str
    ms: float
    error_percent: float
    ours: bool = False


def write_plot(points: Sequence[Point], path: Path, error_label: str) -> None:
    """Write ``path`` with suffixes .png and .svg."""
    with mpl.rc_context(STYLE):  # type: ignore[arg-type]
        figure = draw(points, error_label)
        for suffix, options in ((".png", {"dpi": 200}), (".svg", {"metadata": {"Date": None}})):
            buffer = io.BytesIO()
            figure.savefig(buffer, format=suffix[1:], **options)  # type: ignore[arg-type]
            write_bytes_atomic(path.with_suffix(suffix), buffer.getvalue())


def draw(points: Sequence[Point], error_label: str) -> Figure:
    """The figure; its front passes through the methods no other beats in time and error."""
    figure = Figure(figsize=(7.1, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(xscale="log", yscale="log", xlabel="time per frame pair, ms", ylabel=error_label)
    front = [points[i] for i in pareto_front([p.ms for p in points], [p.error_percent for p in points])]
    axes.plot([p.ms for p in front], [p.error_percent for p in front], "-", color=INK, lw=0.8, zorder=1)
    for point in points:
        colour, marker = (OURS, "o") if point.ours else (PEER, "s")
        axes.plot(point.ms, point.error_percent, marker, color=colour, ms=5)
    axes.margins(0.2, 0.12)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    axes.grid(True, which="major", color="#d9d9d9", lw=0.4)
    figure.draw_without_rendering()
    _label(axes, points, {point.name for point in front})
    return figure


def _label(axes: Axes, points: Sequence[Point], bold: set[str]) -> None:
    """Names beside the points, each where it covers nothing drawn before it."""
    renderer = axes.get_figure().canvas.get_renderer()  # type: ignore[union-attr]
    centres = axes.transData.transform([(p.ms, p.error_percent) for p in points])
    taken = [Bbox.from_extents(x - 4, y - 4, x + 4, y + 4) for x, y in centres]
    for point in sorted(points, key=lambda point: -point.ms):
        label = axes.annotate(
            point.name,
            (point.ms, point.error_percent),
            (0, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            fontweight="bold" if point.name in bold else "normal",
            color=OURS if point.ours else INK,
            in_layout=False,  # the axes must not move again
        )
        crowding = {}
        for shift in SHIFTS_PT:
            _shift(label, shift)
            box = label.get_window_extent(renderer)
            outside = box.x0 < axes.bbox.x0 or box.x1 > axes.bbox.x1
            crowding[shift] = box.count_overlaps(taken) + 10 * outside
            if crowding[shift] == 0:
                break
        _shift(label, min(crowding, key=crowding.__getitem__))
        taken.append(label.get_window_extent(renderer))


def _shift(label: Annotation, shift_pt: tuple[int, int]) -> None:
    label.set_position(shift_pt)
    label.set_horizontalalignment("left" if shift_pt[0] > 0 else "right")
