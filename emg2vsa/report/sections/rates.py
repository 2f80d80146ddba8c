"""The contact area spread rate: does it tell the specimens apart, and the new one from its neighbours?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr_rates import RateSeries, draw_rates
from emg2vsa.figures.palette import Look
from emg2vsa.report import paper
from emg2vsa.report.companion_rows import CompanionRow, companion_table, welch_row
from emg2vsa.report.designs import (
    BOXES,
    DESIGN,
    design_name,
    design_names,
    drawing,
    finite,
    keys,
    looks,
    medians_said,
    moments,
    of_tests,
    tested,
)
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.outcome_text import range_said
from emg2vsa.report.rig_claims import rate_claims
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Cell, Column, Table, rows_of
from emg2vsa.report.verdicts import change, dunn_bounds, how_many
from emg2vsa.report.wording import UNDEFINED, area_unit, bounded, exact_p, interval, listed, p_value, scored_by
from emg2vsa.run_scores import PressCurve

_RAW = (
    "Left: raw dA/dF from frame to frame of all presses, a part of them, and its fit, the derivative of {law} through "
    "the areas. Right: CASR of the presses."
)
_LAW = {"ode": "a power law", "paper": "equation (1)"}


def _quantities(results: StudyResults) -> Items:
    for (condition, angle), p in paper.CASR_WORST_P.items():
        yield f"paper.{condition}.{angle:g}.casr.worst_p", p
    yield "paper.constant-min.0.new.stiffer_mean_rank_p", paper.NEW_MIN_STIFFNESS_P
    found = tested(results)
    table, spread, new = found.table, found.spread, found.new
    for i, name in enumerate(keys(found)):
        yield f"{name}.casr.specimens_p", float(spread.groups.kruskal.p[i])
        yield f"{name}.casr.specimens_epsilon2", float(spread.groups.kruskal.epsilon2[i])
        yield f"{name}.casr.worst_p", float(spread.worst_p[i])
        yield f"{name}.casr.worst_p.holm", float(spread.worst_p_holm[i])
        if not table.unscored(i, spread.specimens):
            yield f"{name}.casr.rises", bool(spread.rises[i])
        for specimen, values in zip(table.specimens, table.casr[table.algorithm][i], strict=True):
            yield from moments(f"{name}.{specimen}.casr_{table.area_unit}_per_n", values)
        if new is None:
            continue
        for side, neighbour in enumerate(("stiffer", "softer")):
            yield f"{name}.new.{neighbour}_p", float(new.p[i, side])
            yield f"{name}.new.{neighbour}_mean_rank_p", float(new.p_mean_rank[i, side])
        yield f"{name}.new.between", bool(new.between[i])
        yield f"{name}.new.discriminated", bool(new.discriminated[i])
    if new is not None:
        yield "runs.new.specimen", new.name
        yield "runs.new.discriminated", int(np.count_nonzero(new.discriminated))
        yield "runs.new.designs", int(new.discriminated.size)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    caption = "CASR differs between specimens: the paper's test beside its companions"
    yield companion_table("verdict_casr", caption, _verdicts(found))
    yield _by_specimen(found)
    if found.new is not None:
        yield _new(found)


def _verdicts(found: Discrimination) -> list[CompanionRow]:
    alpha, pairs = found.settings.alpha, found.spread.pairs
    test = f"Dunn on mean ranks, Bonferroni: {how_many(pairs.dunn.p, alpha, 'pairs')}"
    ranks = range_said("|r_rb|", np.abs(pairs.mann_whitney.rank_biserial))
    families = (
        ("Mann-Whitney, exact with ties, Holm", pairs.p_rank_holm, ranks),
        ("Games-Howell", pairs.games_howell.p, range_said("|g|", np.abs(pairs.g))),
    )
    return [
        welch_row(found.spread.groups, alpha, "designs"),
        *(
            CompanionRow(test, f"{name}: {how_many(p, alpha, 'pairs')}", effect, change(pairs.dunn.p, p, alpha))
            for name, p, effect in families
        ),
    ]


def _by_specimen(found: Discrimination) -> Table:
    table, spread, unit = found.table, found.spread, found.table.area_unit
    means = {f"{name}_{unit}_per_n": name for name in spread.specimens}
    columns = (
        DESIGN, *(Column(key, f"{name} ({area_unit(unit)}/N)") for key, name in means.items()),
        Column("rises", "Softer is larger"), Column("p", "Kruskal-Wallis p"),
        Column("worst_paper", "Paper's worst p (Dunn, Bonferroni)"),
        Column("worst_dunn", "Worst p here (Dunn, Bonferroni)"),
        Column("worst_holm", "Companion: worst p (Mann-Whitney, Holm)"), Column("smallest_g", "Smallest |g|"),
    )  # fmt: skip
    designs = list(zip(table.conditions, table.angles_deg.tolist(), strict=True))
    rows = rows_of(
        {
            "design": design_names(table),
            **dict(zip(means, spread.groups.anova.mean.T, strict=True)),
            "rises": [
                None if table.unscored(i, spread.specimens) else bool(rises) for i, rises in enumerate(spread.rises)
            ],
            "p": spread.groups.kruskal.p,
            "worst_paper": [exact_p(paper.CASR_WORST_P.get(design, np.nan)) for design in designs],
            "worst_dunn": [p_value(p) for p in spread.worst_p.tolist()],
            "worst_holm": [p_value(p) for p in spread.worst_p_holm.tolist()],
            "smallest_g": np.fmin.reduce(np.abs(spread.pairs.g), axis=1, initial=np.nan),
        }
    )
    return Table("casr_by_specimen", "Mean CASR by specimen, and whether it tells them apart", columns, rows)


def _new(found: Discrimination) -> Table:
    new, table = found.new, found.table
    assert new is not None
    sides = dict(zip(("stiffer", "softer"), (name or "none" for name in new.neighbours), strict=True))
    unit = area_unit(table.area_unit)
    columns = (
        DESIGN, Column("paper", "Paper (Dunn, Bonferroni)"),
        *(Column(f"p_rank_{side}", f"p against {name} (Dunn, Bonferroni)") for side, name in sides.items()),
        *(Column(f"p_{side}", f"Companion: p against {name} (Mann-Whitney, Holm)") for side, name in sides.items()),
        *(Column(f"shift_{side}", f"{new.name} less {name} ({unit}/N)") for side, name in sides.items()),
        Column("between", "Lies between"), Column("discriminated", "Told apart (companion)"),
    )  # fmt: skip
    known = [bool(np.isfinite(shift).all()) for shift in new.shift]
    columns_of: dict[str, Sequence[Cell] | Floats] = {
        "design": design_names(table),
        "paper": [_paper_new(c, a) for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)],
        "between": [v if k else None for v, k in zip(new.between.tolist(), known, strict=True)],
        "discriminated": [v if k else None for v, k in zip(new.discriminated.tolist(), known, strict=True)],
    }
    for i, side in enumerate(sides):
        columns_of |= {f"p_rank_{side}": new.p_mean_rank[:, i], f"p_{side}": new.p[:, i]}
        shifts = zip(*(each[:, i].tolist() for each in (new.shift, new.low, new.high)), strict=True)
        columns_of[f"shift_{side}"] = [interval(*shift) for shift in shifts]
    return Table("new_specimen", f"{new.name} beside its neighbours in stiffness", columns, rows_of(columns_of))


def _paper_new(condition: str, angle_deg: float) -> str:
    if (condition, angle_deg) not in paper.DESIGNS:
        return UNDEFINED
    least = condition == "constant-min"
    return f"not told apart, p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}" if least else "told apart"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    table, look = tested(results).table, looks(results)
    # lowest, highest and mean level, as the paper has them
    constant = [i for level in ("min", "max", "mean") for i in table.of_condition(f"constant-{level}")]
    for name, number, what, designs in (
        ("fig10_rigid", 10, "rigid motor (high stiffness)", table.of_condition(RIGID)),
        ("fig12_human_like", 12, "human-like stiffness (modular)", table.of_condition(HUMAN_LIKE)),
        ("fig13_constant", 13, "constant levels of the profile", constant),
    ):
        if not designs:
            continue
        rows = [(design_name(table, i), _series(results, look, i)) for i in designs]
        specimens = listed(list(dict.fromkeys(each.name for _, row in rows for each in row)))
        unit = area_unit(table.area_unit)
        told = medians_said([(title, [(each.name, each.casr) for each in row]) for title, row in rows])
        caption = (
            f"Fig. {number}. CASR of {specimens}, {what}. All panels by {scored_by(results.study.scoring)}. "
            f"{_RAW.format(law=_LAW[results.study.scoring.recipe.law])} {_without(rows)}{BOXES}"
        )
        said, figure = f"Median CASR in {unit}/N. {told}.", draw_rates(rows, unit)
        yield drawing(results, name, f"dA/dF against force and CASR, {what}", caption, said, figure)


def _without(rows: Sequence[tuple[str, Sequence[RateSeries]]]) -> str:
    """Which specimens have no mark, as a sentence; "" where all have."""
    lacking = [
        f"{title}: {listed(names)}" for title, row in rows if (names := [s.name for s in row if not s.casr.size])
    ]
    return f"No press has a CASR in {'; '.join(lacking)} (see the notes about the runs). " if lacking else ""


def _series(results: StudyResults, look: Mapping[str, Look], design: int) -> Sequence[RateSeries]:
    table = tested(results).table
    of = (table.conditions[design], float(table.angles_deg[design]))
    runs = {run.specimen: run for run in results.pressed.scores if (run.condition, run.angle_deg) == of}
    recipe = results.study.scoring.recipe
    series = []
    for specimen, scores in zip(table.specimens, table.casr[table.algorithm][design], strict=True):
        if specimen in runs:
            presses = [_points(curve, recipe.rate == "paper") for curve in runs[specimen].curves]
            series.append(RateSeries(specimen, look[specimen], presses, finite(scores), recipe.law == "paper"))
    return series


def _points(curve: PressCurve, as_printed: bool) -> tuple[Floats, Floats]:
    """Forces and areas of a press; the first force is 0 in equation (2) as printed."""
    force_n = curve.force_n.copy()
    force_n[:1] = 0.0 if as_printed else force_n[:1]
    return force_n, curve.area_mm2


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found = tested(results)
    count = np.isfinite(found.table.casr[found.table.algorithm]).sum(axis=2)
    every, known = dunn_bounds(count[0]), dunn_bounds(count[0][found.table.known])
    papers = dunn_bounds(np.array([10, 10, 10]))
    assert papers is not None
    return {
        "notes": found.notes,
        "new": found.new.name if found.new else "",
        "bound": p_value(known[1]) if known else "",
        "papers_bound": bounded(papers[0], 4),
        "new_bound": p_value(every[1]) if every and every[1] >= found.settings.alpha else "",
    }


_TEXT = """
<p>{% if bound %}The paper's test cannot give neighbours a p below {{ bound }}, even if they do not overlap.
{% endif %}The p that the paper prints can be reached only without the correction, whose bound is {{ papers_bound }}.
Presses on one block of silicone speak of that block and that rig, not of all specimens of its stiffness.</p>
{{ folded("verdict_casr", "Tests of CASR compared") }}
{{ folded("casr_by_specimen", "CASR in every design") }}
{% if new %}
<h3>Is {{ new }} told from its neighbours?</h3>
<p>The paper's test ranks all specimens together.{% if new_bound %} Its smallest p for neighbours is
{{ new_bound }}.{% endif %} The companion, an exact Mann-Whitney test, compares two specimens at a
time.</p>
{{ folded("new_specimen", new ~ " and its neighbours in every design") }}
{% endif %}
{{ folded("fig10_rigid", "Figure 10: CASR with the rigid motor") }}
{{ folded("fig12_human_like", "Figure 12: CASR with human-like stiffness") }}
{{ folded("fig13_constant", "Figure 13: CASR with constant stiffness") }}
{% if notes %}<details><summary>Notes on the tests</summary>{{ notes | bullets }}</details>{% endif %}
"""

RATES = Section(
    "casr", "Contact area spread rate", _TEXT, of_tests, _quantities, _tables, _drawings, rate_claims, _words
)
