"""The contact area spread rate: does it tell the specimens apart, and the new one from its neighbours?"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from emg2vsa.arrays import Ints
from emg2vsa.claims import paper
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.mountings import Ratios
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr import RateSeries, draw_rates
from emg2vsa.report import designs
from emg2vsa.report.companion_rows import dunn_bounds
from emg2vsa.report.designs import design_name, finite, keys, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Table
from emg2vsa.report.wording import UNDEFINED, area_unit, exact_p, listed, p_value, scored_by

_LAW = {"ode": "a power law", "paper": "equation (1)"}
_NOT_APART = {("constant-min", 0.0): f"not told apart, p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}"}
_SIDES = ("stiffer", "softer")


def _quantities(results: StudyResults) -> Items:
    for (condition, angle), p in paper.CASR_WORST_P.items():
        yield f"paper.{condition}.{angle:g}.casr.worst_p", p
    yield "paper.constant-min.0.new.stiffer_mean_rank_p", paper.NEW_MIN_STIFFNESS_P
    found = tested(results)
    table, spread, new = found.table, found.spread, found.new
    of_casr: dict[str, Any] = {
        "casr.specimens_p": spread.kruskal.p, "casr.specimens_epsilon2": spread.kruskal.epsilon2,
        "casr.worst_p": spread.worst_p,
    }  # fmt: skip
    if new is not None:
        of_casr |= {f"new.{side}_mean_rank_p": new.p_mean_rank[:, i] for i, side in enumerate(_SIDES)}
        of_casr |= {"new.between": new.between, "new.discriminated": new.discriminated}
    yield from designs.of_designs(found, of_casr | _steps(found))
    for i, name in enumerate(keys(found)):
        if not table.unscored(i, spread.specimens):
            yield f"{name}.casr.rises", bool(spread.rises[i])
    yield from designs.of_presses(found, f"casr_{table.area_unit}_per_n", table.casr)
    if new is not None:
        yield "runs.new.specimen", new.name
        yield "runs.new.discriminated", int(np.count_nonzero(new.discriminated))
        yield "runs.new.designs", int(new.discriminated.size)


def _steps(found: Discrimination) -> dict[str, Ratios]:
    """(D,) from every specimen to the next softer one, by their keys."""
    pairs, steps = list(pairwise(found.table.specimens)), found.spread.steps
    parts = [each.reshape(-1, len(pairs)).T for each in (steps.estimate, steps.low, steps.high)]
    return {f"casr.{soft}_over_{stiff}": Ratios(*ends) for (stiff, soft), *ends in zip(pairs, *parts, strict=True)}


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    """CASR by specimen, from each to the next softer one, and of the new one beside its neighbours."""
    found = tested(results)
    table, unit = found.table, found.table.area_unit
    of_design, count = designs.pairs_of(table), np.isfinite(table.casr[table.algorithm][0]).sum(axis=1)
    columns: dict[Column, Any] = {
        Column(f"{name}_{unit}_per_n", f"{name} ({area_unit(unit)}/N)"): f"{name}.casr_{unit}_per_n.mean"
        for name in found.spread.specimens
    } | {
        Column("rises", "Softer is larger"): "casr.rises",
        Column("p", "Kruskal-Wallis p"): "casr.specimens_p",
        Column("worst_paper", "Paper's worst p (Dunn, Bonferroni)"): [
            exact_p(paper.CASR_WORST_P.get(design, np.nan)) for design in of_design
        ],
        Column("worst_dunn", "Worst p here (Dunn, Bonferroni)"): list(map(p_value, found.spread.worst_p.tolist())),
    }  # fmt: skip
    caption = f"Mean CASR by specimen, and the paper's tests. {_bound(count[table.known])}{designs.BY_PRESSES}"
    yield designs.by_design("casr_by_specimen", caption, found, q, columns)
    level = f"{100 * (1 - found.settings.alpha):g} % interval over mountings"
    columns = {
        Column(f"{soft}_over_{stiff}", f"{soft} / {stiff}"): f"casr.{soft}_over_{stiff}"
        for stiff, soft in pairwise(table.specimens)
    }
    yield designs.by_design("casr_steps", f"CASR over that of the next stiffer specimen, {level}", found, q, columns)
    if (new := found.new) is None:
        return
    three = [name for name in (*new.neighbours, new.name) if name]
    columns = {
        Column("paper", "Paper (Dunn, Bonferroni)"): [
            _NOT_APART.get(each, "told apart") if each in paper.DESIGNS else UNDEFINED for each in of_design
        ],
        **{
            Column(f"p_rank_{side}", f"p against {name or 'none'} (Dunn, Bonferroni)"): f"new.{side}_mean_rank_p"
            for side, name in zip(_SIDES, new.neighbours, strict=True)
        },
        Column("between", "Lies between"): _scored(found, three, new.between),
        Column("discriminated", "Both intervals say so"): _scored(found, three, new.discriminated),
    }
    caption = f"{new.name} beside its neighbours in stiffness. {_bound(count)}{designs.BY_PRESSES}"
    yield designs.by_design("new_specimen", caption, found, q, columns)


def _scored(found: Discrimination, specimens: Sequence[str], values: np.ndarray) -> list[bool | None]:
    """None in designs in which one of the specimens has no score."""
    return [None if found.table.unscored(i, specimens) else bool(each) for i, each in enumerate(values)]


def _bound(count: Ints) -> str:
    bounds = dunn_bounds(count)
    said = "The paper's test gives neighbours no p below {} here, even if they do not overlap. "
    return said.format(p_value(bounds[1])) if bounds else ""


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    table = tested(results).table
    unit, scoring = area_unit(table.area_unit), results.study.scoring
    constant = [i for level in ("min", "mean", "max") for i in table.of_condition(f"constant-{level}")]
    first = 0
    for name, number, what, own in (
        ("fig10_rigid", 10, "rigid motor (high stiffness)", table.of_condition(RIGID)),
        ("fig12_human_like", 12, "human-like stiffness (modular)", table.of_condition(HUMAN_LIKE)),
        ("fig13_constant", 13, "constant levels of the profile", constant),
    ):
        if not own:
            continue
        rows = [(design_name(table, i), _series(results, i)) for i in own]
        seen = (
            f"CASR, {what}. Left: dA/dF of frames, and its fit. Right: CASR of presses ({scoring.algorithm} algorithm)."
        )
        caption = f"Fig. {number}. {f'As Fig. {first}, {what}.' if first else seen} {_without(rows)}"
        first = first or number
        told = f"All panels by {scored_by(scoring)}. The fit is the derivative of {_LAW[scoring.recipe.law]}. "
        medians = designs.medians_said((title, ((each.name, each.casr) for each in row)) for title, row in rows)
        title, figure = f"dA/dF against force and CASR, {what}", draw_rates(rows, unit)
        yield designs.drawing(
            results, name, title, caption.rstrip(), f"{told}Median CASR in {unit}/N. {medians}.", figure
        )


def _without(rows: Sequence[tuple[str, Sequence[RateSeries]]]) -> str:
    """Which specimens have no mark, as a sentence; "" where all have."""
    lacking = [
        f"{title}: {listed(names)}" for title, row in rows if (names := [s.name for s in row if not s.casr.size])
    ]
    return f"No press has a CASR in {'; '.join(lacking)} (see the notes about the runs)." if lacking else ""


def _series(results: StudyResults, design: int) -> Sequence[RateSeries]:
    table, look, recipe = tested(results).table, designs.looks(results), results.study.scoring.recipe
    of = designs.pairs_of(table)[design]
    runs = {run.specimen: run for run in results.pressed.scores if (run.condition, run.angle_deg) == of}
    found = []
    for name, scores in zip(table.specimens, table.casr[table.algorithm][design], strict=True):
        if name in runs:
            presses = [(curve.force_n, curve.area_mm2) for curve in runs[name].curves]
            if recipe.rate == "paper":
                # its first force is 0
                presses = [(np.append(np.zeros_like(force_n[:1]), force_n[1:]), area) for force_n, area in presses]
            found.append(RateSeries(name, look[name], presses, finite(scores), recipe.law == "paper"))
    return found


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    return {"notes": found.notes, "new": found.new.name if found.new else ""}


_TEXT = """
{{ figure("fig10_rigid") }}
{{ figure("fig12_human_like") }}
{{ figure("fig13_constant") }}
{{ folded("casr_steps", "CASR from specimen to specimen, over mountings") }}
{{ folded("casr_by_specimen", "CASR in every design, and the paper's tests") }}
{{ folded("new_specimen", new ~ " and its neighbours in every design") }}
{% if notes %}<details><summary>Notes on the tests</summary>{{ notes | bullets }}</details>{% endif %}
"""

RATES = Section("casr", "Contact area spread rate", _TEXT, of_tests, _quantities, _tables, _drawings, _words)
