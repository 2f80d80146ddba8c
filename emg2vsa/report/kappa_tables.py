"""Stiffness of the new specimen: Table I, ours beside the paper's, and every estimate with its interval."""

from __future__ import annotations

import numpy as np

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, LawResult
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report import paper_runs
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import number, percent

COLUMNS = (
    ("old_vision", RIGID, "Old vision", paper_runs.ERROR_OLD_VISION),
    ("new_vision", RIGID, "New vision", paper_runs.ERROR_NEW_VISION),
    ("human_like", HUMAN_LIKE, "New vision, human-like", paper_runs.ERROR_HUMAN_LIKE),
)
"""Of Table I: key, condition, head, the paper's errors; the first is by the old vision algorithm."""


def kappa_tables(found: CalibrationResults, algorithm: str, old: str) -> dict[str, Table]:
    """table_one, kappa_new and calibration_laws."""
    tables = (_table_one(found, algorithm, old), _every(found, algorithm), _laws(found, algorithm))
    return {table.name: table for table in tables}


def error_of(found: CalibrationResults, angle_deg: float, condition: str, algorithm: str) -> float:
    """Relative error of the chosen law; NaN where there is none."""
    of = found.find(angle_deg, condition)
    return of.algorithms[algorithm].chosen.error if of and algorithm in of.algorithms else float("nan")


def angles(found: CalibrationResults) -> list[float]:
    """Angles of the rigid and the human-like condition, and the paper's."""
    ours = {each.angle_deg for each in found.conditions if each.condition in (RIGID, HUMAN_LIKE)}
    return sorted(ours | set(paper_runs.ANGLES_DEG))


def _table_one(found: CalibrationResults, algorithm: str, old: str) -> Table:
    columns = (
        Column("angle_deg", "Angle (°)", digits=2),
        *(
            column
            for key, _, head, _ in COLUMNS
            for column in (
                Column(f"{key}_paper", f"{head}: paper (%)", 100.0, 2), Column(key, f"{head}: here (%)", 100.0)
            )
        ),
    )  # fmt: skip
    rows = tuple(
        (
            angle,
            *(
                cell
                for key, condition, _, paper in COLUMNS
                for cell in (
                    paper.get(angle), error_of(found, angle, condition, old if key == "old_vision" else algorithm)
                )
            ),
        )
        for angle in angles(found)
    )  # fmt: skip
    caption = (
        f"Table I: error on κ of {found.new_specimen} ({number(found.known_kappa_new)} N/mm). Ours have a sign, plus "
        f"for too stiff; old vision is {old}, new vision {algorithm}; –: not in the paper, or not pressed here"
    )
    return Table("table_one", caption, columns, rows)


def _every(found: CalibrationResults, algorithm: str) -> Table:
    columns = (
        Column("design", "Condition, angle"), Column("kappa_n_per_mm", "κ (N/mm)"), Column("low", "Low"),
        Column("high", "High"), Column("error", "Error (%)", 100.0), Column("holds", "Interval holds κ"),
        Column("exponential_error", "Paper's law: error (%)", 100.0), Column("adj_r2", "Its adj. R²"),
        Column("paper_adj_r2", "Paper's worst adj. R²"), Column("paper_error", "Paper's error (%)", 100.0),
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
                paper_runs.WORST_ADJ_R2.get(each.condition), _paper_error(each.condition, each.angle_deg),
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


def holds(of: AlgorithmResult, truth: float) -> bool | None:
    """Whether the interval holds the known stiffness; None where either is missing."""
    ends = (of.chosen.low, truth, of.chosen.high)
    return bool(ends[0] <= truth <= ends[2]) if np.isfinite(ends).all() else None


def _paper_error(condition: str, angle_deg: float) -> float | None:
    if condition in paper_runs.ERROR_CONSTANT:
        return paper_runs.ERROR_CONSTANT[condition]
    of = {RIGID: paper_runs.ERROR_NEW_VISION, HUMAN_LIKE: paper_runs.ERROR_HUMAN_LIKE}.get(condition, {})
    return of.get(angle_deg)


def kappa_conclusion(found: CalibrationResults, algorithm: str, old: str) -> str:
    """Does each step of Table I reduce the error? Counted over the angles that have both."""
    if np.isnan(found.known_kappa_new):
        return f"The stiffness of {found.new_specimen} is not known, so that no error can be stated."
    errors = {
        key: np.abs([error_of(found, a, condition, old if key == "old_vision" else algorithm) for a in angles(found)])
        for key, condition, _, _ in COLUMNS
    }
    vision = _step("The new vision algorithm", "the old one", errors["new_vision"], errors["old_vision"])
    human = _step("Human-like stiffness", "the rigid motor", errors["human_like"], errors["new_vision"])
    held = [holds(each.algorithms[algorithm], found.known_kappa_new) for each in found.conditions]
    known = [each for each in held if each is not None]
    inside = f"The interval holds the known stiffness in {sum(known)} of {len(known)} designs." if known else ""
    return " ".join(filter(None, (vision, human, inside, _caution(found, algorithm))))


def _step(name: str, other: str, after: np.ndarray, before: np.ndarray) -> str:
    both = np.isfinite(after) & np.isfinite(before)
    if not both.any():
        return ""
    smaller = int(np.count_nonzero(after[both] < before[both]))
    sizes = [percent(float(np.median(each[both]))) for each in (after, before)]
    return (
        f"{name} has the smaller error at {smaller} of {np.count_nonzero(both)} angles (median {sizes[0]} against "
        f"{sizes[1]} with {other})."
    )


def _caution(found: CalibrationResults, algorithm: str) -> str:
    """An error is one draw: how wide the intervals are beside it."""
    widths = [
        (of.high - of.low) / 2 / of.kappa
        for of in (each.algorithms[algorithm].chosen for each in found.conditions)
        if np.isfinite([of.low, of.high, of.kappa]).all()
    ]
    if not widths:
        return ""
    return (
        f"An error is one draw from presses that leave κ uncertain by ± {percent(float(np.median(widths)))} in the "
        "median design; errors that differ by less do not rank conditions or algorithms."
    )
