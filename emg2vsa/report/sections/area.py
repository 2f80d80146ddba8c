"""The initial contact area: does it depend on the specimen, and on the angle?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.canvas import PairBar
from emg2vsa.figures.casr import POOLED, AreaPanel, draw_areas, draw_contacts
from emg2vsa.figures.palette import Look
from emg2vsa.report.companion_rows import companion_table, normality_rows
from emg2vsa.report.designs import (
    BOXES,
    BY_PRESSES,
    DESIGN,
    design_names,
    drawing,
    ends_of,
    finite,
    keys,
    looks,
    medians_said,
    of_tests,
    ranks_of,
    tested,
)
from emg2vsa.report.drawing import STARS, Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, moments, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import area_unit, interval, number, p_text, p_value
from emg2vsa.run_scores import PICTURED_N

_OUTLINED = {"front": "outline that the {} algorithm finds and the area within it"}
_GROWN = "region whose growth is measured, and the area by the {} algorithm, which is A_c0 times that growth"


def _quantities(results: StudyResults) -> Items:
    for angle, p in paper.AREA_SPECIMENS_P.items():
        yield f"paper.high-stiffness.{angle:g}.area.specimens_p", p
    yield "paper.high-stiffness.area.angles.worst_p", paper.AREA_ANGLES_WORST_P
    found = tested(results)
    table, area, unit = found.table, found.area, found.table.area_unit
    for i, name in enumerate(keys(found)):
        yield from ranks_of(f"{name}.area", area.kruskal, i)
        yield from with_interval(f"{name}.area.softest_over_stiffest", *ends_of(area.softest_over_stiffest, i))
        for key, areas in (("a_c0", table.a_c0), ("start_area", table.start_area)):
            for specimen, values in zip(table.specimens, areas[table.algorithm][i], strict=True):
                yield from moments(f"{name}.{specimen}.{key}_{unit}", values)
    of = found.area_by_angle
    for i, condition in enumerate(of.conditions if of else ()):
        assert of is not None
        name = f"runs.{condition}.area.angles"
        yield f"{name}.p", float(of.kruskal.p[i])
        yield f"{name}.worst_p", of.worst_p(i)
        yield f"{name}.falls", of.falls(i)
        for a, angle in enumerate(of.angles_deg.tolist()):
            if np.isfinite(of.over_first[i].estimate[a]):
                yield from with_interval(f"{name}.over_first.{angle:g}", *ends_of(of.over_first[i], a))


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    yield _by_specimen(found)
    yield _by_angle(found)
    rows = [
        row
        for normality, what in ((found.area.normality, "A_c0"), (found.spread.normality, "CASR"))
        for row in normality_rows(normality, found.settings.alpha, f"samples of {what}")
    ]
    yield companion_table("runs_normality", "Gaussian samples of A_c0 and CASR", rows)


def _by_specimen(found: Discrimination) -> Table:
    table, area = found.table, found.area
    unit, names = table.area_unit, [table.specimens[i] for i in table.known]
    designs = [*zip(table.conditions, table.angles_deg.tolist(), strict=True)]
    columns: Columns = {
        DESIGN: design_names(table),
        **{
            Column(f"{name}_{unit}", f"{name} ({area_unit(unit)})"): mean
            for name, mean in zip(names, area.mean.T, strict=True)
        },
        Column("softest_over_stiffest", "Softest / stiffest"): [
            interval(*ends_of(area.softest_over_stiffest, i)) for i in range(len(designs))
        ],
        Column("p", "Kruskal-Wallis p"): area.kruskal.p,
        Column("p_paper", "Paper's p"): [
            paper.AREA_SPECIMENS_P.get(angle) if condition == RIGID else None for condition, angle in designs
        ],
        Column("epsilon2", "ε²_R"): area.kruskal.epsilon2,
    }
    caption = f"Mean initial area by specimen ({table.algorithm} algorithm); ratio with its interval over mountings"
    return table_of("area_by_specimen", f"{caption}. {BY_PRESSES}", columns)


def _by_angle(found: Discrimination) -> Table:
    of, unit = found.area_by_angle, found.table.area_unit
    angles = of.angles_deg.tolist() if of else []
    means = zip(angles, of.mean.T, strict=True) if of else ()
    rows = range(len(of.conditions) if of else 0)
    columns: Columns = {
        Column("condition", "Condition"): of.conditions if of else (),
        **{Column(f"area_{angle:g}_deg_{unit}", f"{angle:g}° ({area_unit(unit)})"): mean for angle, mean in means},
        **{
            Column(f"over_first_{angle:g}_deg", f"{angle:g}° / {angles[0]:g}°"): [
                interval(*ends_of(of.over_first[i], a)) for i in rows
            ]
            for a, angle in enumerate(angles)
            if a and of
        },
        Column("p", "Kruskal-Wallis p"): of.kruskal.p if of else [],
        Column("worst_p", "Worst pair (Dunn, Bonferroni)", name="p_worst"): [
            p_value(of.worst_p(i)) for i in rows if of
        ],
        Column("falls", "Falls with angle"): [of.falls(i) for i in rows if of],
    }
    caption = "Mean initial area by angle, all known specimens; ratios with their intervals over mountings"
    return table_of("area_by_angle", f"{caption}. {BY_PRESSES}", columns)


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
    p, unit = found.area.kruskal.p, area_unit(table.area_unit)
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
        f"difference from the mean of all specimens at the same angle (the paper's Kruskal-Wallis by presses, {each})"
    )
    caption += (
        f". By angle: difference from the mean of the same specimen at {table.angles_deg[designs[0]]:g}° (Dunn on the "
        f"presses on all specimens, Bonferroni: {STARS}). "
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
    p = of.pairs.p[of.conditions.index(condition)]
    ends = [
        (float(of.angles_deg[a]), float(of.angles_deg[b])) for a, b in zip(of.pairs.first, of.pairs.second, strict=True)
    ]
    return [PairBar(places[a], places[b], float(p[q])) for q, (a, b) in enumerate(ends) if {a, b} <= set(places)]


_TEXT = """
<h3>Does the initial area depend on the specimen?</h3>
<p>{% if runs.discrimination.table.algorithm == "paper" %}The table compares A_c0, the area of the first frame in
contact, whatever its force.{% else %}The first frame in contact comes at a different force in every press, and areas
grow with force. The table therefore compares areas at the force where loading begins.{% endif %}</p>
{{ folded("area_by_specimen", "The area in every design") }}
<h3>Does the initial area depend on the angle?</h3>
<p>The paper's test pools the presses of all specimens at an angle.</p>
{{ folded("area_by_angle", "The area at every angle") }}
{{ folded("fig08_initial_area", "Figure 8: initial area by specimen and by angle") }}
{{ folded("fig09_first_contact", "Figure 9: contact at each angle at one force") }}
{{ folded("verdict_runs_normality", "Tests of normality compared") }}
"""

AREA = Section("area", "Initial contact area", _TEXT, of_tests, _quantities, _tables, _drawings)
