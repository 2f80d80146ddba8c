"""The initial contact area: does it depend on the specimen, and on the angle?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.claims import paper
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.area import AreaByAngle
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.canvas import PairBar
from emg2vsa.figures.casr import POOLED, AreaPanel, draw_areas, draw_contacts
from emg2vsa.figures.palette import Look
from emg2vsa.report.companion_rows import (
    CompanionRow,
    change,
    companion_table,
    equality_rows,
    evidence_row,
    how_many,
    normality_rows,
    welch_row,
)
from emg2vsa.report.designs import (
    BOXES,
    DESIGN,
    design_names,
    drawing,
    finite,
    keys,
    looks,
    medians_said,
    of_tests,
    specimens_test,
    tested,
)
from emg2vsa.report.drawing import STARS, Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, moments
from emg2vsa.report.outcome_text import range_said
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import area_unit, number, p_text, p_value
from emg2vsa.run_scores import PICTURED_N

_MANY = "designs"
_OUTLINED = {"front": "outline that the {} algorithm finds and the area within it"}
_GROWN = "region whose growth is measured, and the area by the {} algorithm, which is A_c0 times that growth"


def _quantities(results: StudyResults) -> Items:
    for angle, p in paper.AREA_SPECIMENS_P.items():
        yield f"paper.high-stiffness.{angle:g}.area.specimens_p", p
    yield "paper.high-stiffness.area.angles.worst_p", paper.AREA_ANGLES_WORST_P
    found = tested(results)
    table, area, unit = found.table, found.area, found.table.area_unit
    for i, name in enumerate(keys(found)):
        yield from specimens_test(f"{name}.area", area.groups, i)
        yield f"{name}.area.specimens_bf01", float(area.groups.bayes.bf01[i])
        yield f"{name}.area.equal_within", float(area.equality.bound[i])
        yield f"{name}.area.softest_over_stiffest", float(area.softest_over_stiffest[i])
        for key, areas in (("a_c0", table.a_c0), ("start_area", table.start_area)):
            for specimen, values in zip(table.specimens, areas[table.algorithm][i], strict=True):
                yield from moments(f"{name}.{specimen}.{key}_{unit}", values)
    of = found.area_by_angle
    for i, condition in enumerate(of.conditions if of else ()):
        assert of is not None
        name = f"runs.{condition}.area.angles{f'.{of.specimens[i]}' if of.specimens[i] else ''}"
        yield f"{name}.p", float(of.groups.kruskal.p[i])
        yield f"{name}.worst_p", of.worst_p(i)
        yield f"{name}.falls", of.falls(i)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    alpha = found.settings.alpha
    yield _by_specimen(found)
    yield _by_angle(found)
    for name, caption, rows in (
        ("area", "A_c0 is the same on all specimens", _same(found)),
        ("angle", "A_c0 changes with the angle", _angle(found)),
        (
            "runs_normality",
            "Gaussian samples of A_c0 and CASR",
            normality_rows(found.area.normality, alpha, "samples of A_c0")
            + normality_rows(found.spread.normality, alpha, "samples of CASR"),
        ),
    ):
        yield companion_table(name, caption, rows)


def _by_specimen(found: Discrimination) -> Table:
    table, area = found.table, found.area
    unit, names = table.area_unit, [table.specimens[i] for i in table.known]
    printed = [
        paper.AREA_SPECIMENS_P.get(angle) if condition == RIGID else None
        for condition, angle in zip(table.conditions, table.angles_deg.tolist(), strict=True)
    ]
    means = zip(names, area.groups.anova.mean.T, strict=True)
    columns: Columns = {
        DESIGN: design_names(table),
        **{Column(f"{name}_{unit}", f"{name} ({area_unit(unit)})"): mean for name, mean in means},
        Column("softest_over_stiffest", "Softest / stiffest"): area.softest_over_stiffest,
        Column("p", "Kruskal-Wallis p"): area.groups.kruskal.p,
        Column("p_paper", "Paper's p"): printed,
        Column("epsilon2", "ε²_R"): area.groups.kruskal.epsilon2,
        Column("bf01", "BF₀₁"): area.groups.bayes.bf01,
        Column("equal_within", "Equal within ± (%)", 100.0): area.equality.bound,
    }
    return table_of("area_by_specimen", f"Mean initial area by specimen ({table.algorithm} algorithm)", columns)


def _by_angle(found: Discrimination) -> Table:
    of, unit = found.area_by_angle, found.table.area_unit
    comparisons = range(len(of.conditions) if of else 0)
    means = zip(of.angles_deg.tolist(), of.mean.T, strict=True) if of else ()
    worst = [of.worst_p(i) for i in comparisons] if of else []
    worst_holm = np.fmax.reduce(of.pairs.p_rank_holm, axis=1, initial=np.nan).tolist() if of else []
    columns: Columns = {
        Column("condition", "Condition"): of.conditions if of else (),
        Column("specimens", "Specimens"): [name or "all" for name in of.specimens] if of else [],
        **{Column(f"area_{angle:g}_deg_{unit}", f"{angle:g}° ({area_unit(unit)})"): mean for angle, mean in means},
        Column("p", "Kruskal-Wallis p"): of.groups.kruskal.p if of else [],
        Column("worst_p", "Worst pair (Dunn, Bonferroni)", name="p_worst"): list(map(p_value, worst)),
        Column("worst_p_holm", "Worst pair (Mann-Whitney, Holm)"): list(map(p_value, worst_holm)),
        Column("falls", "Falls with angle"): [of.falls(i) for i in comparisons] if of else [],
    }
    return table_of("area_by_angle", "Mean initial area by angle", columns)


def _same(found: Discrimination) -> list[CompanionRow]:
    alpha, groups = found.settings.alpha, found.area.groups
    ranks = groups.kruskal.p
    test = f"Kruskal-Wallis: {how_many(ranks, alpha, _MANY)}"
    equal = equality_rows(test, found.area.equality, None, 100.0, "%")
    return [
        welch_row(groups, alpha, _MANY),
        evidence_row(test, ranks, groups.bayes.bf01, alpha),
        *(replace(row, changes="no") if np.all(ranks < alpha) else row for row in equal),
    ]


def _angle(found: Discrimination) -> list[CompanionRow]:
    of, alpha = found.area_by_angle, found.settings.alpha
    if of is None:
        return []
    families = (
        [i for i, c in enumerate(of.conditions) if c == condition and bool(of.specimens[i]) is alone]
        for condition in dict.fromkeys(of.conditions)
        for alone in (False, True)
    )
    return [
        CompanionRow(
            f"Kruskal-Wallis and Dunn, Bonferroni, {of.conditions[rows[0]]}: "
            f"{'each specimen' if of.specimens[rows[0]] else 'specimens pooled'}, {_worst(of, rows, of.pairs.dunn.p)}",
            f"Mann-Whitney, exact, Holm: {_worst(of, rows, of.pairs.p_rank_holm)}",
            range_said("|r_rb|", np.abs(of.pairs.mann_whitney.rank_biserial[rows])),
            change(of.pairs.dunn.p[rows], of.pairs.p_rank_holm[rows], alpha),
        )
        for rows in families
        if rows
    ]


def _worst(of: AreaByAngle, rows: list[int], p: Floats) -> str:
    """The worst p of some comparisons and the pair it belongs to."""
    own = p[rows]
    if not np.isfinite(own).any():
        return "not defined"
    row, pair = np.unravel_index(int(np.nanargmax(own)), own.shape)
    ends = " and ".join(f"{of.angles_deg[end[pair]]:g}°" for end in (of.pairs.first, of.pairs.second))
    return f"worst {p_text(float(own[row, pair]))} ({', '.join(filter(None, (of.specimens[rows[int(row)]], ends)))})"


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    found = tested(results)
    table = found.table
    condition = RIGID if table.of_condition(RIGID) else table.conditions[0]
    designs = table.of_condition(condition)
    yield _differences(results, found, condition, designs, looks(results))
    pictures = {
        (run.specimen, run.angle_deg): run.picture for run in results.pressed.scores if run.condition == condition
    }
    angles = [float(table.angles_deg[i]) for i in designs]
    shown = max(
        (
            (name, [(f"{angle:g}°", picture) for angle in angles if (picture := pictures.get((name, angle)))])
            for name in (table.specimens[i] for i in table.known)
        ),
        key=lambda each: len(each[1]),
    )  # fmt: skip
    specimen, panels = shown
    if not panels:
        return
    unit = area_unit(table.area_unit)
    told = "; ".join(f"{title}: {number(p.area_mm2)} {unit} at {p.force_n:.2f} N" for title, p in panels)
    caption = (
        f"Fig. 9. Contact on {specimen}, {condition}, in the frame nearest to {PICTURED_N:g} N at each angle, with the "
        f"{_OUTLINED.get(table.algorithm, _GROWN).format(table.algorithm)}."
    )
    title = "Contact at each angle at one force"
    yield drawing(results, "fig09_first_contact", title, caption, told + ".", draw_contacts(panels, unit))


def _differences(
    results: StudyResults, found: Discrimination, condition: str, designs: list[int], look: Mapping[str, Look]
) -> Drawing:
    """Figure 8: every press beside the mean of all specimens at its angle, and beside its specimen's at the first."""
    table, known = found.table, found.table.known
    names, values = [table.specimens[i] for i in known], table.start_area[table.algorithm][:, known]
    p, unit = found.area.groups.kruskal.p, area_unit(table.area_unit)
    means = np.array(
        [[finite(presses).mean() if finite(presses).size else np.nan for presses in row] for row in values]
    )
    panels = [
        AreaPanel(
            f"{table.angles_deg[i]:g}°\nmean {number(float(np.nanmean(means[i])))} {unit}", names,
            [100 * (finite(presses) / np.nanmean(means[i]) - 1) for presses in values[i]], [look[n] for n in names], (),
        )
        for i in designs
    ]  # fmt: skip
    pooled = None
    if len(designs) > 1:
        shares = [finite((100 * (values[i] / means[designs[0]][:, None] - 1)).ravel()) for i in designs]
        angles = [f"{table.angles_deg[i]:g}°" for i in designs]
        pooled = AreaPanel(
            f"beside {angles[0]}", angles, shares, [POOLED] * len(designs), _bars(found, condition, designs)
        )
    each = "; ".join(f"{table.angles_deg[i]:g}°: {p_text(float(p[i]))}" for i in designs)
    caption = (
        f"Fig. 8. Initial area where loading begins, {condition}, by the {table.algorithm} algorithm. By specimen: "
        f"difference from the mean of all specimens at the same angle (Kruskal-Wallis, {each})"
    )
    caption += (
        f". By angle: difference from the mean of the same specimen at {table.angles_deg[designs[0]]:g}° (Dunn on the "
        f"areas of all specimens, Bonferroni: {STARS}). "
        if pooled
        else ". "
    )
    told = medians_said(
        [(panel.title.replace("\n", ", "), list(zip(panel.names, panel.percent, strict=True))) for panel in panels]
    )
    title = "Initial contact area by specimen and by angle"
    figure = draw_areas(panels, pooled)
    return drawing(results, "fig08_initial_area", title, caption + BOXES, f"Medians in percent. {told}.", figure)


