"""Rigid, human-like and constant stiffness: which sets the specimens furthest apart?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.discrimination.conditions import ConditionComparison
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr_rates import ConditionBoxes, draw_conditions
from emg2vsa.report.designs import (
    BOXES,
    DESIGN,
    design_name,
    design_names,
    drawing,
    finite,
    gap_of,
    interval_of,
    keys,
    looks,
    median_said,
    of_tests,
    tested,
    with_interval,
)
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Table, rows_of
from emg2vsa.report.wording import UNDEFINED, area_unit, interval, listed

_VERDICTS = {True: "better", False: "worse", None: "undecided"}


def _quantities(results: StudyResults) -> Items:
    found = tested(results)
    compared, table = found.conditions, found.table
    yield "runs.closest_pair", " ".join(compared.pair)
    for i, name in enumerate(keys(found)):
        yield f"{name}.separation.epsilon2", float(compared.ranks.epsilon2[i])
        yield from with_interval(f"{name}.separation.gap", *gap_of(compared.gaps, i))
        yield f"{name}.separation.cv", float(compared.cv[i])
    for i, other in enumerate(compared.other.tolist()):
        name = f"runs.human_like_against.{table.conditions[other]}.{table.angles_deg[other]:g}"
        yield from with_interval(f"{name}.gap_difference", *gap_of(compared.gap_differences, i))
        for key, ratio in (("level_ratio", compared.level_ratio), ("cv_ratio", compared.cv_ratio)):
            yield from with_interval(f"{name}.{key}", *interval_of(ratio, i))
        yield f"{name}.verdict", _VERDICTS[compared.wins(i)]


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    compared, table = found.conditions, found.table
    level, others = f"{100 * compared.confidence:g}%", range(compared.other.size)
    columns = (
        Column("other", "Human-like (modular) against"), Column("gap_difference", "Gap: difference, in SDs"),
        Column("cv_ratio", "CV: ratio"), Column("level_change_percent", "Mean CASR: difference (%)"),
        Column("verdict", "Human-like is"),
    )  # fmt: skip
    rows = rows_of(
        {
            "other": [design_name(table, other) for other in compared.other.tolist()],
            "gap_difference": [interval(*gap_of(compared.gap_differences, i)) for i in others],
            "cv_ratio": [interval(*interval_of(compared.cv_ratio, i)) for i in others],
            "level_change_percent": [level_change(compared, i) for i in others],
            "verdict": [
                _VERDICTS[compared.wins(i)] if np.isfinite(compared.gap_differences.gap[i]) else UNDEFINED
                for i in others
            ],
        }
    )
    caption = f"The human-like condition against every other at the same angle, {level} intervals"
    yield Table("conditions_compared", caption, columns, rows)
    each = (
        DESIGN, Column("epsilon2", "ε²_R"), Column("gap", "Gap, in SDs"), Column("cv", "CV of repetitions (%)", 100.0),
    )  # fmt: skip
    rows = rows_of(
        {
            "design": design_names(table),
            "epsilon2": compared.ranks.epsilon2,
            "gap": [interval(*gap_of(compared.gaps, i)) for i in range(len(table.conditions))],
            "cv": compared.cv,
        }
    )
    caption = (
        f"How far {listed(compared.specimens)} lie apart; gap between {listed(compared.pair)}, the closest neighbours, "
        f"with {level} interval"
    )
    yield Table("conditions", caption, each, rows)


def level_change(compared: ConditionComparison, i: int) -> str:
    """Mean CASR, human-like less other, in percent of the other, with two decimals."""
    ratios = interval_of(compared.level_ratio, i)
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
<p>A gap is Hedges' g, the difference of mean CASR of two specimens over the SD of their presses; the pair is chosen
once over all conditions. {% if runs.simulated %}In the simulated world the contact area follows from force alone, so
that the actuator changes only how far the force steps from frame to frame. {% endif %}Every condition is a mounting of
its own: the interval of the difference assumes an SD of {{ mounting_sd_percent | number(2) }} % of CASR from mounting
to mounting, and those of the gaps do not include it.</p>
{{ folded("conditions_compared", "Human-like stiffness against every other condition") }}
{{ folded("conditions", "Every condition alone") }}
{{ figure("fig14_conditions") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"mounting_sd_percent": results.study.calibration.mounting_sd_percent}


ACTUATORS = Section(
    "actuators", "Rigid and human-like actuation", _TEXT, of_tests, _quantities, _tables, _drawings, words=_words
)
