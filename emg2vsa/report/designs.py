"""What the sections on the rig share: designs (condition and angle) and their names, intervals, looks and drawings."""

from __future__ import annotations

from collections.abc import Sequence
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
from emg2vsa.report.numbers import Items
from emg2vsa.report.table import Column
from emg2vsa.report.wording import SIMULATED, number
from emg2vsa.statistics.kruskal import KruskalWallis

DESIGN = Column("design", "Condition, angle")
BY_PRESSES = "The paper's rank tests take presses of one mounting as independent"
BOXES = "Boxes are Hazen's quartiles, whiskers reach the furthest value within 1.5 interquartile ranges."


def of_tests(results: StudyResults) -> bool:
    """Whether the study has runs that were tested."""
    return results.runs is not None and results.runs.discrimination is not None


def of_kappa(results: StudyResults) -> bool:
    """Whether a stiffness was estimated from them."""
    calibration = results.runs.calibration if results.runs else None
    return of_tests(results) and calibration is not None and bool(calibration.conditions)


def tested(results: StudyResults) -> Discrimination:
    """The tests of the runs, for a section that only a study with them has."""
    found = results.pressed.discrimination
    assert found is not None
    return found


def design_name(table: RunTable, design: int) -> str:
    """``modular, 30°``."""
    return f"{table.conditions[design]}, {table.angles_deg[design]:g}°"


def design_names(table: RunTable) -> list[str]:
    """Of all designs, in their order."""
    return [design_name(table, i) for i in range(len(table.conditions))]


def keys(found: Discrimination) -> list[str]:
    """``runs.modular.30`` of every design: how its quantities begin."""
    table = found.table
    return [f"runs.{c}.{a:g}" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]


def ends_of(found: Any, i: int) -> tuple[float, float, float]:
    """Estimate, low and high of one design: of ``Gaps``, or of ``Ratios``."""
    estimate = found.gap if hasattr(found, "gap") else found.estimate
    return float(estimate[i]), float(found.low[i]), float(found.high[i])


def looks(results: StudyResults) -> dict[str, Look]:
    """Of every specimen that was pressed; those of the study keep their own."""
    found = tested(results)
    new = found.new.name if found.new else None
    others = [name for name in found.table.specimens if name != new]
    return looks_of(list(dict.fromkeys([*results.specimens, *others])), new)


def drawing(results: StudyResults, name: str, title: str, caption: str, told: str, figure: Figure) -> Drawing:
    """A figure of the runs, which says so where they were simulated."""
    origin = f" {SIMULATED}" if results.pressed.simulated else ""
    return Drawing(name, title, caption + origin, f"{told}{origin}", figure, None)


def ranks_of(name: str, found: KruskalWallis, i: int) -> Items:
    """Kruskal and Wallis' test of the known specimens in one design."""
    yield f"{name}.specimens_p", float(found.p[i])
    yield f"{name}.specimens_epsilon2", float(found.epsilon2[i])


def finite(values: Floats) -> Floats:
    """Those that are."""
    return np.asarray(values[np.isfinite(values)])


def median_said(values: Floats) -> str:
    return number(float(np.median(values))) if values.size else "none"


def medians_said(rows: Sequence[tuple[str, Sequence[tuple[str, Floats]]]]) -> str:
    """``0°: S1 9.81, S3 12.2; 30°: ...``, for those who do not see a figure."""
    return "; ".join(f"{title}: " + ", ".join(f"{n} {median_said(v)}" for n, v in row) for title, row in rows)
