"""Rigid, human-like and constant stiffness: which sets the specimens furthest apart?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.discrimination.conditions import ConditionComparison
from emg2vsa.discrimination.contrast import Contrast
from emg2vsa.discrimination.contrast_words import change_percent, contrast_words, schedule_words
from emg2vsa.discrimination.discriminate import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.figures.casr import ConditionBoxes, draw_conditions
from emg2vsa.report.designs import (
    BOXES,
    DESIGN,
    design_name,
    design_names,
    drawing,
    ends_of,
    finite,
    keys,
    looks,
    median_said,
    of_tests,
    tested,
)
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import UNDEFINED, area_unit, interval, listed

_MEASURES = {"slope": "slope", "frame_sum": "equation (2)"}


def _verdict(low: float, high: float) -> str:
    return "larger" if low > 0 else "smaller" if high < 0 else "not determined"


def _quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared, table = found.conditions, found.table
    yield "runs.closest_pair", " ".join(compared.pair)
    for i, name in enumerate(keys(found)):
        yield from with_interval(f"{name}.separation.gap", *ends_of(compared.gaps, i))
        yield f"{name}.separation.cv", float(compared.press_sd[i])
    for i, other in enumerate(compared.other.tolist()):
        name = f"runs.human_like_against.{table.conditions[other]}.{table.angles_deg[other]:g}"
        yield from with_interval(f"{name}.gap_difference", *ends_of(compared.gap_differences, i))
        yield from with_interval(f"{name}.level_ratio", *ends_of(compared.level_ratio, i))
        yield from with_interval(f"{name}.cv_ratio", *ends_of(compared.cv_ratio, i))
        yield f"{name}.verdict", _verdict(*ends_of(compared.gap_differences, i)[1:])
    yield from with_interval("runs.mounting_sd_percent", *(100 * value for value in compared.mounting_sd))
    for contrast in found.contrasts:
        yield from _contrast_quantities(contrast, table)


def _contrast_quantities(contrast: Contrast, table: RunTable) -> Items:
    """``contrast.slope.modular.0.S5_S1`` is the logarithm of the ratio of two specimens, and so on."""
    begin, pairs = f"contrast.{contrast.measure}", ["_".join(pair) for pair in contrast.pairs]
    designs = [f"{c}.{a:g}" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]
    yield f"{begin}.algorithm", contrast.algorithm
    for d, design in enumerate(designs):
        yield f"{begin}.{design}.mountings", int(contrast.mountings[d])
        for k, pair in enumerate(pairs):
            yield from with_interval(f"{begin}.{design}.{pair}", *contrast.levels.at(d * len(pairs) + k))
    for i, (one, other, k) in enumerate(zip(contrast.one, contrast.other, contrast.pair, strict=True)):
        name = f"{begin}.{table.conditions[one]}_against_{table.conditions[other]}.{table.angles_deg[one]:g}.{pairs[k]}"
        yield from with_interval(f"{name}.change", *contrast.changes.at(i))
        yield f"{name}.df", float(contrast.changes.df[i])
        yield f"{name}.p", float(contrast.changes.p[i])
        yield f"{name}.p_adjusted", float(contrast.p_adjusted[i])
        yield f"{name}.verdict", contrast.verdicts[i]


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    compared, table = found.conditions, found.table
    level, others = f"{100 * compared.confidence:g} %", range(compared.other.size)
    columns: Columns = {
        Column("other", "Human-like (modular) against"): [design_name(table, i) for i in compared.other.tolist()],
        Column("gap_difference", "Distance: difference, in SDs"): [
            interval(*ends_of(compared.gap_differences, i)) for i in others
        ],
        Column("cv_ratio", "SD of a press: ratio"): [interval(*ends_of(compared.cv_ratio, i)) for i in others],
        Column("level_change_percent", "Mean CASR: difference (%)"): [level_change(compared, i) for i in others],
    }
    caption = f"The human-like condition against every other at the same angle, {level} intervals over mountings"
    yield table_of("conditions_compared", caption, columns)
    each: Columns = {
        DESIGN: design_names(table),
        Column("gap", "Distance, in SDs"): [interval(*ends_of(compared.gaps, i)) for i in range(len(table.conditions))],
        Column("cv", "SD of a press (%)", 100.0): compared.press_sd,
    }
    caption = (
        f"Distance of {listed(compared.pair)}, the neighbours that differ least in stiffness: mean ln CASR over "
        f"mountings, in SDs of a press of one mounting, with {level} interval"
    )
    yield table_of("conditions", caption, each)
    yield _contrast_table(found)


def _contrast_table(found: Discrimination) -> Table:
    """Contrasts under every condition against every other that it is compared with."""
    every = [(contrast, i) for contrast in found.contrasts for i in range(contrast.pair.size)]
    conditions = found.table.conditions
    columns: Columns = {
        Column("of", "CASR"): [_MEASURES[c.measure] for c, _ in every],
        Column("pair", "Pair"): [" : ".join(c.pairs[c.pair[i]]) for c, i in every],
        Column("compared", "Condition, against"): [
            f"{design_name(found.table, c.one[i])}, against {conditions[c.other[i]]}" for c, i in every
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
        f"{100 * (1 - found.settings.alpha):g}% intervals; p corrected by the order of tests (human-like against rigid "
        "first) and by Holm within its last step"
    )
    return table_of("contrasts", caption, columns)


def level_change(compared: ConditionComparison, i: int) -> str:
    """Mean CASR, human-like less other, in percent of the other, with two decimals."""
    estimate, low, high = (f"{100 * (ratio - 1):+.2f}" for ratio in ends_of(compared.level_ratio, i))
    return UNDEFINED if "nan" in low else f"{estimate} [{low}, {high}]"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    found, look = tested(results), looks(results)
    table = found.table
    values, unit = table.casr[table.algorithm], area_unit(table.area_unit)
    panels = [
        (
            f"{table.angles_deg[rigid]:g}°",
            [
                ConditionBoxes(name, look[name], finite(values[rigid, j]), finite(values[human, j]))
                for j, name in enumerate(table.specimens)
            ],
        )
        for rigid in table.of_condition(RIGID)
        if (human := table.design(HUMAN_LIKE, float(table.angles_deg[rigid]))) >= 0
    ]
    if not panels:
        return
    told = "; ".join(
        f"{title}: " + ", ".join(f"{b.name} {median_said(b.rigid)} and {median_said(b.human_like)}" for b in boxes)
        for title, boxes in panels
    )
    caption = (
        f"Fig. 14. CASR with the rigid motor (left, hollow) and human-like stiffness (right, filled) by the "
        f"{table.algorithm} algorithm. Each box is {_mountings_said(found)}. Below: how far each human-like press lies "
        f"from the mean of the rigid ones. {BOXES}"
    )
    title = "CASR with rigid and human-like stiffness"
    figure = draw_conditions(panels, unit)
    yield drawing(results, "fig14_conditions", title, caption, f"Median CASR in {unit}/N. {told}.", figure)


_TEXT = """
<p>{{ (said + of_schedules + scatter) | join(" ") }}</p>
{{ folded("contrasts", "Contrast of specimens under every condition, tested over mountings") }}
{{ folded("conditions_compared", "Human-like stiffness against every other condition") }}
{{ folded("conditions", "Every condition alone") }}
{{ folded("fig14_conditions", "Figure 14: CASR with the rigid motor and human-like stiffness") }}
"""


def _mountings_said(found: Discrimination) -> str:
    fewest, most = (int(n) for n in found.conditions.mountings)
    return "one mounting" if most == 1 else f"{fewest} mountings" if fewest == most else f"{fewest} to {most} mountings"


def _scatter_said(found: Discrimination) -> Iterator[str]:
    """What the runs imply of mountings, and the cells of figure 14 that differ by more than two SDs of a mounting."""
    compared, table = found.conditions, found.table
    estimate, low, high = (100 * value for value in compared.mounting_sd)
    if estimate == estimate:
        of = "mountings" if compared.mountings[1] > 1 else "conditions of the same specimen and angle"
        yield (
            f"Scatter between {of} implies an SD of {interval(estimate, low, high)} % from mounting to mounting; "
            f"assumed where specimens were mounted once: {100 * compared.assumed_sd:g} %."
        )
    marked = [
        f"{table.specimens[s]} at {table.angles_deg[d]:g}° ({100 * np.expm1(change):+.1f} %)"
        for d, s, change in compared.far
    ]
    if marked:
        yield (
            "Under human-like stiffness CASR differs from that under the rigid motor by more than two SDs of "
            f"a cell's mean on {listed(marked)}. A difference of two cells has 1.4 of them by chance."
        )


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    return {
        "said": contrast_words(found)[:1], "of_schedules": list(schedule_words(found)),
        "scatter": list(_scatter_said(found)),
    }  # fmt: skip


ACTUATORS = Section(
    "actuators", "Rigid and human-like actuation", _TEXT, of_tests, _quantities, _tables, _drawings, _words
)
