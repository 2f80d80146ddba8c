"""Which stiffness sets the specimens furthest apart? Condition, angle and specimen in one model of the scores."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from emg2vsa.discrimination.contrast import Contrast
from emg2vsa.discrimination.contrast_words import change_percent, schedule_words
from emg2vsa.discrimination.discriminate import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.figures.casr import ConditionBoxes, draw_conditions
from emg2vsa.report import designs
from emg2vsa.report.designs import cells, design_name, ends_of, finite, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, from_quantities, table_of
from emg2vsa.report.wording import UNDEFINED, area_unit, interval, listed
from emg2vsa.shown import words_of
from emg2vsa.statistics.factorial import Factorial

_BEYOND_TWO_SDS = math.erfc(math.sqrt(2))
"""Share of normal values."""
_MEASURES = {"slope": "slope", "frame_sum": "equation (2)"}


def _quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared, table = found.conditions, found.table
    yield "runs.closest_pair", " ".join(compared.pair)
    yield from designs.of_designs(found, {"separation.gap": compared.gaps, "separation.cv": compared.press_sd})
    for i, name in enumerate(_against(found)):
        gap, low, high = ends_of(compared.gap_differences, i)
        yield from with_interval(f"{name}.gap_difference", gap, low, high)
        yield from with_interval(f"{name}.level_ratio", *ends_of(compared.level_ratio, i))
        yield from with_interval(f"{name}.cv_ratio", *ends_of(compared.cv_ratio, i))
        yield f"{name}.verdict", "larger" if low > 0 else "smaller" if high < 0 else "not determined"
    yield from with_interval("runs.mounting_sd_percent", *(100 * value for value in compared.mounting_sd))
    for contrast in found.contrasts:
        yield from _contrast_quantities(contrast, table)


def _against(found: Discrimination) -> list[str]:
    """How quantities of the human-like condition against every other begin."""
    pairs = designs.pairs_of(found.table)
    return ["runs.human_like_against.{}.{:g}".format(*pairs[other]) for other in found.conditions.other]


def _contrast_quantities(contrast: Contrast, table: RunTable) -> Items:
    """``contrast.slope.modular.0.S5_S1`` is the logarithm of the ratio of two specimens, and so on."""
    begin, pairs = f"contrast.{contrast.measure}", ["_".join(pair) for pair in contrast.pairs]
    yield f"{begin}.algorithm", contrast.algorithm
    for d, (condition, angle) in enumerate(designs.pairs_of(table)):
        yield f"{begin}.{condition}.{angle:g}.mountings", int(contrast.mountings[d])
        for k, pair in enumerate(pairs):
            level = contrast.levels.at(d * len(pairs) + k)
            yield from with_interval(f"{begin}.{condition}.{angle:g}.{pair}", *level)
    for i, (one, other, k) in enumerate(zip(contrast.one, contrast.other, contrast.pair, strict=True)):
        name = f"{begin}.{table.conditions[one]}_against_{table.conditions[other]}.{table.angles_deg[one]:g}.{pairs[k]}"
        yield from with_interval(f"{name}.change", *contrast.changes.at(i))
        yield from fields_of(name, contrast.changes, "df", "p", at=i)
        yield from fields_of(name, contrast, "p_adjusted", at=i)
        yield f"{name}.verdict", contrast.verdicts[i]


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    compared, table = found.conditions, found.table
    level = f"{100 * compared.confidence:g} %"
    against: Columns = {
        Column("other", "Human-like (modular) against"): [design_name(table, i) for i in compared.other.tolist()],
        Column("gap_difference", "Distance: difference, in SDs"): cells(q, _against(found), "gap_difference"),
        Column("cv_ratio", "SD of a press: ratio"): cells(q, _against(found), "cv_ratio"),
        Column("level_change_percent", "Mean CASR: difference (%)"): [
            _level_change(*ends_of(compared.level_ratio, i)) for i in range(compared.other.size)
        ],
    }
    caption = f"The human-like condition against every other at the same angle, {level} intervals over mountings"
    yield table_of("conditions_compared", caption, against)
    every = [(contrast, i) for contrast in found.contrasts for i in range(contrast.pair.size)]
    rows: Columns = {
        Column("of", "CASR"): [_MEASURES[c.measure] for c, _ in every],
        Column("pair", "Pair"): [" : ".join(c.pairs[c.pair[i]]) for c, i in every],
        Column("compared", "Condition, against"): [
            f"{design_name(table, c.one[i])}, against {table.conditions[c.other[i]]}" for c, i in every
        ],
        Column("change", "Contrast: change"): [change_percent(c.changes, i) for c, i in every],
        Column("p", "p"): [float(c.changes.p[i]) for c, i in every],
        Column("p_adjusted", "p, corrected"): [float(c.p_adjusted[i]) for c, i in every],
        Column("df", "df"): [float(c.changes.df[i]) for c, i in every],
        Column("verdict", "The condition"): [c.verdicts[i] for c, i in every],
    }
    fewest = min((int(contrast.mountings.min()) for contrast in found.contrasts), default=0)
    over = f"{fewest} mountings of each cell" if fewest > 1 else "cells mounted once, their scatter assumed"
    caption = (
        f"Contrast, the ratio of CASR of two specimens, by condition; {over}, "
        f"{level} intervals; p corrected by the order of tests (human-like against rigid "
        "first) and by Holm within its last step"
    )
    yield table_of("contrasts", caption, rows)


def _level_change(*ratio: float) -> str:
    """Mean CASR, human-like less other, in percent of the other, with two decimals."""
    estimate, low, high = (f"{100 * (each - 1):+.2f}" for each in ratio)
    return UNDEFINED if "nan" in low else f"{estimate} [{low}, {high}]"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    found, look = tested(results), designs.looks(results)
    table, compared = found.table, found.conditions
    values, unit, far = table.casr[table.algorithm], area_unit(table.area_unit), {(d, s) for d, s, _ in compared.far}
    panels = []
    for rigid in table.of_condition(RIGID):
        if (human := table.design(HUMAN_LIKE, angle := float(table.angles_deg[rigid]))) >= 0:
            every = zip(range(len(table.specimens)), table.specimens, values[rigid], values[human], strict=True)
            boxes = [ConditionBoxes(n, look[n], finite(r), finite(h), (human, s) in far) for s, n, r, h in every]
            panels.append((f"{angle:g}°", boxes))
    if not panels:
        return
    fewest, most = compared.mountings
    sd = compared.mounting_sd[0] if most > 1 else compared.assumed_sd
    reach = 100 * np.expm1(2 * sd * np.sqrt(2 / max(fewest, 1)))
    mounted = "one mounting" if most == 1 else f"{most if fewest == most else f'{fewest} to {most}'} mountings"
    caption = (
        f"Fig. 14. CASR ({table.algorithm} algorithm); each box holds the presses of {mounted}. Below: human-like "
        "presses less the rigid mean; grey: two SDs of a difference of two means; rings lie beyond."
    )
    told = designs.medians_said(
        (title, [(f"{b.name} {which}", v) for b in own for which, v in (("rigid", b.rigid), ("human", b.human_like))])
        for title, own in panels
    )
    told = f"Median CASR in {unit}/N. {told}. Beyond two SDs: {_beyond(found) or 'none'}."
    figure = draw_conditions(panels, unit, reach)
    title = "CASR with rigid and human-like stiffness"
    yield designs.drawing(results, "fig14_conditions", title, caption, told, figure)


def _beyond(found: Discrimination) -> str:
    """The cells of figure 14 that differ by more than two SDs of a difference of two means."""
    table = found.table
    return listed([
        f"{table.specimens[s]} at {table.angles_deg[d]:g}° ({100 * np.expm1(change):+.1f} %)"
        for d, s, change in found.conditions.far
    ])  # fmt: skip


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    compared = found.conditions
    sds = [100 * value for value in compared.mounting_sd]
    return {
        "schedules": list(schedule_words(found)),
        "sd": interval(*sds) if sds[0] == sds[0] else "",
        "between": "mountings" if compared.mountings[1] > 1 else "conditions of the same specimen and angle",
        "assumed": 100 * compared.assumed_sd,
        "beyond": _beyond(found),
        "chance": f"{_BEYOND_TWO_SDS * compared.cells:.1f} of {compared.cells}",
    }


_TEXT = """
{{ figure("fig14_conditions") }}
<p>{% if sd %}Mountings scatter by {{ sd }} % (SD, from {{ between }}); {{ assumed | number(2) }} % is assumed of
specimens mounted once. {% endif %}
{% if beyond %}Conditions differ by more than two SDs of a difference of two means for {{ beyond }}; chance alone is
expected to make {{ chance }} do so. {% endif %}
{{ schedules | join(" ") }}</p>
{{ folded("contrasts", "Contrast of specimens under every condition, tested over mountings") }}
{{ folded("conditions_compared", "Human-like stiffness against every other condition") }}
"""

ACTUATORS = Section(
    "actuators", "Rigid and human-like actuation", _TEXT, of_tests, _quantities, _tables, _drawings, _words
)


def _effects(results: StudyResults) -> list[tuple[str, Factorial, int, str]]:
    """Score, model, place of every effect, and how its quantities begin."""
    found = results.runs.discrimination if results.runs else None
    models = (("area", "start_area", found.factors.area), ("CASR", "casr", found.factors.casr)) if found else ()
    return [
        (score, model, i, f"runs.factors.{key}.{effect.replace(' × ', '-')}")
        for score, key, model in models
        if model is not None
        for i, effect in enumerate(model.effects)
    ]


def _effect_quantities(results: StudyResults) -> Items:
    for _, model, i, name in _effects(results):
        yield from fields_of(name, model, "f", "df", "p", "eta2", at=i)
        yield from with_interval(f"{name}.omega2", model.omega2[i], model.low[i], model.high[i])


def _effect_tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    every, head = _effects(results), words_of(Factorial)
    names = [name for *_, name in every]
    rows: Columns = {
        Column("score", "Score"): [score for score, *_ in every],
        Column("effect", "Effect"): [model.effects[i] for _, model, i, _ in every],
        **from_quantities(q, names, {Column(key, *head[key]): key for key in ("f", "df")}),
        Column("error_df", "Error df"): [model.error_df for _, model, *_ in every],
        **from_quantities(q, names, {Column(key, *head[key]): key for key in ("p", "eta2", "omega2")}),
        Column("omega2_low", "ω² low"): [q[f"{name}.omega2.low"] for name in names],
        Column("omega2_high", "ω² high"): [q[f"{name}.omega2.high"] for name in names],
    }
    caption = "Condition, angle and specimen in one model of ln(score), type II (means of mountings on the rig)"
    yield table_of("factors", caption, rows)


_EFFECTS_TEXT = """
<p>One model of the logarithm of each score tests condition, angle and specimen together, because they multiply it.</p>
{{ folded("factors", "Effects of condition, angle and specimen") }}
"""

FACTORS = Section(
    "factors", "Condition, angle and specimen", _EFFECTS_TEXT, lambda results: bool(_effects(results)),
    _effect_quantities, _effect_tables,
)  # fmt: skip
