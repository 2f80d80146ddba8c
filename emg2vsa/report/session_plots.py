"""The two drawings of a recording on its page, by hand and light: force over time, activity against force."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.palette import GRID, INK, MUTED, VERDICT_COLOURS
from emg2vsa.fits import Fits
from emg2vsa.report.wording import activity, number
from emg2vsa.trials import Trials

_TEXT = 24
_SHOWN = 0.56
"Pixels a unit, at most: drawings are made fine and shown at about half their size."


@dataclass(frozen=True)
class PlotArea:
    """Data ranges x (lowest, highest) and y on a drawing of ``width`` by ``height`` units."""

    x_range: tuple[float, float]
    y_range: tuple[float, float]
    width: int
    height: int
    left: int = 80
    right: int = 20
    top: int = 40
    bottom: int = 70

    def x(self, values: Floats | float) -> Floats:
        """Data to horizontal position, whole units."""
        low, high = self.x_range
        inner = self.width - self.left - self.right
        return np.rint(self.left + (np.asarray(values) - low) / (high - low) * inner)

    def y(self, values: Floats | float) -> Floats:
        """Data to vertical position, whole units from the top."""
        low, high = self.y_range
        inner = self.height - self.top - self.bottom
        return np.rint(self.height - self.bottom - (np.asarray(values) - low) / (high - low) * inner)

    def line(self, x: Floats, y: Floats) -> str:
        """Path data of a polyline, in relative steps; points that are not numbers are left out."""
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            return ""
        points = np.column_stack([self.x(x[known]), self.y(y[known])]).astype(np.int64)
        first, steps = points[0], np.diff(points, axis=0)
        steps = steps[np.any(steps != 0, axis=1)]
        return f"M{first[0]} {first[1]}l{_joined(steps.ravel().tolist())}" if steps.size else ""

    def dots(self, x: Floats, y: Floats) -> str:
        """Path data of points without length, to be stroked with round caps."""
        known = np.isfinite(x) & np.isfinite(y)
        points = np.column_stack([self.x(x[known]), self.y(y[known])]).astype(np.int64)
        return "".join(f"M{px} {py}h0" for px, py in points.tolist())

    def axes(self, x_label: str, y_label: str) -> str:
        """Grid, ticks and labels."""
        bottom, right = self.height - self.bottom, self.width - self.right
        x_ticks, y_ticks = ticks(*self.x_range, most=9), ticks(*self.y_range, most=6)
        xs, ys = self.x(np.array(x_ticks)).astype(int), self.y(np.array(y_ticks)).astype(int)
        grid = "".join(f"M{self.left} {y}H{right}" for y in ys)
        marks = "".join(f"M{x} {bottom}v8" for x in xs)
        return (
            f'<path d="{grid}" stroke="{GRID}"/><path d="M{self.left} {bottom}H{right}{marks}" stroke="{INK}"/>'
            + "".join(text(x, bottom + 30, tick, "middle") for x, tick in zip(xs, map(_tick, x_ticks), strict=True))
            + "".join(text(self.left - 8, y + 8, tick, "end") for y, tick in zip(ys, map(_tick, y_ticks), strict=True))
            + text((self.left + right) // 2, self.height - 8, x_label, "middle")
            + text(self.left - 60, 22, y_label, "start")
        )

    def svg(self, body: str, name: str, title: str, description: str) -> str:
        """The drawing, with a name and words for those who do not see it."""
        return (
            f'<svg viewBox="0 0 {self.width} {self.height}" style="max-width:{self.width * _SHOWN:.0f}px;'
            f'min-width:{self.width * _SHOWN * 0.7:.0f}px" role="img" '
            f'aria-labelledby="{name}-t {name}-d" fill="none" '
            f'stroke-width="2" font-size="{_TEXT}"><title id="{name}-t">{escape(title)}</title>'
            f'<desc id="{name}-d">{escape(description)}</desc>{body}</svg>'
        )


def text(x: int, y: int, words: str, anchor: str, colour: str = MUTED) -> str:
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}" fill="{colour}">{escape(words)}</text>'


def ticks(low: float, high: float, *, most: int) -> list[float]:
    """Round numbers within the range, in steps of 1, 2 or 5, at most ``most``."""
    least_step = (high - low) / most
    power = 10.0 ** math.floor(math.log10(least_step))
    step = next(power * m for m in (1, 2, 5, 10, 20) if power * m >= least_step)
    return [step * i for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def thinned(x: Floats, y: Floats, most: int) -> tuple[Floats, Floats]:
    """At most ``most`` points that keep every peak: the lowest and the highest of equal stretches."""
    if x.size <= most:
        return x, y
    edges = np.linspace(0, x.size, most // 2 + 1).astype(int)[:-1]
    position = np.repeat(np.arange(edges.size), np.diff(np.append(edges, x.size)))
    order = np.lexsort((y, position))
    keep = np.sort(np.concatenate([order[edges], order[np.append(edges[1:], x.size) - 1]]))
    return x[keep], y[keep]


def _tick(value: float) -> str:
    return f"{value:.6g}"


def _joined(numbers: Iterable[int]) -> str:
    """Numbers of path data: a minus sign separates as well as a blank."""
    return " ".join(map(str, numbers)).replace(" -", "-")


MARKS = {"ok": "", "warned": "!", "rejected": "×"}
_DASHES = {"ok": "", "warned": ' stroke-dasharray="14 6"', "rejected": ' stroke-dasharray="4 8"'}
_TRACE_POINTS = 900
_CURVE_POINTS = 12
_LABEL_WIDTH = 45

PATTERNS = (
    '<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs>'
    '<pattern id="ok" width="8" height="8" patternUnits="userSpaceOnUse">'
    f'<rect width="8" height="8" fill="{VERDICT_COLOURS["ok"]}" fill-opacity=".22"/></pattern>'
    '<pattern id="warned" width="14" height="14" patternUnits="userSpaceOnUse">'
    f'<rect width="14" height="14" fill="{VERDICT_COLOURS["warned"]}" fill-opacity=".25"/>'
    f'<path d="M0 14L14 0" stroke="{VERDICT_COLOURS["warned"]}" stroke-width="3"/></pattern>'
    '<pattern id="rejected" width="14" height="14" patternUnits="userSpaceOnUse">'
    f'<path d="M0 0L14 14M0 14L14 0" stroke="{VERDICT_COLOURS["rejected"]}" stroke-width="3"/></pattern></defs></svg>'
)
LEGEND = (
    '<p class="small" aria-hidden="true">'
    + " ".join(
        f'<svg width="34" height="16" viewBox="0 0 68 32"><rect width="68" height="32" fill="url(#{verdict})" '
        f'stroke="{VERDICT_COLOURS[verdict]}" stroke-width="2"/></svg> {verdict} {mark}'
        for verdict, mark in MARKS.items()
    )
    + "</p>\n"
)


def force_trace(trials: Trials, window_n: tuple[float, float], name: str) -> str:
    """Force of the whole record, loading phases shaded by verdict and numbered."""
    time_s, force_n = thinned(trials.overview_time_s, trials.overview_force_n, _TRACE_POINTS)
    known = force_n[np.isfinite(force_n)]
    top = max(float(known.max(initial=0.0)), window_n[1]) * 1.08
    x_range = (float(time_s[0]), float(time_s[-1])) if time_s.size > 1 else (0.0, 1.0)
    area = PlotArea(x_range, (min(0.0, float(known.min(initial=0.0))), top), width=1900, height=380)
    ceiling, floor = area.top, area.height - area.bottom
    shades, labelled = [], -_LABEL_WIDTH
    for i, verdict in enumerate(trials.verdict.tolist()):
        left, right = (int(area.x(float(at))) for at in (trials.start_s[i], trials.stop_s[i]))
        shades.append(
            f'<rect x="{left}" y="{ceiling}" width="{max(right - left, 3)}" height="{floor - ceiling}" '
            f'fill="url(#{verdict})"/>'
        )
        middle = (left + right) // 2
        if middle - labelled >= _LABEL_WIDTH:
            shades.append(text(middle, ceiling - 6, f"{trials.repetition[i]}{MARKS[verdict]}", "middle", INK))
            labelled = middle
    limits = "".join(f"M{area.left} {int(area.y(n))}H{area.width - area.right}" for n in window_n)
    body = (
        "".join(shades)
        + area.axes("Time (s)", "Force (N)")
        + f'<path d="{limits}" stroke="{MUTED}" stroke-dasharray="6 8"/>'
        + f'<path d="{area.line(time_s, force_n)}" stroke="{INK}" stroke-width="2.5"/>'
    )
    counts = ", ".join(f"{np.count_nonzero(trials.verdict == verdict)} {verdict}" for verdict in MARKS)
    peak = number(float(known.max(initial=0.0)))
    return area.svg(
        body, name, f"Force over time, {trials.specimen}",
        f"{trials.verdict.size} presses: {counts}. Highest force {peak} N; the window is {window_n[0]:g} to "
        f"{window_n[1]:g} N.",
    )  # fmt: skip


def activity_plot(fits: Fits, colour: str, scale: ActivityScale, name: str) -> str:
    """Bin means and fitted curves of every press; ``fits`` are those of one recording."""
    low, high = float(fits.bin_edges_n[0]), float(fits.bin_edges_n[-1])
    v = fits.bin_v * scale.factor
    shown = v[np.isfinite(v)]
    top = float(shown.max(initial=0.0)) * 1.05 or 1.0
    area = PlotArea((0.0, high * 1.02), (min(0.0, float(shown.min(initial=0.0))), top), width=950, height=460)
    grid = np.geomspace(low, high, _CURVE_POINTS)
    curves = (fits.a_v[:, None] + fits.b_v[:, None] * np.log(grid)) * scale.factor
    body = area.axes("Force (N)", scale.label("Co-contraction"))
    for verdict in MARKS:
        of = np.flatnonzero(fits.verdict == verdict)
        stroke = colour if verdict == "ok" else VERDICT_COLOURS[verdict]
        dots = "".join(area.dots(fits.bin_force_n[i], v[i]) for i in of)
        lines = "".join(area.line(grid, curves[i]) for i in of)
        if dots:
            body += f'<path d="{dots}" stroke="{stroke}" stroke-width="7" stroke-linecap="round" stroke-opacity=".45"/>'
        if lines:
            body += f'<path d="{lines}" stroke="{stroke}"{_DASHES[verdict]}/>'
    fitted = fits.b_v[np.isfinite(fits.b_v)]
    spread = (
        f"b from {activity(float(fitted.min()), scale)} to {activity(float(fitted.max()), scale)}"
        if fitted.size
        else "no fit"
    )
    return area.svg(
        body, name, f"Co-contraction against force, {fits.specimen[0] if fits.specimen.size else ''}",
        f"Force bins and fitted curves of {fits.b_v.size} presses: {spread}.",
    )  # fmt: skip
