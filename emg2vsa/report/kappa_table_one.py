"""Table I, ours beside the paper's, with what it hangs on: the intervals and the law."""

from __future__ import annotations

import numpy as np

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, LawResult
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report import paper_runs
from emg2vsa.report.runs_wording import interval
from emg2vsa.report.table import Column, Table
from emg2vsa.report.wording import UNDEFINED, number

COLUMNS = (
    ("old_vision", RIGID, "Old vision", paper_runs.ERROR_OLD_VISION),
    ("new_vision", RIGID, "New vision", paper_runs.ERROR_NEW_VISION),
    ("human_like", HUMAN_LIKE, "New vision, human-like", paper_runs.ERROR_HUMAN_LIKE),
)
"""Key, condition, head, the paper's errors; the first is by the old vision algorithm."""
_NAN = float("nan")


def angles(found: CalibrationResults) -> list[float]:
    """Angles of the rigid and the human-like condition, and the paper's."""
    ours = {each.angle_deg for each in found.conditions if each.condition in (RIGID, HUMAN_LIKE)}
    return sorted(ours | set(paper_runs.ANGLES_DEG))


def column(found: CalibrationResults, key: str, algorithm: str, old: str) -> list[AlgorithmResult | None]:
    """What stands behind column ``key`` at each of ``angles``; None where it was not pressed."""
    condition = next(condition for name, condition, _, _ in COLUMNS if name == key)
    of = [found.find(angle, condition) for angle in angles(found)]
    return [each.algorithms.get(old if key == "old_vision" else algorithm) if each else None for each in of]


def table_one(found: CalibrationResults, algorithm: str, old: str) -> Table:
    columns, values = [Column("angle_deg", "Angle (°)", digits=2)], []
    for key, _, head, paper in COLUMNS:
        columns += [Column(f"{key}_paper", f"{head}: paper (%)", 100.0, 2), Column(key, f"{head}: here (%)", 100.0)]
        values.append([paper.get(angle) for angle in angles(found)])
        values.append([of.chosen.error if of else _NAN for of in column(found, key, algorithm, old)])
    caption = (
        f"Table I: error on κ of {found.new_specimen} ({number(found.known_kappa_new)} N/mm). Ours have a sign, plus "
        f"for too stiff; old vision is {old}, new vision {algorithm}; –: not in the paper, or not pressed here"
    )
    return Table("table_one", caption, tuple(columns), tuple(zip(angles(found), *values, strict=True)))


def table_one_laws(found: CalibrationResults, algorithm: str, old: str) -> Table:
    """What each error of Table I is worth: the interval behind it, and the error by the paper's law."""
    columns = [Column("angle_deg", "Angle (°)", digits=2)]
    spans, errors = [], []
    for key, _, head, _ in COLUMNS:
        of = column(found, key, algorithm, old)
        columns.append(Column(f"{key}_interval_n_per_mm", f"{head}: κ and interval (N/mm)"))
        spans.append([_span(each.chosen) if each else UNDEFINED for each in of])
        errors.append([each.paper.error if each else _NAN for each in of])
    columns += [
        Column(f"{key}_paper_law", f"{head}: error by the paper's law (%)", 100.0) for key, _, head, _ in COLUMNS
    ]
    caption = "Behind Table I: intervals of κ, and errors by the paper's exponential law on the same presses"
    return Table("table_one_laws", caption, tuple(columns), tuple(zip(angles(found), *spans, *errors, strict=True)))


def _span(law: LawResult) -> str:
    """``5.31 [5.20, 5.42]``, or why the presses determine no κ."""
    if np.isnan([law.low, law.high]).any():
        return f"{number(law.kappa)}, no interval: not determined"
    if np.isinf(law.high):
        return f"{number(law.kappa)} [{number(law.low)}, ∞): not determined"
    return interval(law.kappa, law.low, law.high)
