"""Can stiffness help? What that of the actuator can do to CASR by contact mechanics, by frames and by timing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from casr.errors import InputError
from casr.spread import spread_rate
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Claim, Quantities, Section
from emg2vsa.report.sections.actuators import CONTRAST_CLAIM, CONTRAST_PAPER, CONTRAST_SAYS, contrast_claim
from emg2vsa.report.table import Cell, Column, Row, Table, rows_of
from emg2vsa.report.wording import number, signed
from emg2vsa.run_scores.product import PressCurve
from emg2vsa.stiffness_effect import (
    LOSSY_SENSOR,
    LOSSY_SPECIMENS,
    PRESS_CV,
    StiffnessEffect,
    replicates_needed,
)

_HUMAN_LIKE = "modular"
_ASSUMED, _LOSSY = 1, 2
"Materials other than the elastic ones, in their order."
_WANTED = 0.2
"A gain of contrast that would be plain to see, as a share."


def _applies(results: StudyResults) -> bool:
    return results.stiffness is not None


def _effect(results: StudyResults) -> StiffnessEffect:
    assert results.stiffness is not None
    return results.stiffness


def _gains(effect: StiffnessEffect) -> np.ndarray:
    """(M, C) contrast of the softest specimen against that under the rigid motor, difference of logarithms."""
    contrast = effect.contrast(effect.slope)
    return np.asarray(contrast - contrast[:, :1])


def _neighbours(effect: StiffnessEffect, sums: np.ndarray) -> np.ndarray:
    """(C,) ratio of the second stiffest specimen to the stiffest."""
    return np.asarray(np.exp(effect.contrast(sums, 1)))


def _quantities(results: StudyResults) -> Items:
    effect = _effect(results)
    gains, sums = _gains(effect), np.exp(effect.contrast(effect.frame_sum))
    yield "stiffness.pair", " ".join(effect.pair)
    for c, condition in enumerate(effect.conditions):
        name = f"stiffness.{condition}"
        for k, specimen in enumerate(effect.specimens):
            yield f"{name}.{specimen}.duration_s", float(effect.duration_s[k, c])
            yield f"{name}.{specimen}.frame_sum", float(effect.frame_sum[k, c])
            yield f"{name}.{specimen}.frame_sum_swapped", float(effect.frame_sum_swapped[k, c])
        for m, material in enumerate(("elastic", "assumed", "lossy_sensor")):
            yield f"{name}.contrast.{material}", float(np.exp(effect.contrast(effect.slope)[m, c]))
            yield f"{name}.contrast_gain.{material}_percent", float(100 * np.expm1(gains[m, c]))
        yield f"{name}.frame_sum.contrast", float(sums[c])
        yield f"{name}.frame_sum.neighbour", float(_neighbours(effect, effect.frame_sum)[c])
        yield f"{name}.frame_sum.neighbour_swapped", float(_neighbours(effect, effect.frame_sum_swapped)[c])
        yield f"{name}.slope.neighbour_swapped", float(_neighbours(effect, effect.slope_swapped)[c])
        yield f"{name}.timing.d", float(effect.timing_d[c])
        for k, specimen in enumerate(effect.pair):
            yield f"{name}.timing.{specimen}.cv", float(effect.timing_cv[k, c])
        if c:
            yield f"{name}.presses_needed", float(replicates_needed(gains[_ASSUMED], PRESS_CV)[c])
            yield f"{name}.mountings_needed", float(replicates_needed(gains[_ASSUMED], _mounting_sd(results))[c])
    yield "stiffness.timing.best", effect.conditions[int(effect.timing_d.argmax())]
    yield "stiffness.frame_sum.swaps_order", _swaps(effect)
    if _HUMAN_LIKE in effect.conditions:
        yield "stiffness.modular.creep_exponent_needed", _exponent(effect)


def _mounting_sd(results: StudyResults) -> float:
    return results.study.calibration.mounting_sd_percent / 100


def _exponent(effect: StiffnessEffect) -> float:
    return effect.creep_exponent(_WANTED, effect.conditions.index(_HUMAN_LIKE))


def _swaps(effect: StiffnessEffect) -> bool:
    """Whether the two stiffest specimens change places by equation (2) when human-like schedules are swapped."""
    if _HUMAN_LIKE not in effect.conditions:
        return False
    c = effect.conditions.index(_HUMAN_LIKE)
    return bool(_neighbours(effect, effect.frame_sum)[c] > 1 > _neighbours(effect, effect.frame_sum_swapped)[c])


def _named(condition: str) -> str:
    return f"constant, {condition.removeprefix('all-')} % for all" if condition.startswith("all-") else condition


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    effect = _effect(results)
    names = [_named(condition) for condition in effect.conditions]
    yield _three_ways(effect, names)
    yield _would_be(results, effect)
    yield _leak(effect, names)
    yield _needed(results, effect, names)
    yield _measured(results, effect)
    yield _by_specimen(effect, names)


def _three_ways(effect: StiffnessEffect, names: list[str]) -> Table:
    stiff, second, soft = effect.specimens[0], effect.specimens[1], effect.specimens[-1]
    columns = (
        Column("condition", "Condition"),
        Column("duration_stiff_s", f"{stiff} lasts (s)"), Column("duration_soft_s", f"{soft} lasts (s)"),
        Column("gain_percent", f"Creep: change of {soft} : {stiff} (%)", digits=2),
        Column("frame_sum", f"Eq. (2): {soft} : {stiff}"),
        Column("timing_d", f"Timing: d′ of {stiff} and {second}", digits=2),
    )  # fmt: skip
    rows = rows_of(
        {
            "condition": names,
            "duration_stiff_s": effect.duration_s[0],
            "duration_soft_s": effect.duration_s[-1],
            "gain_percent": 100 * np.expm1(_gains(effect)[_ASSUMED]),
            "frame_sum": np.exp(effect.contrast(effect.frame_sum)),
            "timing_d": effect.timing_d,
        }
    )
    caption = "What stiffness can do at 0°: change against the rigid motor, ratio of sums over frames, and d′"
    return Table("stiffness_effect", caption, columns, rows)


def _leak(effect: StiffnessEffect, names: list[str]) -> Table:
    stiff, second = effect.specimens[:2]
    columns = (
        Column("condition", "Condition"), Column("neighbour", "Eq. (2), own schedules"),
        Column("neighbour_swapped", "Eq. (2), schedules swapped"), Column("slope_swapped", "Slope, schedules swapped"),
    )  # fmt: skip
    rows = rows_of(
        {
            "condition": names,
            "neighbour": _neighbours(effect, effect.frame_sum),
            "neighbour_swapped": _neighbours(effect, effect.frame_sum_swapped),
            "slope_swapped": _neighbours(effect, effect.slope_swapped),
        }
    )
    caption = (
        f"Ratio {second} : {stiff} of elastic bodies; swapped: the stiffest specimen is pressed with the schedule of "
        "the softest, and so on"
    )
    return Table("stiffness_leak", caption, columns, rows)


def _needed(results: StudyResults, effect: StiffnessEffect, names: list[str]) -> Table:
    gains = _gains(effect)
    columns = (
        Column("condition", "Condition"), Column("gain_percent", "Assumed creep: change (%)", digits=2),
        Column("presses", "Presses per cell, without mountings", digits=2),
        Column("mountings", "Mountings per cell", digits=2),
        Column("gain_lossy_percent", "Lossy sensor: change (%)", digits=2),
    )  # fmt: skip
    rows = rows_of(
        {
            "condition": names[1:],
            "gain_percent": 100 * np.expm1(gains[_ASSUMED, 1:]),
            "presses": replicates_needed(gains[_ASSUMED], PRESS_CV)[1:],
            "mountings": replicates_needed(gains[_ASSUMED], _mounting_sd(results))[1:],
            "gain_lossy_percent": 100 * np.expm1(gains[_LOSSY, 1:]),
        }
    )
    caption = (
        "Change of the contrast by creep as the rig file assumes it (relaxation, sensor_relaxation), and what it takes "
        "to see it (5 % level, 80 % power): presses with a CV of "
        f"{100 * PRESS_CV:g} %, or mountings with an SD of {100 * _mounting_sd(results):g} %. The lossy sensor relaxes "
        f"by {100 * LOSSY_SENSOR:g} %, all specimens by {100 * LOSSY_SPECIMENS:g} %"
    )
    return Table("stiffness_needed", caption, columns, rows)


def _by_specimen(effect: StiffnessEffect, names: list[str]) -> Table:
    columns = (
        Column("condition", "Condition"), Column("specimen", "Specimen"), Column("duration_s", "Duration (s)"),
        Column("slope_mm2_per_n", "Slope (mm²/N)"), Column("frame_sum", "Eq. (2) (mm²/N)"),
        Column("frame_sum_swapped", "Eq. (2), schedules swapped"),
    )  # fmt: skip
    count = len(effect.specimens)
    rows = rows_of(
        {
            "condition": [name for name in names for _ in range(count)],
            "specimen": list(effect.specimens) * len(names),
            "duration_s": effect.duration_s.T.ravel(),
            "slope_mm2_per_n": effect.slope[0].T.ravel(),
            "frame_sum": effect.frame_sum.T.ravel(),
            "frame_sum_swapped": effect.frame_sum_swapped.T.ravel(),
        }
    )
    return Table(
        "stiffness_specimens", "Elastic bodies: duration, slope of area on force, and equation (2)", columns, rows
    )


def _measured(results: StudyResults, effect: StiffnessEffect) -> Table:
    """Contrasts of the scored runs at 0 degrees; no rows without them."""
    columns = (
        Column("condition", "Condition"), Column("casr", "CASR"), Column("frame_sum", "Eq. (2) as printed"),
    )  # fmt: skip
    soft, stiff = effect.specimens[-1], effect.specimens[0]
    rows: list[Row] = []
    for condition in effect.conditions:
        of_soft, of_stiff = (_medians(results, specimen, condition) for specimen in (soft, stiff))
        if np.isfinite(of_soft[0] / of_stiff[0]):
            row: dict[str, Cell] = {"condition": condition}
            row |= {"casr": of_soft[0] / of_stiff[0], "frame_sum": of_soft[1] / of_stiff[1]}
            rows.append(row)
    caption = (
        f"The runs of this study at 0°, areas by {results.study.scoring.algorithm}: ratio {soft} : {stiff} of median "
        "CASR, and of the sum of dA/dF over frames"
    )
    return Table("stiffness_measured", caption, columns, tuple(rows))


def _medians(results: StudyResults, specimen: str, condition: str) -> tuple[float, float]:
    """Median CASR of the presses, and median of the sum over frames of the same areas; NaN without them."""
    runs = results.runs.scores if results.runs else ()
    own = [run for run in runs if (run.specimen, run.condition, run.angle_deg) == (specimen, condition, 0.0)]
    rates = [rate for run in own for rate in run.casr[run.algorithm].tolist() if np.isfinite(rate)]
    sums = [_sum_of(curve) for run in own for curve in run.curves if curve.force_n.size > 1]
    return (float(np.median(rates)), float(np.median(sums))) if rates and sums else (np.nan, np.nan)


def _sum_of(curve: PressCurve) -> float:
    try:
        return spread_rate(curve.area_mm2, curve.force_n, rule="paper").value
    except InputError:  # a force that does not rise
        return np.nan


def _would_be(results: StudyResults, effect: StiffnessEffect) -> Table:
    columns = (Column("need", "For the paper's claim this would have to be true"), Column("here", "Here"))
    rows: list[Row] = []
    if _HUMAN_LIKE in effect.conditions:
        c = effect.conditions.index(_HUMAN_LIKE)
        sums = np.exp(effect.contrast(effect.frame_sum))
        best = int(effect.timing_d.argmax())
        exponent = _exponent(effect)
        rows = [
            {
                "need": "CASR counts frames or duration",
                "here": f"Equation (2) as printed does: {number(sums[0])} (rigid), {number(sums[c])} (human-like). "
                "Presses of equal duration, or a CASR free of the number of frames, would show it.",
            },
            {
                "need": "Errors of timing dominate",
                "here": f"Then {_named(effect.conditions[best])} is best (d′ {number(effect.timing_d[best])}; "
                f"human-like {number(effect.timing_d[c])}).",
            },
            {
                "need": "Specimens creep far more than solids do",
                "here": f"{100 * _WANTED:g} % more contrast needs creep like t to the power {number(exponent)}"
                + (" or more; a liquid has 1." if np.isfinite(exponent) else "."),
            },
            {
                "need": "The skin's contact area depends on stiffness directly",
                "here": "No such mechanism is known. Control world P1 has one made up.",
            },
            {
                "need": "Rigid motor and variable stiffness actuator guide the probe differently",
                "here": "They are different mechanics, never exchanged. Several mountings of both would show it.",
            },
        ]
    return Table("stiffness_would_be", "What would have to be true for the paper's claim", columns, tuple(rows))


def _claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """By the runs; mechanics stands beside them."""
    effect = _effect(results)
    if _HUMAN_LIKE not in effect.conditions:
        return
    c, d, gains = effect.conditions.index(_HUMAN_LIKE), effect.timing_d, 100 * np.expm1(_gains(effect)[_ASSUMED])
    best = int(d.argmax())
    by_mechanics = f"contrast {signed(float(gains[c]), '%')}, d′ {number(d[c], 2)}"
    if best != c:
        by_mechanics += f" ({_named(effect.conditions[best])}: {number(d[best], 2)})"
    tests = results.runs.discrimination if results.runs else None
    claim = contrast_claim(tests) if tests else None
    if claim is None:
        claim = Claim(
            CONTRAST_CLAIM, CONTRAST_SAYS, CONTRAST_PAPER, "not tested", np.nan, "cannot be tested here",
            why="Human-like stiffness and the rigid motor were not compared in runs.",
        )  # fmt: skip
    yield replace(claim, companion=f"by mechanics: {by_mechanics}")


_TEXT = """
<p>In contact mechanics the actuator's stiffness changes the duration of a press alone. Duration changes CASR by creep,
by the frames that equation (2) sums over, and by errors of the camera's timing.
Creep changes the contrast by {{ creep_percent | number(2) }} % at most{% if small %}, less than mountings scatter
({{ mounting_percent | number(2) }} % SD){% endif %}.
{% if swaps %}Equation (2) follows the schedule: swapped schedules swap {{ pair[0] }} and {{ pair[1] }}. {% endif %}
{% if softest %}Against errors of timing the softest constant stiffness is best.{% endif %}</p>
{{ folded("stiffness_effect", "What stiffness can do, by condition") }}
{{ folded("stiffness_would_be", "What would have to be true for the paper's claim") }}
{{ folded("stiffness_measured", "The same in the runs of this study") }}
{{ folded("stiffness_leak", "Swapped schedules") }}
{{ folded("stiffness_needed", "Presses and mountings needed") }}
{{ folded("stiffness_specimens", "Every specimen alone") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    effect = _effect(results)
    softest = int(effect.duration_s.sum(axis=0).argmax())
    return {
        "small": bool(np.abs(_gains(effect)[_ASSUMED]).max() < _mounting_sd(results)),
        "creep_percent": float(100 * np.abs(np.expm1(_gains(effect)[_ASSUMED])).max()),
        "mounting_percent": 100 * _mounting_sd(results),
        "swaps": _swaps(effect),
        "softest": int(effect.timing_d.argmax()) == softest,
        "pair": effect.pair,
    }


STIFFNESS = Section(
    "stiffness", "Can stiffness help?", _TEXT, _applies, _quantities, _tables, claims=_claims, words=_words
)
