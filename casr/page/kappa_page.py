"""The page of presses whose specimens' kappa was estimated: misfit over kappa, what each cue says, the bound, notes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from casr import html
from casr.kappa.estimate import SensorKappa
from casr.kappa.known import KnownSensor
from casr.kappa.posterior import Kappa, Posterior
from casr.page.pages import picture_figure, whole_page
from casr.page.wording import number
from casr.palette import BLUE, FAINT, GREEN, INK, PURPLE, RED, SKY
from casr.svg import Axes, Picture

Array = NDArray[np.float64]

_COLOURS = {"pins": BLUE, "force": PURPLE, "travel": GREEN}
_POINTS, _WITHIN = 41, (1.4, 4.0)
"Points of a curve; least and largest factor of kappa that is drawn to either side."
_SURE = 1.96
"Standard errors of a 95 % interval."


def kappa_page(title: str, found: SensorKappa, not_used: Mapping[str, str]) -> str:
    """The page as HTML. not_used : presses that could not be used, and why."""
    kappas = sorted(found.kappas.values(), key=lambda each: each.known is not None)
    told = [each for each in kappas if each.known is None]
    tiles = [(each.specimen, f"{number(each.value, 3)} N/mm", f"95 %: {_interval(each)}") for each in told]
    tiles += [
        ("Left over", f"{found.misfit:.1%}", "of the motion of the pins, beyond noise"),
        ("Noise of a pin", f"{found.noise_px:.2g} px", ""),
    ]
    notes = html.bullets([*(f"Not used: {name}: {why}" for name, why in not_used.items()), *found.notes])
    body = (
        html.tiles(tiles)
        + (html.section("notes", "Notes", notes) if notes else "")
        + html.section("pictures", "Misfit over kappa", html.paragraph(_READ), html.pictures(
            picture_figure(_picture(each, found, f"kappa{place}")) for place, each in enumerate(kappas)
        ))
        + html.section("numbers", "Numbers", _table(kappas))
    )  # fmt: skip
    return whole_page(title, "Stiffness kappa of specimens, by presses of one sensor", body)


_READ = (
    "Curves: how much of the motion of the pins is left over, beyond noise, if kappa is as the axis says; friction, "
    "tilt and contact radii are fitted again at each kappa, and the sensor is the one that all presses tell. Above "
    "them: the estimate with its total interval, and each cue alone, each with 95 %. Band: Cramér and Rao's bound, the "
    "interval that white noise of the pins alone would leave."
)


def _picture(kappa: Kappa, found: SensorKappa, name: str) -> Picture:
    log_reach = np.clip(4 * kappa.log_sd, *np.log(_WITHIN))
    log_kappa = np.log(kappa.value) + np.linspace(-log_reach, log_reach, _POINTS)
    curves = 100 * _left_over(kappa.specimen, found, log_kappa, kappa.known is not None)
    together = np.sqrt((curves**2).mean(axis=0))
    x, top = log_kappa / np.log(10), float(curves.max())
    rows = {"all cues": (kappa.value, kappa.low, kappa.high, INK)}
    for cue, (value, sd) in kappa.by_cue.items():
        reach = np.exp(_SURE * sd)
        rows[f"{cue} alone"] = (value, value / reach, value * reach, _COLOURS[cue])
    bottom = min(0.9 * float(curves.min()), 0.9 * top)
    row_step = 0.09 * (top - bottom)
    heights = np.array([top + row_step * row for row in range(len(rows), 0, -1)], np.float64)
    axes = Axes(
        (x[0], heights[0] + row_step, x[-1], bottom), ("kappa (N/mm)", "left over (%)"), beside=130, logarithmic=True
    )
    at, of_bound = float(np.log10(kappa.value)), _SURE * kappa.bound_sd / float(np.log(10))
    axes.shade(at - of_bound, at + of_bound, FAINT, f"bound: ± {100 * kappa.bound_sd:.1f} % (one standard error)")
    for row, curve in enumerate(curves):
        axes.line(np.column_stack([x, curve]), SKY, width=2, label="" if row else "each press")
    axes.line(np.column_stack([x, together]), BLUE, width=5, label="its presses together")
    if kappa.known is not None:
        there = np.log10(kappa.known)
        axes.line([(there, bottom), (there, heights[0] + row_step)], RED, dash="10 8", label="known stiffness")
    for height, (value, low, high, colour) in zip(heights, rows.values(), strict=True):
        ends = np.clip(np.log10([max(low, 1e-9), min(high, 1e9)]), x[0], x[-1])
        axes.line(np.column_stack([ends, [height, height]]), colour, width=4)
        axes.dots([(np.log10(value), height)], colour, size=14)
    axes.ends(heights, list(rows), [colour for *_, colour in rows.values()])
    return Picture(name, _title(kappa), f"{kappa.n_presses} presses. {_caption(kappa)}", axes)


def _left_over(specimen: str, found: SensorKappa, log_kappa: Array, known: bool) -> Array:
    """(P, K) share of the motion left over beyond noise, of each press of a specimen at K values of ln kappa."""
    labels = found.labels
    z = Posterior(KnownSensor.of(labels), found.discrepancy, left_out=specimen if known else None).label(log_kappa)
    return np.array([
        np.sqrt(np.maximum(field.left_over_px(state, z) ** 2 - labels.noise_px**2, 0.0)) / field.moved_px
        for field, state in zip(labels.fields, labels.states, strict=True) if field.press.specimen == specimen
    ])  # fmt: skip


def _title(kappa: Kappa) -> str:
    if kappa.known is None:
        return f"{kappa.specimen}: {number(kappa.value, 3)} N/mm"
    return f"{kappa.specimen}, known, as the others tell it: {number(kappa.value, 3)} N/mm"


def _caption(kappa: Kappa) -> str:
    known = f"It is known to be {number(kappa.known, 3)} N/mm, which is not used here. " if kappa.known else ""
    said = f"The total interval is {_interval(kappa)}. {known}The design promises ± {100 * kappa.expected:.0f} %: "
    return said + ("kappa is determined." if kappa.determined else "too wide to call kappa determined.")


def _interval(kappa: Kappa) -> str:
    return f"{number(kappa.low, 3)} to {'rigid' if kappa.high == np.inf else number(kappa.high, 3)}"


def _table(kappas: list[Kappa]) -> str:
    heads = ("Specimen", "kappa (N/mm)", "95 % interval", "known", "determined", "promised ± %", "bound %",
             "efficiency", "presses", "pins alone", "force alone", "travel alone")  # fmt: skip
    rows = []
    for each in kappas:
        cues = [each.by_cue.get(cue) for cue in _COLOURS]
        rows.append((
            each.specimen, number(each.value, 3), _interval(each).replace(" ", "\u00a0"), number(each.known, 3),
            "yes" if each.determined else "no", f"{100 * each.expected:.0f}", f"{100 * each.bound_sd:.1f}",
            f"{each.efficiency:.2f}", str(each.n_presses),
            *(f"{number(cue[0], 3)}\u00a0±\u00a0{100 * cue[1]:.0f}\u00a0%" if cue else number(None) for cue in cues),
        ))  # fmt: skip
    caption = (
        "A known specimen: as the others tell it. Bound: the standard error that white noise of the pins alone would "
        "leave; efficiency: bound over the standard error reached. A cue alone: with its standard error; a dash: it "
        "tells nothing."
    )
    return html.table(caption, heads, rows)
