"""The drawings of a recording on its page: small SVG in the colours of the page, light or dark."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, median
from emg2vsa.extraction import Trials
from emg2vsa.figures.palette import RED, VERDICT_COLOURS, ActivityScale, activity_scale
from emg2vsa.fits import Fits
from emg2vsa.report.wording import activity, number

INK, MUTED, GRID, BLUE = "var(--ink)", "var(--muted)", "var(--line)", "var(--link)"
_TEXT = 24
_SHOWN = 0.56
"Pixels per unit, at most: drawings are shown at about half the size at which they are made."


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
        """Path data of a polyline, in relative steps; points that are not finite are left out."""
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
        """The drawing, with a title and a description for screen readers."""
        return (
            f'<svg viewBox="0 0 {self.width} {self.height}" style="max-width:{self.width * _SHOWN:.0f}px;'
            f'min-width:{self.width * _SHOWN * (0.7 if self.width > 1000 else 0.5):.0f}px;background:none" role="img" '
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
    limits = "".join(f"M{area.left} {int(area.y(n))}H{area.width - area.right}" for n in window_n)
    body = (
        _shades(trials, area)
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


def _shades(trials: Trials, area: PlotArea) -> str:
    """The loading phases over the whole height, numbered, in the pattern of their verdict."""
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
    return "".join(shades)


def emg_trace(trials: Trials, muscle: int, name: str) -> str:
    """Raw EMG of the whole record, its extremes in each column, and its mean rectified value; presses shaded."""
    shown = trials.overviews
    low_v = np.concatenate([o.low_v[muscle] for o in shown])
    high_v = np.concatenate([o.high_v[muscle] for o in shown])
    mean_v = np.concatenate([o.mean_v[muscle] for o in shown])
    time_s = np.concatenate([o.start_s + o.step_s * (np.arange(o.mean_v.shape[1]) + 0.5) for o in shown])
    scale = activity_scale("V", mean_v)
    # a few spikes must not flatten the rest
    top = float(np.quantile(np.maximum(np.abs(low_v), np.abs(high_v)), 0.98)) * 1.25 * scale.factor or 1.0
    area = PlotArea((float(time_s[0]), float(time_s[-1])), (-top, top), width=1900, height=260, bottom=64)
    outline_s, outline = np.concatenate((time_s, time_s[::-1])), np.concatenate((high_v, low_v[::-1])) * scale.factor
    outline = np.clip(outline, -top, top)
    body = (
        _shades(trials, area)
        + area.axes("Time (s)", scale.label(trials.muscles[muscle]))
        + f'<path d="{area.line(outline_s, outline)}z" fill="{MUTED}" fill-opacity=".55"/>'
        + f'<path d="{area.line(time_s, np.clip(mean_v * scale.factor, -top, top))}" stroke="{RED}" stroke-width="3"/>'
    )
    said = f"Largest sample {activity(float(np.max(np.abs([low_v, high_v]))), scale)}."
    return area.svg(body, name, f"Raw EMG and envelope of {trials.muscles[muscle]}, {trials.specimen}", said)


def spectra(trials: Trials, muscle: int, name: str) -> str:
    """Amplitude density at rest and while pressing, on a logarithmic scale."""
    first = trials.overviews[0]
    densities = [np.sqrt(each[muscle]) * 1e6 for each in (first.resting, first.pressing)]
    known = np.concatenate([d[np.isfinite(d) & (d > 0)] for d in densities])
    if known.size == 0:
        return ""
    low, high = math.log10(float(np.quantile(known, 0.02))), math.log10(float(known.max()))
    area = PlotArea(
        (0.0, float(first.frequency_hz[-1])), (low - 0.1, max(high, low + 1) + 0.1), width=950, height=380, right=44
    )
    body = area.axes("Frequency (Hz)", f"{trials.muscles[muscle]}, log10 of µV/√Hz")
    for density, colour, dash in zip(densities, (BLUE, RED), (' stroke-dasharray="12 6"', ""), strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            y = np.log10(density)
        body += f'<path d="{area.line(first.frequency_hz, np.maximum(y, low))}" stroke="{colour}"{dash}/>'
    body += text(area.width - 30, 60, "pressing", "end", RED) + text(
        area.width - 30, 90, "at rest, dashed", "end", BLUE
    )
    return area.svg(
        body, name, f"Spectrum of {trials.muscles[muscle]}", "Amplitude density at rest and during presses."
    )


def median_frequencies(trials: Trials, name: str) -> str:
    """Median frequency of every press and muscle, in time order. The median frequency of a tired muscle falls."""
    median_hz = np.concatenate([o.median_hz for o in trials.overviews], axis=1)
    known = median_hz[np.isfinite(median_hz)]
    if known.size == 0:
        return ""
    n = median_hz.shape[1]
    area = PlotArea((0.5, n + 0.5), (0.0, float(known.max()) * 1.15), width=950, height=380)
    body = area.axes("Press", "Median frequency (Hz)")
    press = np.arange(1, n + 1).astype(np.float64)
    for muscle, colour, dash in zip(
        trials.muscles, (BLUE, RED, INK, MUTED) * len(trials.muscles), _LINES, strict=False
    ):
        row = median_hz[trials.muscles.index(muscle)]
        body += f'<path d="{area.line(press, row)}" stroke="{colour}"{dash}/>'
        body += f'<path d="{area.dots(press, row)}" stroke="{colour}" stroke-width="9" stroke-linecap="round"/>'
        at = 40 + 28 * trials.muscles.index(muscle)
        body += text(area.width - 30, area.height - 90 - at, muscle, "end", colour)
    means = ", ".join(f"{m} {np.nanmean(row):.0f} Hz" for m, row in zip(trials.muscles, median_hz, strict=True)
                      if np.isfinite(row).any())  # fmt: skip
    return area.svg(body, name, f"Median frequency over the presses, {trials.specimen}", f"Means: {means}.")


_LINES = ("", ' stroke-dasharray="12 6"', ' stroke-dasharray="4 6"', ' stroke-dasharray="14 4 4 4"') * 8


def activity_plot(fits: Fits, scale: ActivityScale, name: str) -> str:
    """Bin means and the fitted curve of every press, in one colour per press, with its number at the end."""
    low, high = float(fits.bin_edges_n[0]), float(fits.bin_edges_n[-1])
    v = fits.bin_v * scale.factor
    shown = v[np.isfinite(v)]
    top = float(shown.max(initial=0.0)) * 1.05 or 1.0
    area = PlotArea((0.0, high * 1.02), (min(0.0, float(shown.min(initial=0.0))), top), width=950, height=560, right=90)
    grid = np.geomspace(low, high, _CURVE_POINTS)
    curves = (fits.a_v[:, None] + fits.b_v[:, None] * np.log(grid)) * scale.factor
    body = area.axes("Force (N)", scale.label("Co-contraction"))
    odd = odd_presses(fits)
    for i, verdict in enumerate(fits.verdict.tolist()):
        colour = _hue(i, len(odd))
        press = f"{fits.repetition[i]}{MARKS[verdict]}"
        title = escape(f"press {press}: {verdict} {fits.reason[i]}".strip())
        dots, line = area.dots(fits.bin_force_n[i], v[i]), area.line(grid, curves[i])
        width = 6 if odd[i] else 2.5
        body += (
            f'<g stroke="{colour}"><title>{title}</title>'
            f'<path d="{dots}" stroke-width="7" stroke-linecap="round" stroke-opacity=".35"/>'
            f'<path d="{line}" stroke-width="{width}"{_DASHES[verdict]}/></g>'
        )
    ends = np.where(np.isfinite(curves[:, -1]), curves[:, -1], np.nan)
    for i, y in _apart(area.y(np.clip(np.nan_to_num(ends), *area.y_range)), np.isfinite(ends)):
        colour = _hue(i, len(odd))
        verdict = str(fits.verdict[i])
        label = f"{fits.repetition[i]}{MARKS[verdict]}{' odd' if odd[i] else ''}"
        body += text(area.width - area.right + 10, y + 8, label, "start", colour)
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


def _hue(i: int, n: int) -> str:
    """Colour of the i-th of n presses, to be seen on white and on black."""
    return f"hsl({round(360 * i / n)} 75% 48%)"


def odd_presses(fits: Fits) -> NDArray[np.bool_]:
    """Presses (n,) whose b or fitted level lies more than 3.5 robust SDs from the median of the recording."""
    odd = np.zeros(fits.b_v.size, dtype=np.bool_)
    for values in (fits.b_v, (fits.v_min_v + fits.v_max_v) / 2):
        known = np.isfinite(values)
        if np.count_nonzero(known) < 4:
            continue
        away = np.abs(values - median(values[known]))
        odd |= known & (away > 3.5 * 1.4826 * median(away[known]))
    return odd


def _apart(y: Floats, known: NDArray[np.bool_], least: int = 22) -> list[tuple[int, int]]:
    """Place and height of each known label, moved down so that none covers another."""
    placed: list[tuple[int, int]] = []
    lowest = -least
    for i in np.argsort(y, kind="stable").tolist():
        if known[i]:
            lowest = max(int(y[i]), lowest + least)
            placed.append((i, lowest))
    return placed
