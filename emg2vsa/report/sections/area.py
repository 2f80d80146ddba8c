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
from emg2vsa.report.designs import cells, ends_of, finite, of_tests, tested
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Column, Columns, Table, table_of
from emg2vsa.report.wording import area_unit, number, p_value
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
        "area.specimens_p": area.kruskal.p, "area.specimens_epsilon2": area.kruskal.epsilon2,
        "area.softest_over_stiffest": area.softest_over_stiffest,
    }  # fmt: skip
    yield from designs.of_designs(found, of_area)
    yield from designs.of_presses(found, f"a_c0_{unit}", table.a_c0)
    yield from designs.of_presses(found, f"start_area_{unit}", table.start_area)
    if of := found.area_by_angle:
        for i, condition in enumerate(of.conditions):
            name = f"runs.{condition}.area.angles"
            yield f"{name}.p", float(of.kruskal.p[i])
            yield f"{name}.worst_p", of.worst_p(i)
            yield f"{name}.falls", of.falls(i)
            for a, angle in enumerate(of.angles_deg.tolist()):
                if np.isfinite(of.over_first[i].estimate[a]):
                    yield from with_interval(f"{name}.over_first.{angle:g}", *ends_of(of.over_first[i], a))


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found = tested(results)
    table, unit, by = found.table, found.table.area_unit, designs.BY_PRESSES
    columns = {
        Column(f"{name}_{unit}", f"{name} ({area_unit(unit)})"): f"{name}.start_area_{unit}.mean"
        for name in (table.specimens[i] for i in table.known)
    } | {
        Column("softest_over_stiffest", "Softest / stiffest"): "area.softest_over_stiffest",
        Column("p", "Kruskal-Wallis p"): "area.specimens_p",
        Column("p_paper", "Paper's p"): [
            paper.AREA_SPECIMENS_P.get(angle) if condition == RIGID else None for condition, angle in designs.pairs_of(table)
        ],
        Column("epsilon2", "ε²_R"): "area.specimens_epsilon2",
    }  # fmt: skip
    caption = f"Mean initial area by specimen ({table.algorithm} algorithm); ratio with its interval over mountings"
    yield designs.by_design("area_by_specimen", f"{caption}. {by}", found, q, columns)
    if (of := found.area_by_angle) is None:
        return
    angles, names = [f"{angle:g}" for angle in of.angles_deg], [f"runs.{each}.area.angles" for each in of.conditions]
    means = {
        Column(f"area_{angle}_deg_{unit}", f"{angle}° ({area_unit(unit)})"): mean
        for angle, mean in zip(angles, of.mean.T, strict=True)
    }
    ratios = {
        Column(f"over_first_{angle}_deg", f"{angle}° / {angles[0]}°"): cells(q, names, f"over_first.{angle}")
        for angle in angles[1:]
    }
    worst = [p_value(of.worst_p(i)) for i in range(len(names))]
    rows: Columns = {
        Column("condition", "Condition"): of.conditions, **means, **ratios,
        Column("p", "Kruskal-Wallis p"): of.kruskal.p,
        Column("worst_p", "Worst pair (Dunn, Bonferroni)", name="p_worst"): worst,
        Column("falls", "Falls with angle"): cells(q, names, "falls"),
    }  # fmt: skip
    caption = "Mean initial area by angle, all known specimens; ratios with their intervals over mountings"
    yield table_of("area_by_angle", f"{caption}. {by}", rows)


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
