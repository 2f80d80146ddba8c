"""Every number of the runs under one flat name, and the paper's of section VI beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults
from emg2vsa.discrimination import Discrimination
from emg2vsa.report import paper
from emg2vsa.report.numbers import Items, Quantity
from emg2vsa.report.runs_tables import gap_of, interval_of
from emg2vsa.runs import RunScores


def runs_quantities(runs: Sequence[RunScores], found: Discrimination | None) -> dict[str, Quantity]:
    """Name to value; a design is ``runs.<condition>.<angle>``. NaN where a number is not defined."""
    items: dict[str, Quantity] = {}
    for part in (_presses(runs), _paper(), *(part(found) for part in _PARTS if found)):
        items.update(part)
    return items


def _presses(runs: Sequence[RunScores]) -> Items:
    yield "runs.count", len(runs)
    yield "runs.simulated", any(run.simulated for run in runs)
    yield "runs.presses", sum(run.repetitions.size for run in runs)
    yield "runs.rejected", sum(run.verdicts.count("rejected") for run in runs)


def _areas(found: Discrimination) -> Items:
    table, area, unit = found.table, found.area, found.table.area_unit
    for i, name in enumerate(_names(found)):
        yield f"{name}.area.specimens_p", float(area.groups.kruskal.p[i])
        yield f"{name}.area.specimens_epsilon2", float(area.groups.kruskal.epsilon2[i])
        yield f"{name}.area.specimens_bf01", float(area.groups.bayes.bf01[i])
        yield f"{name}.area.equal_within", float(area.equality.bound[i])
        yield f"{name}.area.softest_over_stiffest", float(area.softest_over_stiffest[i])
        for key, areas in (("a_c0", table.a_c0), ("start_area", table.start_area)):
            for specimen, values in zip(table.specimens, areas[table.algorithm][i], strict=True):
                yield from _moments(f"{name}.{specimen}.{key}_{unit}", values)


def _angles(found: Discrimination) -> Items:
    by_angle = found.area_by_angle
    if by_angle is None:
        return
    for i, (condition, specimen) in enumerate(zip(by_angle.conditions, by_angle.specimens, strict=True)):
        name = f"runs.{condition}.area.angles{f'.{specimen}' if specimen else ''}"
        yield f"{name}.p", float(by_angle.groups.kruskal.p[i])
        yield f"{name}.worst_p", by_angle.worst_p(i)
        yield f"{name}.falls", by_angle.falls(i)


def _rates(found: Discrimination) -> Items:
    table, spread = found.table, found.spread
    for i, name in enumerate(_names(found)):
        yield f"{name}.casr.specimens_p", float(spread.groups.kruskal.p[i])
        yield f"{name}.casr.specimens_epsilon2", float(spread.groups.kruskal.epsilon2[i])
        yield f"{name}.casr.worst_p", float(spread.worst_p[i])
        yield f"{name}.casr.worst_p.holm", float(spread.worst_p_holm[i])
        if not table.unscored(i, spread.specimens):
            yield f"{name}.casr.rises", bool(spread.rises[i])
        for specimen, values in zip(table.specimens, table.casr[found.table.algorithm][i], strict=True):
            yield from _moments(f"{name}.{specimen}.casr_{table.area_unit}_per_n", values)


def _new(found: Discrimination) -> Items:
    new = found.new
    if new is None:
        return
    yield "runs.new.specimen", new.name
    yield "runs.new.discriminated", int(np.count_nonzero(new.discriminated))
    yield "runs.new.designs", int(new.discriminated.size)
    for i, name in enumerate(_names(found)):
        for side, neighbour in enumerate(("stiffer", "softer")):
            yield f"{name}.new.{neighbour}_p", float(new.p[i, side])
            yield f"{name}.new.{neighbour}_mean_rank_p", float(new.p_mean_rank[i, side])
        yield f"{name}.new.between", bool(new.between[i])
        yield f"{name}.new.discriminated", bool(new.discriminated[i])


def _algorithms(found: Discrimination) -> Items:
    compared = found.algorithms
    for a, algorithm in enumerate(compared.names):
        for i, name in enumerate(_names(found)):
            for key in ("area_ratio", "area_error", "area_error_sd", "area_cv", "casr_cv"):
                yield f"{name}.{algorithm}.{key}", float(getattr(compared, key)[a, i])
            yield from _interval(f"{name}.{algorithm}.gap", *compared.gap(a, i))


def _conditions(found: Discrimination) -> Items:
    compared, table = found.conditions, found.table
    yield "runs.closest_pair", " ".join(compared.pair)
    for i, name in enumerate(_names(found)):
        yield f"{name}.separation.epsilon2", float(compared.ranks.epsilon2[i])
        yield from _interval(f"{name}.separation.gap", *gap_of(compared.gaps, i))
        yield f"{name}.separation.cv", float(compared.cv[i])
    for i, other in enumerate(compared.other.tolist()):
        name = f"runs.human_like_against.{table.conditions[other]}.{table.angles_deg[other]:g}"
        yield from _interval(f"{name}.gap_difference", *gap_of(compared.gap_differences, i))
        for key, found_ratio in (("level_ratio", compared.level_ratio), ("cv_ratio", compared.cv_ratio)):
            yield from _interval(f"{name}.{key}", *interval_of(found_ratio, i))
        wins = compared.wins(i)
        yield f"{name}.verdict", "undecided" if wins is None else "better" if wins else "worse"


_PARTS = (_areas, _angles, _rates, _new, _algorithms, _conditions)


def _paper() -> Items:
    for angle, p in paper.AREA_SPECIMENS_P.items():
        yield f"paper.high-stiffness.{angle:g}.area.specimens_p", p
    yield "paper.high-stiffness.area.angles.worst_p", paper.AREA_ANGLES_WORST_P
    for (condition, angle), p in paper.CASR_WORST_P.items():
        yield f"paper.{condition}.{angle:g}.casr.worst_p", p
    yield "paper.constant-min.0.new.stiffer_mean_rank_p", paper.NEW_MIN_STIFFNESS_P
    for vision, errors in (
        ("old_vision", paper.ERROR_OLD_VISION),
        ("new_vision", paper.ERROR_NEW_VISION),
        ("human_like", paper.ERROR_HUMAN_LIKE),
    ):
        for angle, error in errors.items():
            yield f"paper.kappa_error.{vision}.{angle:g}", error
    for condition, error in paper.ERROR_CONSTANT.items():
        yield f"paper.kappa_error.{condition}.0", error
    for condition, r2 in paper.WORST_ADJ_R2.items():
        yield f"paper.{condition}.worst_adj_r2", r2
    for angle, (p, q) in paper.CURVES.items():
        yield f"paper.modular.{angle:g}.curve.level_n_per_mm", p
        yield f"paper.modular.{angle:g}.curve.rate", q


def _names(found: Discrimination) -> list[str]:
    table = found.table
    return [f"runs.{c}.{a:g}" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]


def _moments(name: str, values: np.ndarray) -> Items:
    known = values[np.isfinite(values)]
    yield f"{name}.mean", float(np.mean(known)) if known.size else np.nan
    yield f"{name}.sd", float(np.std(known, ddof=1)) if known.size > 1 else np.nan


def _interval(name: str, estimate: float, low: float, high: float) -> Items:
    yield name, estimate
    yield f"{name}.low", low
    yield f"{name}.high", high


def kappa_quantities(found: CalibrationResults) -> dict[str, Quantity]:
    """Name to value; NaN where a number is not defined."""
    return dict(_items(found))


def _items(found: CalibrationResults) -> Items:
    yield "runs.kappa.new_specimen", found.new_specimen
    yield "runs.kappa.known_n_per_mm", found.known_kappa_new
    for each in found.conditions:
        for name, of in each.algorithms.items():
            yield from _algorithm(f"runs.{each.condition}.{each.angle_deg:g}.{name}.kappa", of)


def _algorithm(name: str, of: AlgorithmResult) -> Items:
    for prefix, law in (("", of.chosen), ("paper_law.", of.paper)):
        yield f"{name}.{prefix}n_per_mm", law.kappa
        yield f"{name}.{prefix}n_per_mm.low", law.low
        yield f"{name}.{prefix}n_per_mm.high", law.high
        yield f"{name}.{prefix}error", law.error
        yield f"{name}.{prefix}adj_r2", law.adj_r2
        yield f"{name}.{prefix}law", law.law
        for key, value in zip(("first", "second"), law.parameters, strict=True):
            yield f"{name}.{prefix}parameter.{key}", value
    for law_name, rms in of.left_out_rms.items():
        yield f"{name}.left_out_rms.{law_name}", rms
    if of.fused is not None:
        yield f"{name}.fused.n_per_mm", of.fused.kappa
        yield f"{name}.fused.error", of.fused.error
        yield f"{name}.fused.weight", of.fused.weight
