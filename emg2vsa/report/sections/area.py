"""The initial contact area: does it depend on the specimen, and on the angle?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import RIGID
from emg2vsa.figures.canvas import PairBar
from emg2vsa.figures.casr import POOLED, draw_areas, draw_contacts
from emg2vsa.report import designs
from emg2vsa.report.designs import ends_of, finite, intervals, keys, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, moments
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import area_unit, interval, number, p_value
from emg2vsa.run_scores import PICTURED_N

_OUTLINED = {"front": "outline and area by the {} algorithm"}
_GROWN = "region whose growth is measured, and A_c0 times that growth ({} algorithm)"


def _quantities(results: StudyResults) -> Items:
    for angle, p in paper.AREA_SPECIMENS_P.items():
        yield f"paper.high-stiffness.{angle:g}.area.specimens_p", p
    yield "paper.high-stiffness.area.angles.worst_p", paper.AREA_ANGLES_WORST_P
    found = tested(results)
    table, area, unit = found.table, found.area, found.table.area_unit
    of_area = {
        "specimens_p": area.kruskal.p, "specimens_epsilon2": area.kruskal.epsilon2,
        "softest_over_stiffest": area.softest_over_stiffest,
    }  # fmt: skip
    yield from designs.of_designs(found, {f"area.{key}": values for key, values in of_area.items()})
    for i, name in enumerate(keys(found)):
        for key, areas in (("a_c0", table.a_c0), ("start_area", table.start_area)):
            for specimen, values in zip(table.specimens, areas[table.algorithm][i], strict=True):
                yield from moments(f"{name}.{specimen}.{key}_{unit}", values)
    if of := found.area_by_angle:
        for i, condition in enumerate(of.conditions):
            name = f"runs.{condition}.area.angles"
            yield f"{name}.p", float(of.kruskal.p[i])
            yield f"{name}.worst_p", of.worst_p(i)
            yield f"{name}.falls", of.falls(i)
            for a, angle in enumerate(of.angles_deg.tolist()):
                if np.isfinite(of.over_first[i].estimate[a]):
                    yield from intervals(f"{name}.over_first.{angle:g}", of.over_first[i], a)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    yield _by_specimen(found)
    yield _by_angle(found)


def _by_specimen(found: Discrimination) -> Table:
    table, area, unit = found.table, found.area, found.table.area_unit
    names = [table.specimens[i] for i in table.known]
    columns = {
        **{
            Column(f"{name}_{unit}", f"{name} ({area_unit(unit)})"): mean
            for name, mean in zip(names, area.mean.T, strict=True)
        },
        Column("softest_over_stiffest", "Softest / stiffest"): area.softest_over_stiffest,
        Column("p", "Kruskal-Wallis p"): area.kruskal.p,
        Column("p_paper", "Paper's p"): [
            paper.AREA_SPECIMENS_P.get(angle) if condition == RIGID else None
            for condition, angle in designs.pairs_of(table)
        ],
        Column("epsilon2", "ε²_R"): area.kruskal.epsilon2,
    }
    caption = f"Mean initial area by specimen ({table.algorithm} algorithm); ratio with its interval over mountings"
    return designs.by_design("area_by_specimen", f"{caption}. {designs.BY_PRESSES}", table, columns)


def _by_angle(found: Discrimination) -> Table:
    of, unit = found.area_by_angle, found.table.area_unit
    columns: Columns = {Column("condition", "Condition"): ()}
    if of:
        angles, rows = of.angles_deg.tolist(), range(len(of.conditions))
        columns = {Column("condition", "Condition"): of.conditions}
        for angle, mean in zip(angles, of.mean.T, strict=True):
            columns[Column(f"area_{angle:g}_deg_{unit}", f"{angle:g}° ({area_unit(unit)})")] = mean
        for a, angle in enumerate(angles[1:], start=1):
            ratios = [interval(*ends_of(of.over_first[i], a)) for i in rows]
            columns[Column(f"over_first_{angle:g}_deg", f"{angle:g}° / {angles[0]:g}°")] = ratios
        worst = [p_value(of.worst_p(i)) for i in rows]
        columns |= {
            Column("p", "Kruskal-Wallis p"): of.kruskal.p,
            Column("worst_p", "Worst pair (Dunn, Bonferroni)", name="p_worst"): worst,
            Column("falls", "Falls with angle"): [of.falls(i) for i in rows],
        }
    caption = "Mean initial area by angle, all known specimens; ratios with their intervals over mountings"
    return table_of("area_by_angle", f"{caption}. {designs.BY_PRESSES}", columns)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    found = tested(results)
    table = found.table
    condition = RIGID if table.of_condition(RIGID) else table.conditions[0]
    own = table.of_condition(condition)
    yield _differences(results, found, condition, own)
    pictures = {
        (run.specimen, run.angle_deg): run.picture for run in results.pressed.scores if run.condition == condition
    }
    angles, known = table.angles_deg[own].tolist(), [table.specimens[i] for i in table.known]
    seen = {
        name: [(f"{angle:g}°", picture) for angle in angles if (picture := pictures.get((name, angle)))]
        for name in known
    }
    specimen = max(seen, key=lambda name: len(seen[name]))
    if not (panels := seen[specimen]):
        return
    unit = area_unit(table.area_unit)
    told = "; ".join(f"{title}: {number(p.area_mm2)} {unit} at {p.force_n:.2f} N" for title, p in panels)
    caption = (
        f"Fig. 9. Contact on {specimen}, {condition}, near {PICTURED_N:g} N, with the "
        f"{_OUTLINED.get(table.algorithm, _GROWN).format(table.algorithm)}."
    )
    title = "Contact at each angle at one force"
    yield designs.drawing(results, "fig09_first_contact", title, caption, f"{told}.", draw_contacts(panels, unit))


def _differences(results: StudyResults, found: Discrimination, condition: str, own: list[int]) -> Drawing:
    """Figure 8: every press beside the mean of all specimens at its angle, and beside its specimen's at the first."""
    table, known, look = found.table, found.table.known, designs.looks(results)
    names, values = [table.specimens[i] for i in known], table.start_area[table.algorithm][:, known]
    means = np.array([[np.mean(finite(each)) if finite(each).size else np.nan for each in row] for row in values])
    angles, unit, levels = [f"{table.angles_deg[i]:g}°" for i in own], area_unit(table.area_unit), means[own]
    panels = [
        (f"{angle}\nmean {number(float(np.nanmean(level)))} {unit}", [
            (name, 100 * (finite(presses) / np.nanmean(level) - 1), look[name])
            for name, presses in zip(names, values[i], strict=True)
        ])
        for i, angle, level in zip(own, angles, levels, strict=True)
    ]  # fmt: skip
    beside, bars = "", []
    if len(own) > 1:
        shares = [finite((100 * (values[i] / levels[0][:, None] - 1)).ravel()) for i in own]
        panels.append((f"beside {angles[0]}", [(*each, POOLED) for each in zip(angles, shares, strict=True)]))
        beside, bars = (
            f"; right, from its specimen at {angles[0]} (Dunn's test, Bonferroni)",
            _bars(found, condition, own),
        )
    caption = (
        f"Fig. 8. Initial area where loading begins, {condition} ({table.algorithm} algorithm): difference of each "
        f"press from the mean at its angle{beside}."
    )
    told = designs.medians_said((title.replace("\n", ", "), [each[:2] for each in boxes]) for title, boxes in panels)
    title, figure = "Initial contact area by specimen and by angle", draw_areas(panels, bars)
    return designs.drawing(results, "fig08_initial_area", title, caption, f"Medians in percent. {told}.", figure)


def _bars(found: Discrimination, condition: str, own: list[int]) -> list[PairBar]:
    of = found.area_by_angle
    if of is None or condition not in of.conditions:
        return []
    places = {angle: place for place, angle in enumerate(found.table.angles_deg[own].tolist())}
    ends = zip(of.angles_deg[of.pairs.first].tolist(), of.angles_deg[of.pairs.second].tolist(), strict=True)
    p = of.pairs.p[of.conditions.index(condition)].tolist()
    return [PairBar(places[a], places[b], each) for (a, b), each in zip(ends, p, strict=True) if {a, b} <= set(places)]


_TEXT = """
{{ figure("fig08_initial_area") }}
{{ figure("fig09_first_contact") }}
<p>{% if runs.discrimination.table.algorithm == "paper" %}Areas are A_c0, those of the first frame in contact, whatever
its force.{% else %}The first frame in contact comes at another force in every press, so areas are compared where
loading begins.{% endif %}</p>
{{ folded("area_by_specimen", "Initial area in every design") }}
{{ folded("area_by_angle", "Initial area at every angle") }}
"""

AREA = Section("area", "Initial contact area", _TEXT, of_tests, _quantities, _tables, _drawings)
