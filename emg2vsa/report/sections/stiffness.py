"""Can stiffness help? What that of the actuator can do to CASR by contact mechanics, by frames and by timing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from casr.errors import InputError
from casr.spread import spread_rate
from emg2vsa.arrays import Floats
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, columns, table_of
from emg2vsa.run_scores.product import PressCurve
from emg2vsa.stiffness_effect import LOSSY_SENSOR, LOSSY_SPECIMENS, PRESS_CV, StiffnessEffect, replicates_needed

_HUMAN_LIKE = "modular"
_MATERIALS = ("elastic", "assumed", "lossy_sensor")
_ASSUMED = 1
_WANTED = 0.2
"A gain of contrast that would be plain to see, as a share."


def _effect(results: StudyResults) -> StiffnessEffect:
    assert results.stiffness is not None
    return results.stiffness


def _gains(effect: StiffnessEffect) -> Floats:
    """(M, C) contrast of the softest specimen against that under the rigid motor, difference of logarithms."""
    contrast = effect.contrast(effect.slope)
    return np.asarray(contrast - contrast[:, :1])


def _neighbours(effect: StiffnessEffect, sums: Floats) -> Floats:
    """(C,) ratio of the second stiffest specimen to the stiffest."""
    return np.asarray(np.exp(effect.contrast(sums, 1)))


def _ways(results: StudyResults) -> Columns:
    """(C,) what stiffness can do under each condition; the key of a column ends the name of its quantity."""
    effect = _effect(results)
    stiff, second, soft = effect.specimens[0], effect.specimens[1], effect.specimens[-1]
    of_creep, mounting_sd = _gains(effect)[_ASSUMED], results.study.calibration.mounting_sd_percent / 100
    gains = dict(zip(_MATERIALS, 100 * np.expm1(_gains(effect)), strict=True))
    pair, creep = f"{soft} : {stiff}", "contrast_gain.{}_percent"
    return {
        Column(creep.format("assumed"), f"Creep: change of {pair} (%)", 1, 2, "gain_percent"): gains["assumed"],
        Column("presses_needed", "to be seen: presses per cell", 1, 2, "presses"): replicates_needed(
            of_creep, PRESS_CV
        ),
        Column("mountings_needed", "or mountings", 1, 2, "mountings"): replicates_needed(of_creep, mounting_sd),
        Column(creep.format("lossy_sensor"), "Lossy sensor: change (%)", 1, 2, "gain_lossy_percent"): gains[
            "lossy_sensor"
        ],
        Column("frame_sum.contrast", f"Eq. (2): {pair}", name="frame_sum"): np.exp(effect.contrast(effect.frame_sum)),
        Column("frame_sum.neighbour", f"{second} : {stiff}", name="neighbour"): _neighbours(effect, effect.frame_sum),
        Column("frame_sum.neighbour_swapped", "schedules swapped", name="neighbour_swapped"): _neighbours(
            effect, effect.frame_sum_swapped
        ),
        Column("slope.neighbour_swapped", "by slope, swapped", name="slope_swapped"): _neighbours(
            effect, effect.slope_swapped
        ),
        Column("timing.d", f"Timing: d′ of {stiff} and {second}", 1, 2, "timing_d"): effect.timing_d,
    }


def _quantities(results: StudyResults) -> Items:
    effect, contrast = _effect(results), np.exp(_effect(results).contrast(_effect(results).slope))
    ways = {column.key: np.asarray(values, dtype=np.float64) for column, values in _ways(results).items()}
    ways |= {f"timing.{name}.cv": cv for name, cv in zip(effect.pair, effect.timing_cv, strict=True)}
    ways |= {f"contrast.{name}": each for name, each in zip(_MATERIALS, contrast, strict=True)}
    ways |= {"contrast_gain.elastic_percent": 100 * np.expm1(_gains(effect)[0])}
    yield "stiffness.pair", " ".join(effect.pair)
    for c, condition in enumerate(effect.conditions):
        name = f"stiffness.{condition}"
        for k, specimen in enumerate(effect.specimens):
            each = ("duration_s", "frame_sum", "frame_sum_swapped")
            yield from fields_of(f"{name}.{specimen}", effect, *each, at=(k, c))
        yield from ((f"{name}.{k}", float(values[c])) for k, values in ways.items() if c or not k.endswith("needed"))
    yield "stiffness.timing.best", effect.conditions[int(effect.timing_d.argmax())]
    yield "stiffness.frame_sum.swaps_order", _swaps(effect)
    if _HUMAN_LIKE in effect.conditions:
        exponent = effect.creep_exponent(_WANTED, effect.conditions.index(_HUMAN_LIKE))
        yield "stiffness.modular.creep_exponent_needed", exponent


def _swaps(effect: StiffnessEffect) -> bool:
    """Whether the two stiffest specimens change places by equation (2) when human-like schedules are swapped."""
    if _HUMAN_LIKE not in effect.conditions:
        return False
    c = effect.conditions.index(_HUMAN_LIKE)
    return bool(_neighbours(effect, effect.frame_sum)[c] > 1 > _neighbours(effect, effect.frame_sum_swapped)[c])


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    """By condition what stiffness can do, in theory and in the runs; and every specimen."""
    effect = _effect(results)
    stiff, soft = effect.specimens[0], effect.specimens[-1]
    names = [_named(condition) for condition in effect.conditions]
    here = np.array([_medians(results, soft, c) / _medians(results, stiff, c) for c in effect.conditions])
    by_condition: Columns = {
        Column("condition", "Condition"): names,
        Column("duration_stiff_s", f"{stiff} lasts (s)"): effect.duration_s[0],
        Column("duration_soft_s", f"{soft} lasts (s)"): effect.duration_s[-1],
        **_ways(results),
        Column("casr_here", f"These runs: CASR, {soft} : {stiff}"): here[:, 0],
        Column("frame_sum_here", "by eq. (2) as printed"): here[:, 1],
    }
    caption = (
        f"What stiffness can do at 0° by contact mechanics. Creep as the rig file assumes it (lossy sensor: it relaxes "
        f"by {100 * LOSSY_SENSOR:g} %, specimens by {100 * LOSSY_SPECIMENS:g} %); to be seen at 5 % and a power of "
        f"80 %, with an SD of {100 * PRESS_CV:g} % of presses or "
        f"{results.study.calibration.mounting_sd_percent:g} % of mountings. Swapped: the stiffest specimen is pressed "
        "with the schedule of the softest, and so on. These runs: ratio of medians"
    )
    yield table_of("stiffness_effect", caption, by_condition)
    k, c = np.tile(range(len(effect.specimens)), len(names)), np.repeat(range(len(names)), len(effect.specimens))
    each: Columns = {
        Column("condition", "Condition"): [names[i] for i in c],
        Column("specimen", "Specimen"): [effect.specimens[i] for i in k],
        **columns(effect, "duration_s", at=(k, c)),
        Column("slope_mm2_per_n", "Slope (mm²/N)"): effect.slope[0, k, c],
        **columns(effect, "frame_sum", "frame_sum_swapped", at=(k, c)),
    }
    caption = "Elastic bodies: duration, slope of area on force, and equation (2)"
    yield table_of("stiffness_specimens", caption, each)


def _named(condition: str) -> str:
    return f"constant, {condition.removeprefix('all-')} % for all" if condition.startswith("all-") else condition


def _medians(results: StudyResults, specimen: str, condition: str) -> Floats:
    """(2,) median CASR of the presses at 0 degrees, and of the sum over frames of the same areas; NaN without them."""
    runs = results.runs.scores if results.runs else ()
    own = [run for run in runs if (run.specimen, run.condition, run.angle_deg) == (specimen, condition, 0.0)]
    rates: Sequence[float] = [rate for run in own for rate in run.casr[run.algorithm].tolist() if np.isfinite(rate)]
    sums = [_sum_of(curve) for run in own for curve in run.curves if curve.force_n.size > 1]
    return np.array([np.median(rates), np.median(sums)] if rates and sums else [np.nan, np.nan])


def _sum_of(curve: PressCurve) -> float:
    try:
        return spread_rate(curve.area_mm2, curve.force_n, rule="paper").value
    except InputError:  # a force that does not rise
        return np.nan


_TEXT = """
<p>By contact mechanics the actuator's stiffness changes only how long a press lasts. CASR follows by creep (contrast:
{{ creep | number(2) }} % at most{% if creep < mountings %}, less than mountings scatter,
{{ mountings | number(2) }} %{% endif %}), by the frames that equation (2) sums, and by the camera's timing.
{% if swaps %}By equation (2), swapped schedules swap {{ pair[0] }} and {{ pair[1] }}. {% endif %}
{% if softest %}Against errors of timing the softest constant stiffness is best.{% endif %}</p>
{{ folded("stiffness_effect", "What stiffness can do, by condition") }}
{{ folded("stiffness_specimens", "What stiffness can do, by specimen") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    effect = _effect(results)
    return {
        "creep": float(100 * np.abs(np.expm1(_gains(effect)[_ASSUMED])).max()),
        "mountings": results.study.calibration.mounting_sd_percent,
        "swaps": _swaps(effect),
        "softest": int(effect.timing_d.argmax()) == int(effect.duration_s.sum(axis=0).argmax()),
        "pair": effect.pair,
    }


STIFFNESS = Section(
    "stiffness", "Can stiffness help?", _TEXT, lambda results: results.stiffness is not None, _quantities, _tables,
    words=_words,
)  # fmt: skip
