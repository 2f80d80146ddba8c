"""Can stiffness help? What that of the actuator can do to CASR by contact mechanics, by frames and by timing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from casr.errors import InputError
from casr.spread import spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import number
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
            each = ("duration_s", "frame_sum", "frame_sum_swapped")
            yield from fields_of(f"{name}.{specimen}", effect, *each, at=(k, c))
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


_CONDITION = Column("condition", "Condition")


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    effect = _effect(results)
    names = [_named(condition) for condition in effect.conditions]
    yield _three_ways(effect, names)
    yield _would_be(effect)
    yield _leak(effect, names)
    yield _needed(results, effect, names)
    yield _measured(results, effect)
    yield _by_specimen(effect, names)


def _three_ways(effect: StiffnessEffect, names: list[str]) -> Table:
    stiff, second, soft = effect.specimens[0], effect.specimens[1], effect.specimens[-1]
    gain = 100 * np.expm1(_gains(effect)[_ASSUMED])
    columns: Columns = {
        _CONDITION: names,
        Column("duration_stiff_s", f"{stiff} lasts (s)"): effect.duration_s[0],
        Column("duration_soft_s", f"{soft} lasts (s)"): effect.duration_s[-1],
        Column("gain_percent", f"Creep: change of {soft} : {stiff} (%)", digits=2): gain,
        Column("frame_sum", f"Eq. (2): {soft} : {stiff}"): np.exp(effect.contrast(effect.frame_sum)),
        Column("timing_d", f"Timing: d′ of {stiff} and {second}", digits=2): effect.timing_d,
    }
    caption = "What stiffness can do at 0°: change against the rigid motor, ratio of sums over frames, and d′"
    return table_of("stiffness_effect", caption, columns)


def _leak(effect: StiffnessEffect, names: list[str]) -> Table:
    stiff, second = effect.specimens[:2]
    columns: Columns = {
        _CONDITION: names,
        Column("neighbour", "Eq. (2), own schedules"): _neighbours(effect, effect.frame_sum),
        Column("neighbour_swapped", "Eq. (2), schedules swapped"): _neighbours(effect, effect.frame_sum_swapped),
        Column("slope_swapped", "Slope, schedules swapped"): _neighbours(effect, effect.slope_swapped),
    }
    caption = (
        f"Ratio {second} : {stiff} of elastic bodies; swapped: the stiffest specimen is pressed with the schedule of "
        "the softest, and so on"
    )
    return table_of("stiffness_leak", caption, columns)


def _needed(results: StudyResults, effect: StiffnessEffect, names: list[str]) -> Table:
    gains, mounting_sd = _gains(effect), _mounting_sd(results)
    presses, mountings = (replicates_needed(gains[_ASSUMED], sd)[1:] for sd in (PRESS_CV, mounting_sd))
    columns: Columns = {
        _CONDITION: names[1:],
        Column("gain_percent", "Assumed creep: change (%)", digits=2): 100 * np.expm1(gains[_ASSUMED, 1:]),
        Column("presses", "Presses per cell, without mountings", digits=2): presses,
        Column("mountings", "Mountings per cell", digits=2): mountings,
        Column("gain_lossy_percent", "Lossy sensor: change (%)", digits=2): 100 * np.expm1(gains[_LOSSY, 1:]),
    }
    caption = (
        "Change of the contrast by creep as the rig file assumes it (relaxation, sensor_relaxation), and what it takes "
        "to see it (5 % level, 80 % power): presses with a CV of "
        f"{100 * PRESS_CV:g} %, or mountings with an SD of {100 * mounting_sd:g} %. The lossy sensor relaxes "
        f"by {100 * LOSSY_SENSOR:g} %, all specimens by {100 * LOSSY_SPECIMENS:g} %"
    )
    return table_of("stiffness_needed", caption, columns)


def _by_specimen(effect: StiffnessEffect, names: list[str]) -> Table:
    columns: Columns = {
        _CONDITION: np.repeat(names, len(effect.specimens)),
        Column("specimen", "Specimen"): list(effect.specimens) * len(names),
        Column("duration_s", "Duration (s)"): effect.duration_s.T.ravel(),
        Column("slope_mm2_per_n", "Slope (mm²/N)"): effect.slope[0].T.ravel(),
        Column("frame_sum", "Eq. (2) (mm²/N)"): effect.frame_sum.T.ravel(),
        Column("frame_sum_swapped", "Eq. (2), schedules swapped"): effect.frame_sum_swapped.T.ravel(),
    }
    caption = "Elastic bodies: duration, slope of area on force, and equation (2)"
    return table_of("stiffness_specimens", caption, columns)


def _measured(results: StudyResults, effect: StiffnessEffect) -> Table:
    """Contrasts of the scored runs at 0 degrees; no rows without them."""
    soft, stiff = effect.specimens[-1], effect.specimens[0]
    contrast = {
        condition: _medians(results, soft, condition) / _medians(results, stiff, condition)
        for condition in effect.conditions
    }
    known = [condition for condition, (casr, _) in contrast.items() if np.isfinite(casr)]
    columns: Columns = {
        _CONDITION: known,
        Column("casr", "CASR"): [float(contrast[condition][0]) for condition in known],
        Column("frame_sum", "Eq. (2) as printed"): [float(contrast[condition][1]) for condition in known],
    }
    caption = (
        f"The runs of this study at 0°, areas by {results.study.scoring.algorithm}: ratio {soft} : {stiff} of median "
        "CASR, and of the sum of dA/dF over frames"
    )
    return table_of("stiffness_measured", caption, columns)


def _medians(results: StudyResults, specimen: str, condition: str) -> Floats:
    """(2,) median CASR of the presses, and median of the sum over frames of the same areas; NaN without them."""
    runs = results.runs.scores if results.runs else ()
    own = [run for run in runs if (run.specimen, run.condition, run.angle_deg) == (specimen, condition, 0.0)]
    rates = [rate for run in own for rate in run.casr[run.algorithm].tolist() if np.isfinite(rate)]
    sums = [_sum_of(curve) for run in own for curve in run.curves if curve.force_n.size > 1]
    return np.array([np.median(rates), np.median(sums)] if rates and sums else [np.nan, np.nan])


def _sum_of(curve: PressCurve) -> float:
    try:
        return spread_rate(curve.area_mm2, curve.force_n, rule="paper").value
    except InputError:  # a force that does not rise
        return np.nan


def _would_be(effect: StiffnessEffect) -> Table:
    told: dict[str, str] = {}
    if _HUMAN_LIKE in effect.conditions:
        c = effect.conditions.index(_HUMAN_LIKE)
        sums, d = np.exp(effect.contrast(effect.frame_sum)), effect.timing_d
        best, exponent = int(d.argmax()), _exponent(effect)
        told = {
            "CASR counts frames or duration": "Equation (2) as printed does: "
            f"{number(sums[0])} (rigid), {number(sums[c])} (human-like). Presses of equal duration, or a CASR free of "
            "the number of frames, would show it.",
            "Errors of timing dominate": f"Then {_named(effect.conditions[best])} is best (d′ {number(d[best])}; "
            f"human-like {number(d[c])}).",
            "Specimens creep far more than solids do": f"{100 * _WANTED:g} % more contrast needs creep like t to the "
            f"power {number(exponent)}" + (" or more; a liquid has 1." if np.isfinite(exponent) else "."),
            "The skin's contact area depends on stiffness directly": "No such mechanism is known. Control world P1 has "
            "one made up.",
            "Rigid motor and variable stiffness actuator guide the probe differently": "They are different mechanics, "
            "never exchanged. Several mountings of both would show it.",
        }
    columns: Columns = {
        Column("need", "For the paper's claim this would have to be true"): list(told),
        Column("here", "Here"): list(told.values()),
    }
    return table_of("stiffness_would_be", "What would have to be true for the paper's claim", columns)


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


STIFFNESS = Section("stiffness", "Can stiffness help?", _TEXT, _applies, _quantities, _tables, words=_words)
