"""The two drawings of a recording on its participant's page: force over time, and co-contraction against force."""

from __future__ import annotations

import numpy as np

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.figures.palette import INK, MUTED, VERDICT_COLOURS
from emg2vsa.fits import Fits
from emg2vsa.report.plot_area import PlotArea, text, thinned
from emg2vsa.report.wording import activity, number
from emg2vsa.trials import Trials

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
