"""Stiffness of the new specimen: Table I, ours beside the paper's, and every estimate with its interval."""

from __future__ import annotations

import numpy as np

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, LawResult
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report import paper
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import UNDEFINED, interval, number

COLUMNS = (
    ("old_vision", RIGID, "Old vision", paper.ERROR_OLD_VISION),
    ("new_vision", RIGID, "New vision", paper.ERROR_NEW_VISION),
    ("human_like", HUMAN_LIKE, "New vision, human-like", paper.ERROR_HUMAN_LIKE),
)
"""Key, condition, head, the paper's errors; the first is by the old vision algorithm."""


def kappa_tables(found: CalibrationResults, algorithm: str, old: str) -> dict[str, Table]:
    """table_one, table_one_laws, kappa_new and calibration_laws."""
    both = _table_one(found, algorithm, old), _table_one_laws(found, algorithm, old)
    tables = (*both, _every(found, algorithm), _laws(found, algorithm))
    return {table.name: table for table in tables}


def angles(found: CalibrationResults) -> list[float]:
    """Angles of the rigid and the human-like condition, and the paper's."""
    ours = {each.angle_deg for each in found.conditions if each.condition in (RIGID, HUMAN_LIKE)}
    return sorted(ours | set(paper.ANGLES_DEG))


def column(found: CalibrationResults, key: str, algorithm: str, old: str) -> list[AlgorithmResult | None]:
    """What stands behind column ``key`` at each of ``angles``; None where it was not pressed."""
    condition = next(condition for name, condition, _, _ in COLUMNS if name == key)
    of = [found.find(angle, condition) for angle in angles(found)]
    return [each.algorithms.get(old if key == "old_vision" else algorithm) if each else None for each in of]


def _table_one(found: CalibrationResults, algorithm: str, old: str) -> Table:
    columns, values = [Column("angle_deg", "Angle (°)", digits=2)], []
    for key, _, head, printed in COLUMNS:
        columns += [Column(f"{key}_paper", f"{head}: paper (%)", 100.0, 2), Column(key, f"{head}: here (%)", 100.0)]
        values.append([printed.get(angle) for angle in angles(found)])
        values.append([of.chosen.error if of else np.nan for of in column(found, key, algorithm, old)])
    caption = (
        f"Table I: error on κ of {found.new_specimen} ({number(found.known_kappa_new)} N/mm). Ours have a sign, plus "
        f"for too stiff; old vision is {old}, new vision {algorithm}; –: not in the paper, or not pressed here"
    )
    return Table("table_one", caption, tuple(columns), tuple(zip(angles(found), *values, strict=True)))


def _table_one_laws(found: CalibrationResults, algorithm: str, old: str) -> Table:
    """What each error of Table I is worth: the interval behind it, and the error by the paper's law."""
    columns = [Column("angle_deg", "Angle (°)", digits=2)]
    spans, errors = [], []
    for key, _, head, _ in COLUMNS:
        of = column(found, key, algorithm, old)
        columns.append(Column(f"{key}_interval_n_per_mm", f"{head}: κ and interval (N/mm)"))
        spans.append([_span(each.chosen) if each else UNDEFINED for each in of])
        errors.append([each.paper.error if each else np.nan for each in of])
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


def holds(of: AlgorithmResult, truth: float) -> bool | None:
    """Whether the interval holds the known stiffness, also one without an upper end; None where either is missing."""
    low, high = of.chosen.low, of.chosen.high
    return None if np.isnan([low, truth, high]).any() else bool(low <= truth <= high)


def _every(found: CalibrationResults, algorithm: str) -> Table:
    columns = (
        Column("design", "Condition, angle"), Column("kappa_n_per_mm", "κ (N/mm)"), Column("low", "Low"),
        Column("high", "High"), Column("error", "Error (%)", 100.0), Column("holds", "Interval holds κ"),
        Column("exponential_error", "Paper's law: error (%)", 100.0), Column("adj_r2", "Its adj. R²", digits=4),
        Column("paper_adj_r2", "Paper's worst adj. R²", digits=4), Column("paper_error", "Paper's error (%)", 100.0),
        Column("fused_error", "With indentation: error (%)", 100.0),
    )  # fmt: skip
    rows: list[tuple[Cell, ...]] = []
    for each in found.conditions:
        if algorithm not in each.algorithms:
            continue
        of = each.algorithms[algorithm]
        rows.append(
            (
                f"{each.condition}, {each.angle_deg:g}°", of.chosen.kappa, of.chosen.low, of.chosen.high,
                of.chosen.error, holds(of, found.known_kappa_new), of.paper.error, of.paper.adj_r2,
                _paper_adj_r2(each.condition, each.angle_deg), _paper_error(each.condition, each.angle_deg),
                of.fused.error if of.fused else None,
            )
        )  # fmt: skip
    caption = f"κ of {found.new_specimen} by the {algorithm} algorithm, with the interval from repeated presses"
    return Table("kappa_new", caption, columns, tuple(rows))


def _laws(found: CalibrationResults, algorithm: str) -> Table:
    """What was fitted, and the curves that the paper prints; their parameters hang on the unit of CASR."""
    columns = (
        Column("design", "Condition, angle"), Column("chosen", "Law here"), Column("paper_law", "Paper's law here"),
        Column("left_out", "Best on left-out specimens"), Column("paper", "Paper's curve (unit of CASR not printed)"),
    )  # fmt: skip
    rows = tuple(
        (
            f"{each.condition}, {each.angle_deg:g}°", _equation(of.chosen), _equation(of.paper), of.best_law or None,
            _paper_curve(each.condition, each.angle_deg),
        )
        for each in found.conditions
        if (of := each.algorithms.get(algorithm))
    )  # fmt: skip
    return Table("calibration_laws", "The laws from CASR to stiffness", columns, rows)


def _equation(law: LawResult) -> str | None:
    return law.equation if np.isfinite(law.parameters).all() else None


def _paper_curve(condition: str, angle_deg: float) -> str | None:
    curve = paper.CURVES.get(angle_deg) if condition == HUMAN_LIKE else None
    return f"kappa = {curve[0]:g} exp({curve[1]:g} CASR)" if curve else None


def _paper_adj_r2(condition: str, angle_deg: float) -> float | None:
    return paper.WORST_ADJ_R2.get(condition) if (condition, angle_deg) in paper.DESIGNS else None


def _paper_error(condition: str, angle_deg: float) -> float | None:
    if condition in paper.ERROR_CONSTANT and (condition, angle_deg) in paper.DESIGNS:
        return paper.ERROR_CONSTANT[condition]
    of = {RIGID: paper.ERROR_NEW_VISION, HUMAN_LIKE: paper.ERROR_HUMAN_LIKE}.get(condition, {})
    return of.get(angle_deg)
