"""One table per hypothesis of section IV.B: the paper's test, its companion, the effect, does the verdict change?"""

from __future__ import annotations

import numpy as np

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, TARGET, Hypotheses
from emg2vsa.report.companion_rows import Row, companion_table, group_rows, normality_rows, pair_rows, variance_row
from emg2vsa.report.people_rows import equality_rows, over_people_rows
from emg2vsa.report.table import Column, Table
from emg2vsa.report.verdicts import how_many
from emg2vsa.report.wording import bounded
from emg2vsa.stats.power import power_table

_CAPTIONS = {
    "normality": "Gaussian clusters: the paper's test beside its companions",
    "participants": "Equal participants: the paper's test beside its companions",
    "specimens": "Different specimens: the paper's test beside its companions",
    "pairs": "Different pairs of specimens: the paper's test beside its companions",
    "power": "Sample size: the paper's computation beside others",
}
_PLANNED = "Sample size: 14 people by ten measurements"


def verdict_tables(found: Hypotheses, scale: ActivityScale) -> list[Table]:
    """verdict_normality, verdict_participants, verdict_specimens, verdict_pairs, verdict_power, power_sensitivity."""
    tests, alpha = found.tests, found.alpha
    across, within = tests.between_blocks, tests.between_groups
    equal = f"One-way ANOVA: {how_many(across.anova.p, alpha, 'specimens')}"
    differ = f"One-way ANOVA: {how_many(within.anova.p, alpha, 'participants')}"
    rows = {
        "normality": normality_rows(tests.normality, alpha, "clusters"),
        "participants": [
            *group_rows(across, alpha, "specimens"),
            *equality_rows(equal, tests.equality, tests.blocks, scale.factor, scale.unit),
            variance_row(across, alpha, "specimens"),
        ] if across.anova.f.size else [],
        "specimens": [
            *group_rows(within, alpha, "participants"),
            *(over_people_rows(differ, within.anova.p, tests.blocks, alpha) if tests.blocks else []),
            variance_row(within, alpha, "participants"),
        ] if within.anova.f.size else [],
        "pairs": pair_rows(tests.pairs, alpha) if within.anova.f.size else [],
        "power": _power_rows(found),
    }  # fmt: skip
    tables = [companion_table(f"verdict_{name}", _CAPTIONS[name], of) for name, of in rows.items()]
    return [*tables, _sensitivity(found)]


def _power_rows(found: Hypotheses) -> list[Row]:
    power, people = found.power, f"{found.power.people} people" if found.power.people else "not defined"
    return [
        Row(
            _PLANNED,
            f"Repeated-measures F between repetitions: power {bounded(power.repetitions)} here",
            f"f = {EFFECT_F:g}, ρ = {RHO:g}, ε = {EPSILON:g}: chosen, not measured",
            "it is not the hypothesis of the study",
        ),
        Row(
            _PLANNED,
            f"Repeated-measures F between specimens: power {bounded(power.specimens)} here",
            f"{people} for a power of {bounded(TARGET, 2)}",
            "not defined" if np.isnan(power.specimens)
            else "no" if power.specimens >= TARGET else "yes: the sample is too small for it",
        ),
    ]  # fmt: skip


def _sensitivity(found: Hypotheses) -> Table:
    """How the power to tell the specimens apart hangs on what nobody knew beforehand."""
    people, specimens = found.participants.size, found.specimens.size
    columns = (
        Column("rho", "Correlation ρ"), Column("epsilon", "Sphericity ε"), Column("power", "Power here"),
        Column("people", f"People for a power of {bounded(TARGET, 2)}"),
    )  # fmt: skip
    caption = f"Power of {people} people to tell {specimens} specimens apart at f = {EFFECT_F:g}"
    if people < 2 or specimens < 2:
        return Table("power_sensitivity", caption, columns, ())
    table = power_table(people, specimens, EFFECT_F, alpha=found.alpha, power=TARGET)
    rows = tuple(
        (float(rho), float(epsilon), float(table.power[i, j]), int(table.people[i, j]))
        for i, rho in enumerate(table.rho)
        for j, epsilon in enumerate(table.epsilon)
    )
    return Table("power_sensitivity", caption, columns, rows)
