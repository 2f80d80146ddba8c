"""The numbers that the paper prints in section VI, and ours beside them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.discrimination import Discrimination
from emg2vsa.report.numbers import Quantity
from emg2vsa.report.paper import AREA_ANGLES_WORST_P, AREA_SPECIMENS_P, CASR_WORST_P, NEW_MIN_STIFFNESS_P
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.verdicts import dunn_bounds
from emg2vsa.report.wording import UNDEFINED, bounded, exact_p

_COLUMNS = Column("quantity", "Quantity"), Column("paper", "Paper"), Column("here", "Here"), Column("mind", "Mind")


def _papers_bounds() -> tuple[float, float]:
    """Smallest worst p of Dunn's test with the paper's three groups of ten."""
    bounds = dunn_bounds(np.array([10, 10, 10]))
    assert bounds is not None
    return bounds


def runs_comparison(found: Discrimination, numbers: Mapping[str, Quantity], simulated: bool) -> Table:
    """Quantity, the paper's value, ours, and what to mind; ours is missing where nothing was pressed."""
    source = "simulated rig" if simulated else "measured runs"
    rows = (*_areas(numbers), *_rates(found, numbers), *_new(found, numbers))
    return Table("paper_comparison_runs", f"The paper's numbers of section VI beside ours ({source})", _COLUMNS, rows)


def _areas(numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    rigid = "runs.high-stiffness"
    rows: list[tuple[Cell, ...]] = [
        (
            f"A_c0 between specimens at {angle:g}°, Kruskal-Wallis", f"p = {bounded(p, 2)}",
            _p(numbers, f"{rigid}.{angle:g}.area.specimens_p"), "a large p shows no difference, not equality",
        )
        for angle, p in AREA_SPECIMENS_P.items()
    ]  # fmt: skip
    angles = (
        "A_c0 between angles, worst pair", f"p = {AREA_ANGLES_WORST_P:.5g}",
        _p(numbers, f"{rigid}.area.angles.worst_p"), "all specimens pooled; Dunn on mean ranks, Bonferroni",
    )  # fmt: skip
    return [*rows, angles]


def _rates(found: Discrimination, numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    counts = found.spread.groups.kruskal.count
    bounds = dunn_bounds(counts[0])
    least = f"cannot be less than {exact_p(bounds[1])} in this test" if bounds else "Dunn on mean ranks, Bonferroni"
    rows: list[tuple[Cell, ...]] = []
    for (condition, angle), p in CASR_WORST_P.items():
        key = f"runs.{condition}.{angle:g}.casr.worst_p"
        holm = _p(numbers, f"{key}.holm")
        rows.append(
            (
                f"CASR between specimens, {condition} at {angle:g}°, worst pair", f"p = {exact_p(p)}",
                _p(numbers, key), f"{least}; {_reach(p, _papers_bounds()[0])}; exact Mann-Whitney, Holm: {holm}",
            )
        )  # fmt: skip
    return rows


def _reach(p: float, bound: float) -> str:
    """The paper's p beside what its test gives at the very least without a correction."""
    least = f"the bound of three separated groups of ten without correction, {bounded(bound, 5)}"
    return f"the paper's p equals {least}" if exact_p(p) == exact_p(bound) else f"the paper's p is below even {least}"


def _new(found: Discrimination, numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    if found.new is None or not all(found.new.neighbours):
        return []
    new, stiffer = found.new.name, found.new.neighbours[0]
    least = "runs.constant-min.0.new"
    told = f"{numbers['runs.new.discriminated']} of {numbers['runs.new.designs']} designs"
    return [
        (
            f"{new} against {stiffer}, lowest constant stiffness",
            f"p = {exact_p(NEW_MIN_STIFFNESS_P)}: not told apart", _p(numbers, f"{least}.stiffer_p"),
            f"exact Mann-Whitney, Holm over both neighbours; Dunn over all specimens "
            f"{_p(numbers, f'{least}.stiffer_mean_rank_p')}",
        ),
        (
            f"{new} told from both neighbours", "all but the lowest constant stiffness", told,
            "exact Mann-Whitney against each neighbour, and between them",
        ),
    ]  # fmt: skip


def _p(numbers: Mapping[str, Quantity], key: str) -> str:
    p = float(numbers.get(key, np.nan))
    return UNDEFINED if p != p else f"p = {exact_p(p)}"
