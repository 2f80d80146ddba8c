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
_WHY = {
    "not shown": "No change beyond the scatter of mountings is shown.",
    "cannot be told": "Specimens were mounted once under each condition.",
}
_VERDICTS = {True: "better", False: "worse", None: "undecided"}


def _quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared, table = found.conditions, found.table
    yield "runs.closest_pair", " ".join(compared.pair)
    for i, name in enumerate(keys(found)):
        yield f"{name}.separation.epsilon2", float(compared.ranks.epsilon2[i])
        yield from with_interval(f"{name}.separation.gap", *ends_of(compared.gaps, i))
        yield f"{name}.separation.cv", float(compared.cv[i])
    for i, other in enumerate(compared.other.tolist()):
        name = f"runs.human_like_against.{table.conditions[other]}.{table.angles_deg[other]:g}"
        yield from with_interval(f"{name}.gap_difference", *ends_of(compared.gap_differences, i))
        yield from with_interval(f"{name}.level_ratio", *ends_of(compared.level_ratio, i))
        yield from with_interval(f"{name}.cv_ratio", *ends_of(compared.cv_ratio, i))
        yield f"{name}.verdict", _VERDICTS[compared.wins(i)]
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
    level, others = f"{100 * compared.confidence:g}%", range(compared.other.size)
    verdicts = [
        _VERDICTS[compared.wins(i)] if np.isfinite(compared.gap_differences.gap[i]) else UNDEFINED for i in others
    ]
    columns: Columns = {
        Column("other", "Human-like (modular) against"): [design_name(table, i) for i in compared.other.tolist()],
        Column("gap_difference", "Gap: difference, in SDs"): [
            interval(*ends_of(compared.gap_differences, i)) for i in others
        ],
        Column("cv_ratio", "CV: ratio"): [interval(*ends_of(compared.cv_ratio, i)) for i in others],
        Column("level_change_percent", "Mean CASR: difference (%)"): [level_change(compared, i) for i in others],
        Column("verdict", "Human-like is"): verdicts,
    }
    caption = f"The human-like condition against every other at the same angle, {level} intervals"
    yield table_of("conditions_compared", caption, columns)
    gaps = [interval(*ends_of(compared.gaps, i)) for i in range(len(table.conditions))]
    each: Columns = {
        DESIGN: design_names(table),
        Column("epsilon2", "ε²_R"): compared.ranks.epsilon2,
        Column("gap", "Gap, in SDs"): gaps,
        Column("cv", "CV of repetitions (%)", 100.0): compared.cv,
    }
    caption = (
        f"How far {listed(compared.specimens)} lie apart; gap between {listed(compared.pair)}, the closest neighbours, "
        f"with {level} interval"
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
        f"{100 * (1 - found.settings.alpha):g}% intervals"
    )
    return table_of("contrasts", caption, columns)


def level_change(compared: ConditionComparison, i: int) -> str:
    """Mean CASR, human-like less other, in percent of the other, with two decimals."""
    ratios = ends_of(compared.level_ratio, i)
    estimate, low, high = (f"{100 * (ratio - 1):+.2f}" for ratio in ratios)
    return UNDEFINED if np.isnan(ratios).any() else f"{estimate} [{low}, {high}]"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    table, look = tested(results).table, looks(results)
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
        f"{table.algorithm} algorithm. Below: how far each human-like press lies from the mean of the rigid ones. "
        f"{BOXES}"
    )
    title = "CASR with rigid and human-like stiffness"
    figure = draw_conditions(panels, unit)
    yield drawing(results, "fig14_conditions", title, caption, f"Median CASR in {unit}/N. {told}.", figure)


_TEXT = """
<p>{{ (said + of_schedules) | join(" ") }}</p>
{{ folded("contrasts", "Contrast of specimens under every condition, tested over mountings") }}
{{ folded("conditions_compared", "Human-like stiffness against every other condition") }}
{{ folded("conditions", "Every condition alone") }}
{{ folded("fig14_conditions", "Figure 14: CASR with the rigid motor and human-like stiffness") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    return {"said": contrast_words(found)[:1], "of_schedules": list(schedule_words(found))}


ACTUATORS = Section(
    "actuators", "Rigid and human-like actuation", _TEXT, of_tests, _quantities, _tables, _drawings, _words
)
