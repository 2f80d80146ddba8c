"""Can stiffness help? What that of the actuator can do to CASR by contact mechanics, by frames and by timing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import HUMAN_LIKE
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.stiffness_effect import LOSSY_SENSOR, LOSSY_SPECIMENS, PRESS_CV, StiffnessEffect, replicates_needed

_MATERIALS = ("elastic", "assumed", "lossy_sensor")
_ASSUMED = 1
_WANTED = 0.2
"A gain of contrast that would be plain to see, as a share."


def _effect(results: StudyResults) -> StiffnessEffect:
    assert results.stiffness is not None
    return results.stiffness


def _gains(effect: StiffnessEffect) -> Floats:
    """(M, C) contrast of the softest specimen against that under the rigid motor, difference of logarithms."""
    contrast = effect.contrast(effect.rate)
    return np.asarray(contrast - contrast[:, :1])


def _ways(results: StudyResults) -> Columns:
    """(C,) what stiffness can do under each condition; the key of a column ends the name of its quantity."""
    effect = _effect(results)
    stiff, second, soft = effect.specimens[0], effect.specimens[1], effect.specimens[-1]
    of_creep, mounting_sd = _gains(effect)[_ASSUMED], results.study.calibration.mounting_sd_percent / 100
    _, assumed, lossy = 100 * np.expm1(_gains(effect))
    sums, swapped = effect.frame_sum, effect.frame_sum_swapped
    pair, neighbours, creep = f"{soft} : {stiff}", f"{second} : {stiff}", "contrast_gain.{}_percent"
    found = (
        (creep.format("assumed"), f"Creep: change of {pair} (%)", "gain_percent", assumed),
        ("presses_needed", "to be seen: presses per cell", "presses", replicates_needed(of_creep, PRESS_CV)),
        ("mountings_needed", "or mountings", "mountings", replicates_needed(of_creep, mounting_sd)),
        (creep.format("lossy_sensor"), "Lossy sensor: change (%)", "gain_lossy_percent", lossy),
        ("frame_sum.contrast", f"Eq. (2): {pair}", "frame_sum", np.exp(effect.contrast(sums))),
        ("frame_sum.neighbour", neighbours, "neighbour", np.exp(effect.contrast(sums, 1))),
        ("frame_sum.neighbour_swapped", "swapped", "neighbour_swapped", np.exp(effect.contrast(swapped, 1))),
        ("slope.neighbour_swapped", "by mean rate", "slope_swapped", np.exp(effect.contrast(effect.rate_swapped, 1))),
        ("timing.d", f"Timing: d′ of {stiff} and {second}", "timing_d", effect.timing_d),
    )
    return {Column(key, head, name=name): np.asarray(values) for key, head, name, values in found}


def _quantities(results: StudyResults) -> Items:
    effect, contrast = _effect(results), np.exp(_effect(results).contrast(_effect(results).rate))
    ways = {column.key: np.asarray(values, dtype=np.float64) for column, values in _ways(results).items()}
    ways |= {f"timing.{name}.cv": cv for name, cv in zip(effect.pair, effect.timing_cv, strict=True)}
    ways |= {f"contrast.{name}": each for name, each in zip(_MATERIALS, contrast, strict=True)}
    ways |= {"contrast_gain.elastic_percent": 100 * np.expm1(_gains(effect)[0])}
    yield "stiffness.pair", " ".join(effect.pair)
    for c, condition in enumerate(effect.conditions):
        name = f"stiffness.{condition}"
        for k, own in enumerate(effect.specimens):
            yield from fields_of(f"{name}.{own}", effect, "duration_s", "frame_sum", "frame_sum_swapped", at=(k, c))
        yield from ((f"{name}.{k}", float(values[c])) for k, values in ways.items() if c or not k.endswith("needed"))
    yield "stiffness.timing.best", effect.conditions[int(effect.timing_d.argmax())]
    swaps = False
    if HUMAN_LIKE in effect.conditions:
        c = effect.conditions.index(HUMAN_LIKE)
        swaps = bool(ways["frame_sum.neighbour"][c] > 1 > ways["frame_sum.neighbour_swapped"][c])
        yield "stiffness.modular.creep_exponent_needed", effect.creep_exponent(_WANTED, c)
    # of the two stiffest specimens, when human-like schedules are swapped
    yield "stiffness.frame_sum.swaps_order", swaps


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    """By condition what stiffness can do, in theory and in the runs."""
    effect = _effect(results)
    stiff, soft = effect.specimens[0], effect.specimens[-1]
    by_condition: Columns = {
        Column("condition", "Condition"): [
            f"constant, {name.removeprefix('all-')} % for all" if name.startswith("all-") else name
            for name in effect.conditions
        ],
        Column("duration_stiff_s", f"{stiff} lasts (s)"): effect.duration_s[0],
        Column("duration_soft_s", f"{soft} lasts (s)"): effect.duration_s[-1],
        **_ways(results),
    }
    caption = (
        f"What stiffness can do at 0° by contact mechanics. Creep as the rig file assumes it (lossy sensor: it relaxes "
        f"by {100 * LOSSY_SENSOR:g} %, specimens by {100 * LOSSY_SPECIMENS:g} %); to be seen at 5 % and a power of "
        f"80 %, with an SD of {100 * PRESS_CV:g} % of presses or "
        f"{results.study.calibration.mounting_sd_percent:g} % of mountings. Swapped: the stiffest specimen is pressed "
        "with the schedule of the softest, and so on"
    )
    yield table_of("stiffness_effect", caption, by_condition)


_TEXT = """
<p>By contact mechanics the actuator's stiffness changes only how long a press lasts. CASR follows by creep (contrast:
{{ creep | number(2) }} % at most{% if creep < mountings %}, less than mountings scatter{% endif %}), by the frames that
equation (2) sums, and by the camera's timing.
{% if q["stiffness.frame_sum.swaps_order"] %}
By equation (2), swapped schedules swap {{ pair[0] }} and {{ pair[1] }}.
{% endif %}
{% if softest %}Against errors of timing the softest constant stiffness is best.{% endif %}</p>
{{ folded("stiffness_effect", "What stiffness can do, by condition") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    effect = _effect(results)
    return {
        "creep": float(100 * np.abs(np.expm1(_gains(effect)[_ASSUMED])).max()),
        "mountings": results.study.calibration.mounting_sd_percent,
        "softest": int(effect.timing_d.argmax()) == int(effect.duration_s.sum(axis=0).argmax()),
        "pair": effect.pair,
    }


STIFFNESS = Section(
    "stiffness", "Can stiffness help?", _TEXT, lambda results: results.stiffness is not None, _quantities, _tables,
    words=_words,
)  # fmt: skip