def _bars(found: Discrimination, condition: str, designs: list[int]) -> list[PairBar]:
    of = found.area_by_angle
    if of is None or condition not in of.conditions:
        return []
    places = {float(angle): place for place, angle in enumerate(found.table.angles_deg[designs].tolist())}
    p = of.pairs.dunn.p[of.conditions.index(condition)]
    ends = [
        (float(of.angles_deg[a]), float(of.angles_deg[b])) for a, b in zip(of.pairs.first, of.pairs.second, strict=True)
    ]
    return [PairBar(places[a], places[b], float(p[q])) for q, (a, b) in enumerate(ends) if {a, b} <= set(places)]


_TEXT = """
<h3>Does the initial area depend on the specimen?</h3>
<p>{% if runs.discrimination.table.algorithm == "paper" %}The table compares A_c0, the area of the first frame in
contact, whatever its force.{% else %}The first frame in contact comes at a different force in every press, and areas
grow with force. The table therefore compares areas at the force where loading begins.{% endif %}</p>
{{ folded("verdict_area", "Tests between specimens compared") }}
{{ folded("area_by_specimen", "The area in every design") }}
<h3>Does the initial area depend on the angle?</h3>
<p>The paper pools all specimens of an angle. The companions also compare the angles on each specimen alone.</p>
{{ folded("verdict_angle", "Tests between angles compared") }}
{{ folded("area_by_angle", "The area on every specimen") }}
{{ folded("fig08_initial_area", "Figure 8: initial area by specimen and by angle") }}
{{ folded("fig09_first_contact", "Figure 9: contact at each angle at one force") }}
{{ folded("verdict_runs_normality", "Tests of normality compared") }}
"""

AREA = Section("area", "Initial contact area", _TEXT, of_tests, _quantities, _tables, _drawings)
