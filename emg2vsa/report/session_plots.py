"""The drawings of a recording on its page, in the colours of the page, light or dark."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.svg import Axes, in_colours_of_page, thinned
from emg2vsa.arrays import Floats, median
from emg2vsa.extraction import Trials
from emg2vsa.figures.palette import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PURPLE,
    RED,
    VERDICT_COLOURS,
    YELLOW,
    ActivityScale,
    activity_scale,
)
from emg2vsa.fits import Fits
from emg2vsa.report.numbers import least, most
from emg2vsa.report.wording import activity, number
from emg2vsa.signals.bias import TOLD

MARKS = {"ok": "", "doubtful": "!", "rejected": "×"}
_DASHES = {"ok": "", "doubtful": "16 8", "rejected": "4 10"}
_LINES = ("", "14 8", "4 8", "16 6 4 6")
_MOST_PERCENT = 60.0
"The highest end of the axis of the budget."
_TRACE_POINTS, _CURVE_POINTS = 900, 12
_WIDE, _NARROW = 1900, 780
_LABEL_S = 0.025
"Least distance of the numbers of presses, as a share of the record."

_HATCHES = {"ok": (0.22, ""), "doubtful": (0.25, "M0 8L8 0"), "rejected": (0, "M0 0L8 8M0 8L8 0")}
LEGEND = in_colours_of_page(
    '<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs>'
    + "".join(
        f'<pattern id="{verdict}" width="8" height="8" patternUnits="userSpaceOnUse">'
        f'<rect width="8" height="8" fill="{VERDICT_COLOURS[verdict]}" fill-opacity="{opacity}"/>'
        f'<path d="{lines}" stroke="{VERDICT_COLOURS[verdict]}" stroke-width="2"/></pattern>'
        for verdict, (opacity, lines) in _HATCHES.items()
    )
    + '</defs></svg><p class="small" aria-hidden="true">'
    + " ".join(
        f'<svg width="34" height="16"><rect x="1" y="1" width="32" height="14" fill="url(#{verdict})" '
        f'stroke="{VERDICT_COLOURS[verdict]}"/></svg> {verdict} {mark}'
        for verdict, mark in MARKS.items()
    )
    + "</p>\n"
)
"""The patterns of the verdicts, for all drawings of a page, and what they mean."""


def force_trace(trials: Trials, window_n: tuple[float, float], name: str) -> str:
    """Force of the whole record, N over s, loading phases shaded by verdict and numbered. window_n : N."""
    time_s, force_n = thinned(trials.overview_time_s, trials.overview_force_n, _TRACE_POINTS)
    highest, lowest = (float(find(force_n, initial=0.0)) for find in (np.fmax.reduce, np.fmin.reduce))
    top, bottom = max(highest, window_n[1]) * 1.08, lowest
    axes = _record(trials, time_s, (top, bottom), "Force (N)", 300)
    for limit_n in window_n:
        axes.level(limit_n)
    axes.line(np.column_stack([time_s, force_n]), INK)
    counts = ", ".join(f"{np.count_nonzero(trials.verdict == verdict)} {verdict}" for verdict in MARKS)
    said = f"{trials.verdict.size} presses: {counts}. Highest force {number(highest)} N; "
    window = f"the window is {window_n[0]:g} to {window_n[1]:g} N."
    return axes.svg(name, f"Force over time, {trials.specimen}", said + window)


def _record(trials: Trials, time_s: Floats, y: tuple[float, float], label: str, height: float) -> Axes:
    """Axes over the whole record; loading phases over the whole height, numbered, in the pattern of their verdict."""
    first_s, last_s = (float(time_s[0]), float(time_s[-1])) if time_s.size > 1 else (0.0, 1.0)
    axes = Axes((first_s, y[0], last_s, y[1]), ("Time (s)", label), _WIDE, height)
    labelled_s = -np.inf
    for i, verdict in enumerate(trials.verdict.tolist()):
        start_s, stop_s = float(trials.start_s[i]), float(trials.stop_s[i])
        axes.shade(start_s, stop_s, f"url(#{verdict})")
        middle_s = (start_s + stop_s) / 2
        if middle_s - labelled_s >= _LABEL_S * (last_s - first_s):
            axes.above(middle_s, f"{trials.repetition[i]}{MARKS[verdict]}")
            labelled_s = middle_s
    return axes


def emg_trace(trials: Trials, muscle: int, name: str) -> str:
    """Raw EMG of the whole record, its extremes in each column, and its mean rectified value; presses shaded."""
    parts = trials.overviews
    low_v, high_v, mean_v = (
        np.concatenate([getattr(part, key)[muscle] for part in parts]) for key in ("low_v", "high_v", "mean_v")
    )
    time_s = np.concatenate([o.start_s + o.step_s * (np.arange(o.mean_v.shape[1]) + 0.5) for o in parts])
    scale = activity_scale("V", mean_v)
    # a few spikes must not flatten the rest
    top = float(np.quantile(np.maximum(np.abs(low_v), np.abs(high_v)), 0.98)) * 1.25 * scale.factor or 1.0
    axes = _record(trials, time_s, (top, -top), scale.label(trials.muscles[muscle]), 190)
    low, high, mean = (np.clip(v * scale.factor, -top, top) for v in (low_v, high_v, mean_v))
    axes.band(time_s, low, high, MUTED, opacity=0.55)
    axes.line(np.column_stack([time_s, mean]), RED)
    said = f"Largest sample {activity(float(np.max(np.abs([low_v, high_v]))), scale)}."
    return axes.svg(name, f"Raw EMG and envelope of {trials.muscles[muscle]}, {trials.specimen}", said)


def spectra(trials: Trials, muscle: int, name: str) -> str:
    """Amplitude density at rest and while pressing, on a logarithmic scale."""
    first = trials.overviews[0]
    densities = [np.sqrt(each[muscle]) * 1e6 for each in (first.resting, first.pressing)]
    known = np.concatenate([d[np.isfinite(d) & (d > 0)] for d in densities])
    if known.size == 0:
        return ""
    low, high = np.log10(np.quantile(known, 0.02)), np.log10(known.max())
    view = (0.0, float(max(high, low + 1) + 0.1), float(first.frequency_hz[-1]), float(low - 0.1))
    axes = Axes(view, ("Frequency (Hz)", f"{trials.muscles[muscle]}, log10 of µV/√Hz"), _NARROW, 290)
    for density, colour, dash, label in zip(densities, (BLUE, RED), ("14 6", ""), ("at rest", "pressing"), strict=True):
        with np.errstate(divide="ignore", invalid="ignore"):
            height = np.maximum(np.log10(density), low)
        axes.line(np.column_stack([first.frequency_hz, height]), colour, dash=dash, label=label)
    title = f"Spectrum of {trials.muscles[muscle]}"
    return axes.svg(name, title, "Amplitude density at rest and during presses.")


def median_frequencies(trials: Trials, name: str) -> str:
    """Median frequency of every press and muscle, in time order. The median frequency of a tired muscle falls."""
    median_hz = np.concatenate([o.median_hz for o in trials.overviews], axis=1)
    known = median_hz[np.isfinite(median_hz)]
    if known.size == 0:
        return ""
    n = median_hz.shape[1]
    axes = Axes((0.5, float(known.max()) * 1.15, n + 0.5, 0.0), ("Press", "Median frequency (Hz)"), _NARROW, 290)
    press, means = np.arange(1.0, n + 1), []
    for m, (muscle, row) in enumerate(zip(trials.muscles, median_hz, strict=True)):
        at, colour = np.column_stack([press, row]), (BLUE, RED, INK, MUTED)[m % 4]
        axes.line(at, colour, dash=_LINES[m % 4], label=muscle)
        axes.dots(at, colour)
        if np.isfinite(row).any():
            means.append(f"{muscle} {np.nanmean(row):.0f} Hz")
    title = f"Median frequency over the presses, {trials.specimen}"
    return axes.svg(name, title, f"Means: {', '.join(means)}.")


def activity_plot(fits: Fits, scale: ActivityScale, name: str) -> str:
    """Bin means and the fitted curve of every press, in one colour per press, with its number at the end."""
    low_n, high_n = float(fits.bin_edges_n[0]), float(fits.bin_edges_n[-1])
    v = fits.bin_v * scale.factor
    highest, bottom = (float(find(v, axis=None, initial=0.0)) for find in (np.fmax.reduce, np.fmin.reduce))
    top = highest * 1.05 or 1.0
    grid = np.geomspace(low_n, high_n, _CURVE_POINTS)
    curves = (fits.a_v[:, None] + fits.b_v[:, None] * np.log(grid)) * scale.factor
    labels = ("Force (N)", scale.label("Co-contraction"))
    axes = Axes((0.0, top, 1.02 * high_n, bottom), labels, _NARROW, 460, beside=80)
    odd = odd_presses(fits)
    colours = [f"hsl({round(360 * i / len(odd))} 75% 48%)" for i in range(len(odd))]  # seen on white and on black
    words = []
    for i, verdict in enumerate(fits.verdict.tolist()):
        press = f"{fits.repetition[i]}{MARKS[verdict]}"
        title = f"press {press}: {verdict} {fits.reason[i]}".strip()
        axes.dots(np.column_stack([fits.bin_force_n[i], v[i]]), colours[i], size=8, opacity=0.35)
        line = np.column_stack([grid, curves[i]])
        axes.line(line, colours[i], width=7 if odd[i] else 3, dash=_DASHES[verdict], title=title)
        words.append(f"{press} odd" if odd[i] else press)
    axes.ends(curves[:, -1], words, colours)
    ends = [activity(find(fits.b_v), scale) for find in (least, most)]
    said = f"b from {' to '.join(ends)}" if np.isfinite(fits.b_v).any() else "no fit"
    title = f"Co-contraction against force, {fits.specimen[0] if fits.specimen.size else ''}"
    return axes.svg(name, title, f"Force bins and fitted curves of {fits.b_v.size} presses: {said}.")


def budget_plot(trials: Trials, fits: Fits, name: str) -> str:
    """What is left of each cause in b of every press, beside the half width of its interval."""
    off = np.abs(1 - 1 / (1 + fits.b_bias))
    half = ((fits.b_hi_v - fits.b_lo_v) / np.abs(fits.b_v) - off) / 2
    left, error = 100 * trials.bias.b, 100 * trials.bias.b_se
    shown = np.flatnonzero(np.any(np.hypot(left, error) > 100 * TOLD, axis=1))
    top = float(np.clip(np.nanmax([12.0, *(100 * half), *np.abs(left).ravel()]), 0, _MOST_PERCENT)) * 1.1
    n = half.size
    labels = ("Press", "Share of b (%)")
    axes = Axes((0.4, top, n + 0.6, -top), labels, _WIDE, 330, whole=True)
    for press, reach in enumerate(np.clip(100 * half, 0, top).tolist(), 1):
        if np.isfinite(reach):
            corners = [(press + x, y) for x, y in ((-0.38, -reach), (-0.38, reach), (0.38, reach), (0.38, -reach))]
            axes.areas(np.array([corners]), MUTED, opacity=0.22, label="half width of b" if press == 1 else "")
    for limit in (-10.0, 0.0, 10.0):
        axes.level(limit, dash="" if limit == 0 else "8 10")
    at = np.arange(1.0, n + 1)
    for place, row in enumerate(shown.tolist()):
        x = at + 0.6 * ((place + 0.5) / shown.size - 0.5)
        colour = (BLUE, RED, PURPLE, GREEN, YELLOW, INK)[place % 6]
        y = np.clip(left[row], -top, top)
        for one, middle, se in zip(x.tolist(), y.tolist(), error[row].tolist(), strict=True):
            axes.line(np.array([(one, np.clip(middle + k * se, -top, top)) for k in (-1, 1)]), colour)
        axes.dots(np.column_stack([x, y]), colour, size=12, label=trials.bias.causes[row])
    axes.crosses(np.column_stack([at, np.clip(100 * fits.b_bias, -top, top)]), INK, label="all causes")
    worst = int(np.argmax(np.abs(fits.b_bias))) if n and np.isfinite(fits.b_bias).all() else -1
    largest = f"{100 * fits.b_bias[worst]:+.1f} % of b in press {fits.repetition[worst]}" if worst >= 0 else "not known"
    causes = ", ".join(trials.bias.causes[row] for row in shown) or "no cause above a half percent"
    return axes.svg(name, f"Budget of bias, {trials.specimen}", f"Largest sum: {largest}. Causes: {causes}.")


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
