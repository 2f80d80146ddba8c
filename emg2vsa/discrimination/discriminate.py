"""The stage from scored runs to what section VI of the paper says of areas, rates, algorithms and actuators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.discrimination.algorithms import AlgorithmComparison, compare_algorithms
from emg2vsa.discrimination.area import AreaByAngle, AreaBySpecimen, area_by_angle, area_by_specimen
from emg2vsa.discrimination.conditions import ConditionComparison, compare_conditions
from emg2vsa.discrimination.new_specimen import NewSpecimen, beside_neighbours
from emg2vsa.discrimination.run_table import RunTable, run_table
from emg2vsa.discrimination.spread import SpreadBySpecimen, spread_by_specimen
from emg2vsa.errors import DataError
from emg2vsa.runs import RunScores
from emg2vsa.settings import DiscriminationSettings


@dataclass(frozen=True)
class Discrimination:
    """Everything that is tested of the runs; ``notes`` say what could not be."""

    settings: DiscriminationSettings
    table: RunTable
    area: AreaBySpecimen
    area_by_angle: AreaByAngle | None
    spread: SpreadBySpecimen
    new: NewSpecimen | None
    algorithms: AlgorithmComparison
    conditions: ConditionComparison
    notes: tuple[str, ...]


def discriminate(
    runs: Sequence[RunScores],
    stiffness_n_per_mm: Mapping[str, float],
    new_specimen: str,
    settings: DiscriminationSettings | None = None,
) -> Discrimination:
    """Test ``runs``, one a specimen, angle and condition.

    stiffness_n_per_mm : of every specimen, the new one included; only its order is used. new_specimen : the one whose
    stiffness is to be estimated, which enters no test of the known ones; it need not have been pressed.
    DataError as ``run_table``, and where fewer than two known specimens were pressed.
    """
    settings = settings or DiscriminationSettings()
    table = run_table(runs, stiffness_n_per_mm, new_specimen)
    _check(table)
    return Discrimination(
        settings=settings,
        table=table,
        area=area_by_specimen(table, settings),
        area_by_angle=area_by_angle(table, settings),
        spread=spread_by_specimen(table, settings),
        new=beside_neighbours(table, settings),
        algorithms=compare_algorithms(table, settings),
        conditions=compare_conditions(table, settings),
        notes=_notes(table, new_specimen, settings),
    )


def _check(table: RunTable) -> None:
    if len(table.known) < 2:
        found = ", ".join(table.specimens[i] for i in table.known) or "none"
        raise DataError(
            "runs, specimens", wanted="two specimens or more besides the new one", found=found,
            do="Press more specimens; nothing can be told apart.",
        )  # fmt: skip


def _notes(table: RunTable, new_specimen: str, settings: DiscriminationSettings) -> tuple[str, ...]:
    count = np.isfinite(table.casr[table.algorithm]).sum(axis=2)
    designs = [f"{c} at {a:g}°" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]
    missing = [
        f"{table.specimens[specimen]} ({designs[design]})" for design, specimen in np.argwhere(count == 0).tolist()
    ]
    notes = [f"no scored press: {', '.join(missing)}"] if missing else []
    if new_specimen and table.new < 0:
        notes.append(f"no run of the new specimen {new_specimen}: it is not discriminated from its neighbours")
    if settings.old_algorithm not in table.casr:
        notes.append(f"no scores by the old algorithm {settings.old_algorithm}: nothing to compare it with")
    return tuple(notes)
