"""What the sections on the rig share: designs (condition and angle) and their names, intervals, looks and drawings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.figures.palette import Look
from emg2vsa.figures.palette import looks as looks_of
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, median, moments, with_interval
from emg2vsa.report.section import Quantities
from emg2vsa.report.table import Cell, Column, Columns, Table, table_of
from emg2vsa.report.wording import SIMULATED, interval, number

DESIGN = Column("design", "Condition, angle")
BY_PRESSES = "The paper's rank tests take presses of one mounting as independent"


def of_tests(results: StudyResults) -> bool:
    """Whether the study has runs that were tested."""
    return results.runs is not None and results.runs.discrimination is not None


def of_kappa(results: StudyResults) -> bool:
    """Whether a stiffness was estimated from them."""
    calibration = results.runs.calibration if results.runs else None
    return calibration is not None and bool(calibration.conditions)


def tested(results: StudyResults) -> Discrimination:
    """The tests of the runs, for a section that only a study with them has."""
    found = results.pressed.discrimination
    assert found is not None
    return found


def pairs_of(table: RunTable) -> list[tuple[str, float]]:
    """Condition and angle of every design."""
    return [*zip(table.conditions, table.angles_deg.tolist(), strict=True)]


def design_name(table: RunTable, design: int) -> str:
    """``modular, 30°``."""
    return f"{table.conditions[design]}, {table.angles_deg[design]:g}°"


def by_design(name: str, caption: str, found: Discrimination, q: Quantities, columns: Mapping[Column, Any]) -> Table:
    """A table with one row for each design. columns : values, or the key of a quantity of every design."""
    rows: Columns = {DESIGN: [design_name(found.table, i) for i in range(len(found.table.conditions))]}
    for column, values in columns.items():
        rows[column] = cells(q, keys(found), values) if isinstance(values, str) else values
    return table_of(name, caption, rows)


def cells(q: Quantities, names: Sequence[str], key: str) -> list[Cell]:
    """Quantities ``name.key``, None where there is none; those that have ends as ``3.01 [1.70, 4.23]``."""
    if any(f"{name}.{key}.low" in q for name in names):
        ends = ([float(q.get(f"{name}.{key}{end}", np.nan)) for end in ("", ".low", ".high")] for name in names)
        return [interval(*each) for each in ends]
    return [q.get(f"{name}.{key}") for name in names]


def of_designs(found: Discrimination, values: Mapping[str, Any]) -> Items:
    """Quantities ``runs.modular.30.<key>`` of every design; of what has ends, with them."""
    for i, name in enumerate(keys(found)):
        for key, each in values.items():
            if hasattr(each, "low"):
                yield from with_interval(f"{name}.{key}", *ends_of(each, i))
            else:
                yield f"{name}.{key}", each[i].item()


def of_presses(found: Discrimination, key: str, scores: Mapping[str, Floats]) -> Items:
    """Mean and SD of the presses of every specimen in every design. scores : algorithm to (D, S, R)."""
    for name, design in zip(keys(found), scores[found.table.algorithm], strict=True):
        for specimen, values in zip(found.table.specimens, design, strict=True):
            yield from moments(f"{name}.{specimen}.{key}", values)


def keys(found: Discrimination) -> list[str]:
    """``runs.modular.30`` of every design: how its quantities begin."""
    return [f"runs.{condition}.{angle:g}" for condition, angle in pairs_of(found.table)]


def ends_of(found: Any, i: int) -> tuple[float, float, float]:
    """Estimate, low and high of one design: of ``Gaps``, or of ``Ratios``."""
    estimate = found.gap if hasattr(found, "gap") else found.estimate
    return float(estimate[i]), float(found.low[i]), float(found.high[i])


def looks(results: StudyResults) -> dict[str, Look]:
    """Looks of every specimen that was pressed; those of the study keep their own."""
    pressed, new = results.pressed, results.study.profile.new_specimen
    tests = pressed.discrimination
    specimens = tests.table.specimens if tests else [run.specimen for run in pressed.scores]
    others = [name for name in specimens if name != new]
    return looks_of(list(dict.fromkeys([*results.specimens, *others])), new)


def drawing(results: StudyResults, name: str, title: str, caption: str, told: str, figure: Figure) -> Drawing:
    """A figure of the runs, which says so where they were simulated."""
    origin = f" {SIMULATED}" if results.pressed.simulated else ""
    return Drawing(name, title, caption + origin, f"{told}{origin}", figure)


def finite(values: Floats) -> Floats:
    """Those of (n,) that are finite."""
    return np.asarray(values[np.isfinite(values)])


def medians_said(rows: Iterable[tuple[str, Iterable[tuple[str, Floats]]]]) -> str:
    """``0°: S1 9.81, S3 12.2; 30°: ...``, medians of arrays (n,), for those who do not see a figure."""
    return "; ".join(f"{title}: " + ", ".join(f"{n} {number(median(v))}" for n, v in row) for title, row in rows)
