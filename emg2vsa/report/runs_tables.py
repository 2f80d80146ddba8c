"""The tables of the runs, in numbers: presses, areas, rates, the new specimen, algorithms and conditions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.conditions import ConditionComparison
from emg2vsa.discrimination.run_table import CONDITIONS, RIGID, RunTable
from emg2vsa.discrimination.separation import Gaps
from emg2vsa.report import paper
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import UNDEFINED, area_unit, exact_p, interval, listed
from emg2vsa.runs import RunScores
from emg2vsa.stats.bootstrap import Bootstrap

_DESIGN = Column("design", "Condition, angle")


def runs_tables(runs: Sequence[RunScores], found: Discrimination | None) -> dict[str, Table]:
    """Name to table."""
    tables = [_presses(runs)]
    if found is not None:
        tables += [_areas(found), _angles(found), _rates(found), _algorithms(found), _conditions(found)]
        tables += [_compared(found), *([_new(found)] if found.new else [])]
    return {table.name: table for table in tables}


def _presses(runs: Sequence[RunScores]) -> Table:
    columns = (
        Column("condition", "Condition"), Column("angle_deg", "Angle (°)", digits=2), Column("specimens", "Specimens"),
        Column("presses", "Presses"), Column("rejected", "Rejected"), Column("reasons", "Reasons"),
    )  # fmt: skip
    order = {name: i for i, name in enumerate(CONDITIONS)}
    designs = sorted(
        {(run.condition, run.angle_deg) for run in runs}, key=lambda d: (order.get(d[0], len(order)), d[0], d[1])
    )
    rows: list[tuple[Cell, ...]] = []
    for condition, angle in designs:
        own = [run for run in runs if (run.condition, run.angle_deg) == (condition, angle)]
        reasons = Counter(
            reason
            for run in own
            for reason, verdict in zip(run.reasons, run.verdicts, strict=True)
            if verdict == "rejected"
        )
        rows.append(
            (
                condition, angle, listed([run.specimen for run in own]), sum(run.repetitions.size for run in own),
                reasons.total(), "; ".join(f"{reason} ({n})" for reason, n in reasons.most_common()),
            )
        )  # fmt: skip
    return Table("runs", "Presses of every condition and angle", columns, tuple(rows))


def _areas(found: Discrimination) -> Table:
    table, area = found.table, found.area
    unit = area_unit(table.area_unit)
    columns = (
        _DESIGN,
        *(Column(f"{table.specimens[i]}_{table.area_unit}", f"{table.specimens[i]} ({unit})") for i in table.known),
        Column("softest_over_stiffest", "Softest / stiffest"), Column("p", "Kruskal-Wallis p"),
        Column("p_paper", "Paper's p"), Column("epsilon2", "ε²_R"), Column("bf01", "BF₀₁"),
        Column("equal_within", "Equal within ± (%)", 100.0),
    )  # fmt: skip
    rows = tuple(
        (
            design_name(table, i), *area.groups.anova.mean[i].tolist(), float(area.softest_over_stiffest[i]),
            float(area.groups.kruskal.p[i]), _paper_area_p(table.conditions[i], float(table.angles_deg[i])),
            float(area.groups.kruskal.epsilon2[i]), float(area.groups.bayes.bf01[i]), float(area.equality.bound[i]),
        )
        for i in range(len(table.conditions))
    )  # fmt: skip
    return Table(
        "area_by_specimen", f"Mean initial area by specimen ({found.table.algorithm} algorithm)", columns, rows
    )


def _paper_area_p(condition: str, angle_deg: float) -> float | None:
    return paper.AREA_SPECIMENS_P.get(angle_deg) if condition == "high-stiffness" else None


def _angles(found: Discrimination) -> Table:
    by_angle, unit = found.area_by_angle, found.table.area_unit
    angles = by_angle.angles_deg.tolist() if by_angle else []
    columns = (
        Column("condition", "Condition"), Column("specimens", "Specimens"),
        *(Column(f"area_{angle:g}_deg_{unit}", f"{angle:g}° ({area_unit(unit)})") for angle in angles),
        Column("p", "Kruskal-Wallis p"), Column("worst_p", "Worst pair (Dunn, Bonferroni)", name="p_worst"),
        Column("worst_p_holm", "Worst pair (Mann-Whitney, Holm)"), Column("falls", "Falls with angle"),
    )  # fmt: skip
    rows = [
        (
            by_angle.conditions[i], by_angle.specimens[i] or "all", *by_angle.mean[i].tolist(),
            float(by_angle.groups.kruskal.p[i]), exact_p(by_angle.worst_p(i)),
            exact_p(float(np.fmax.reduce(by_angle.pairs.p_rank_holm[i], initial=np.nan))), by_angle.falls(i),
        )
        for i in range(len(by_angle.conditions))
    ] if by_angle else []  # fmt: skip
    return Table("area_by_angle", "Mean initial area by angle", columns, tuple(rows))


def _rates(found: Discrimination) -> Table:
    table, spread, unit = found.table, found.spread, found.table.area_unit
    columns = (
        _DESIGN,
        *(Column(f"{name}_{unit}_per_n", f"{name} ({area_unit(unit)}/N)") for name in spread.specimens),
        Column("rises", "Softer is larger"), Column("p", "Kruskal-Wallis p"),
        Column("worst_dunn", "Worst pair (Dunn, Bonferroni)"),
        Column("worst_paper", "Paper's worst p"), Column("worst_holm", "Worst pair (Mann-Whitney, Holm)"),
        Column("smallest_g", "Smallest |g|"),
    )  # fmt: skip
    rows = tuple(
        (
            design_name(table, i), *spread.groups.anova.mean[i].tolist(),
            None if table.unscored(i, spread.specimens) else bool(spread.rises[i]),
            float(spread.groups.kruskal.p[i]), exact_p(float(spread.worst_p[i])), _paper_casr_p(found, i),
            exact_p(float(spread.worst_p_holm[i])), float(np.fmin.reduce(np.abs(spread.pairs.g[i]), initial=np.nan)),
        )
        for i in range(len(table.conditions))
    )  # fmt: skip
    return Table("casr_by_specimen", "Mean CASR by specimen, and whether it tells them apart", columns, rows)


def _paper_casr_p(found: Discrimination, design: int) -> str:
    key = (found.table.conditions[design], float(found.table.angles_deg[design]))
    return exact_p(paper.CASR_WORST_P.get(key, float("nan")))


def _new(found: Discrimination) -> Table:
    new, table = found.new, found.table
    assert new is not None
    stiffer, softer = (name or "none" for name in new.neighbours)
    unit = area_unit(table.area_unit)
    columns = (
        _DESIGN, Column("p_stiffer", f"p against {stiffer}"), Column("p_softer", f"p against {softer}"),
        Column("shift_stiffer", f"{new.name} less {stiffer} ({unit}/N)"),
        Column("shift_softer", f"{new.name} less {softer} ({unit}/N)"), Column("between", "Lies between"),
        Column("discriminated", "Told apart"), Column("p_rank_stiffer", f"Dunn p, {stiffer}"),
        Column("p_rank_softer", f"Dunn p, {softer}"), Column("paper", "Paper"),
    )  # fmt: skip
    rows = tuple(
        (
            design_name(table, i), *new.p[i].tolist(),
            *(interval(*(float(each[i, side]) for each in (new.shift, new.low, new.high))) for side in (0, 1)),
            *(None if np.isnan(new.shift[i]).any() else bool(each[i]) for each in (new.between, new.discriminated)),
            *new.p_mean_rank[i].tolist(),
            _paper_new(table.conditions[i], float(table.angles_deg[i])),
        )
        for i in range(len(table.conditions))
    )  # fmt: skip
    return Table("new_specimen", f"{new.name} beside its neighbours in stiffness", columns, rows)


def _paper_new(condition: str, angle_deg: float) -> str:
    if (condition, angle_deg) not in paper.DESIGNS:
        return UNDEFINED
    least = condition == "constant-min"
    return f"not told apart, p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}" if least else "told apart"


def _algorithms(found: Discrimination) -> Table:
    compared, table = found.algorithms, found.table
    first = compared.names[0]
    errors = {"area_error": "Error of A_c0 (%)", "area_error_sd": "its SD (%)"}
    known = errors if np.isfinite(compared.area_error).any() else {}
    columns = (
        Column("algorithm", "Algorithm"), _DESIGN, Column("area_ratio", f"A_c0 / that of {first}"),
        *(Column(key, head, 100.0) for key, head in known.items()),
        Column("area_cv", "CV of A_c0 (%)", 100.0), Column("casr_cv", "CV of CASR (%)", 100.0),
        Column("gap", f"Gap {compared.pair[0]} to {compared.pair[1]}, in SDs"),
    )  # fmt: skip
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            algorithm, design_name(table, i), float(compared.area_ratio[a, i]),
            *(float(getattr(compared, key)[a, i]) for key in known),
            float(compared.area_cv[a, i]), float(compared.casr_cv[a, i]), interval(*compared.gap(a, i)),
        )
        for a, algorithm in enumerate(compared.names)
        for i in range(len(table.conditions))
    )  # fmt: skip
    shown = tuple(row for row in rows if str(row[1]).startswith(RIGID)) or rows
    return Table("algorithms", "Vision algorithms on the same presses (all conditions: CSV)", columns, rows, shown)


def _conditions(found: Discrimination) -> Table:
    compared, table = found.conditions, found.table
    columns = (
        _DESIGN, Column("epsilon2", "ε²_R"), Column("gap", "Gap, in SDs"), Column("cv", "CV of repetitions (%)", 100.0),
    )  # fmt: skip
    rows = tuple(
        (design_name(table, i), float(compared.ranks.epsilon2[i]), interval(*gap_of(compared.gaps, i)), float(cv))
        for i, cv in enumerate(compared.cv.tolist())
    )
    caption = (
        f"How far {listed(compared.specimens)} lie apart; gap between {listed(compared.pair)}, the closest neighbours, "
        f"with {_level(found)} interval"
    )
    return Table("conditions", caption, columns, rows)


def _compared(found: Discrimination) -> Table:
    compared, table = found.conditions, found.table
    columns = (
        Column("other", "Human-like (modular) against"), Column("gap_difference", "Gap: difference, in SDs"),
        Column("cv_ratio", "CV: ratio"),
        Column("level_change_percent", "Mean CASR: difference (%)"), Column("verdict", "Human-like is"),
    )  # fmt: skip
    verdicts = {True: "better", False: "worse", None: "not to be told apart"}
    rows = tuple(
        (
            design_name(table, other), interval(*gap_of(compared.gap_differences, i)),
            interval(*interval_of(compared.cv_ratio, i)), level_change(compared, i),
            verdicts[compared.wins(i)] if np.isfinite(compared.gap_differences.gap[i]) else UNDEFINED,
        )
        for i, other in enumerate(compared.other.tolist())
    )  # fmt: skip
    caption = f"The human-like condition against every other at the same angle, {_level(found)} intervals"
    return Table("conditions_compared", caption, columns, rows)


def level_change(compared: ConditionComparison, i: int) -> str:
    """Mean CASR, human-like less other, in percent of the other, with two decimals."""
    ratios = interval_of(compared.level_ratio, i)
    estimate, low, high = (f"{100 * (ratio - 1):+.2f}" for ratio in ratios)
    return UNDEFINED if np.isnan(ratios).any() else f"{estimate} [{low}, {high}]"


def _level(found: Discrimination) -> str:
    return f"{100 * found.conditions.confidence:g}%"


def design_name(table: RunTable, design: int) -> str:
    """``modular, 30°``."""
    return f"{table.conditions[design]}, {table.angles_deg[design]:g}°"


def interval_of(found: Bootstrap, i: int) -> tuple[float, float, float]:
    """Estimate, low and high."""
    return float(found.estimate[i]), float(found.low[i]), float(found.high[i])


def gap_of(found: Gaps, i: int) -> tuple[float, float, float]:
    """Gap, low and high."""
    return float(found.gap[i]), float(found.low[i]), float(found.high[i])
