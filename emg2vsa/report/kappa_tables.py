"""Stiffness of the new specimen: Table I, ours beside the paper's, and every estimate with its interval."""

from __future__ import annotations

import numpy as np

from emg2vsa.calibration.results import CalibrationResults, LawResult
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report import paper_runs
from emg2vsa.report.kappa_conclusion import holds
from emg2vsa.report.kappa_table_one import table_one, table_one_laws
from emg2vsa.report.table import Cell, Column, Table


def kappa_tables(found: CalibrationResults, algorithm: str, old: str) -> dict[str, Table]:
    """table_one, table_one_laws, kappa_new and calibration_laws."""
    both = table_one(found, algorithm, old), table_one_laws(found, algorithm, old)
    tables = (*both, _every(found, algorithm), _laws(found, algorithm))
    return {table.name: table for table in tables}


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
    curve = paper_runs.CURVES.get(angle_deg) if condition == HUMAN_LIKE else None
    return f"kappa = {curve[0]:g} exp({curve[1]:g} CASR)" if curve else None


def _paper_adj_r2(condition: str, angle_deg: float) -> float | None:
    return paper_runs.WORST_ADJ_R2.get(condition) if (condition, angle_deg) in paper_runs.DESIGNS else None


def _paper_error(condition: str, angle_deg: float) -> float | None:
    if condition in paper_runs.ERROR_CONSTANT and (condition, angle_deg) in paper_runs.DESIGNS:
        return paper_runs.ERROR_CONSTANT[condition]
    of = {RIGID: paper_runs.ERROR_NEW_VISION, HUMAN_LIKE: paper_runs.ERROR_HUMAN_LIKE}.get(condition, {})
    return of.get(angle_deg)
