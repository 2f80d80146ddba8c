"""Sample size: the paper's computation, and the power of the test that its main claim rests on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, TARGET, Hypotheses
from emg2vsa.report.companion_rows import CompanionRow, companion_table
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Claim, Quantities, Section, of_people, verdict_of_all
from emg2vsa.report.table import Column, Table
from emg2vsa.report.wording import bounded, count
from emg2vsa.statistics.power import power_rm, power_table

_PARTICIPANTS, _REPETITIONS, _ALPHA = 14, 10, 0.05
_PLANNED = "Sample size: 14 people by ten measurements"
_ROUNDED = 0.005
"""The paper prints its power with two decimals."""


def _quantities(results: StudyResults) -> Items:
    planned = power_rm(_PARTICIPANTS, _REPETITIONS, EFFECT_F, RHO, EPSILON, _ALPHA)
    yield f"power.n{_PARTICIPANTS}", float(planned)
    if (found := results.recorded.hypotheses) is not None:
        yield "power.study", found.power.repetitions
        yield "power.study_specimens", found.power.specimens
        yield "power.people_for_specimens", found.power.people


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    if (found := results.recorded.hypotheses) is not None:
        caption = "Sample size: the paper's computation beside others"
        yield companion_table("verdict_power", caption, _rows(found))
        yield _sensitivity(found)


def _rows(found: Hypotheses) -> list[CompanionRow]:
    power, people = found.power, f"{found.power.people} people" if found.power.people else "not defined"
    return [
        CompanionRow(
            _PLANNED,
            f"Repeated-measures F between repetitions: power {bounded(power.repetitions)} here",
            f"f = {EFFECT_F:g}, ρ = {RHO:g}, ε = {EPSILON:g}: chosen, not measured",
            "not comparable: the study does not ask whether repetitions differ",
        ),
        CompanionRow(
            _PLANNED,
            f"Repeated-measures F between specimens: power {bounded(power.specimens)} here",
            f"{people} for a power of {bounded(TARGET, 2)}",
            "not defined" if np.isnan(power.specimens)
            else "no" if power.specimens >= TARGET else "yes: the sample is too small for it",
        ),
    ]  # fmt: skip


def _sensitivity(found: Hypotheses) -> Table:
    """How the power to tell the specimens apart depends on what nobody knew beforehand."""
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
        {
            "rho": float(rho),
            "epsilon": float(epsilon),
            "power": float(table.power[i, j]),
            "people": int(table.people[i, j]),
        }
        for i, rho in enumerate(table.rho)
        for j, epsilon in enumerate(table.epsilon)
    )
    return Table("power_sensitivity", caption, columns, rows)


def _claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    own = float(q.get("power.study", np.nan))
    enough, found = own >= TARGET - _ROUNDED, results.recorded.hypotheses
    people_here = 0 if found is None else found.participants.size
    repetitions = int(np.median(found.count[found.count > 0])) if found is not None and found.count.any() else 0
    as_planned = people_here >= _PARTICIPANTS and repetitions >= _REPETITIONS
    specimens = float(q.get("power.study_specimens", np.nan))
    people = q.get("power.people_for_specimens", 0)
    of_specimens = f"between specimens: {bounded(specimens)}" if specimens == specimens else ""
    yield Claim(
        "power",
        "14 participants with ten movements suffice (f = .25, α = .05)",
        "power about .80",
        f"{bounded(own)} between repetitions" if own == own else "not defined",
        own,
        verdict_of_all(as_planned and own < TARGET - _ROUNDED, enough),
        companion=f"{of_specimens}; {people} people needed" if of_specimens and people else of_specimens,
        why="Arithmetic, not a result: the study does not test repetitions."
        if as_planned or enough
        else f"This study has {count(people_here, 'participant')} and {count(repetitions, 'repetition')}.",
    )


_TEXT = """
<p>The paper's sample size is that of a test between repetitions; its hypothesis is about specimens.
The assumed correlation and sphericity are choices, not measurements.</p>
{{ folded("verdict_power", "Power of both tests") }}
{{ folded("power_sensitivity", "Power under other correlations and sphericities") }}
"""

POWER = Section("power", "Sample size", _TEXT, of_people, _quantities, _tables, claims=_claims)
