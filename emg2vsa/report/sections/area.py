"""The initial contact area: does it depend on the specimen, and on the angle?"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.arrays import mean_of
from emg2vsa.claims import paper
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
    of_design = designs.pairs_of(table)
    columns = {
        Column(f"{name}_{unit}", f"{name} ({area_unit(unit)})"): f"{name}.start_area_{unit}.mean"
        for name in (table.specimens[i] for i in table.known)
    } | {
        Column("softest_over_stiffest", "Softest / stiffest"): "area.softest_over_stiffest",
        Column("p", "Kruskal-Wallis p"): "area.specimens_p",
        Column("p_paper", "Paper's p"): [
            paper.AREA_SPECIMENS_P.get(angle) if condition == RIGID else None for condition, angle in of_design
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
    table = tested(results).table
    condition = RIGID if table.of_condition(RIGID) else table.conditions[0]
    yield _differences(results, condition)
    runs = [run for run in results.pressed.scores if run.condition == condition and run.picture]
    specimen = max((table.specimens[i] for i in table.known), key=[run.specimen for run in runs].count)
    own = sorted((run for run in runs if run.specimen == specimen), key=lambda run: run.angle_deg)
    if not (panels := [(f"{run.angle_deg:g}°", run.picture) for run in own if run.picture]):
        return
    unit, algorithm = area_unit(table.area_unit), table.algorithm
    told = "; ".join(f"{title}: {number(p.area_mm2)} {unit} at {p.force_n:.2f} N" for title, p in panels)
    outlined = f"region whose growth is measured, and A_c0 times that growth ({algorithm} algorithm)"
    outlined = "outline and area by the front algorithm" if algorithm == "front" else outlined
    caption = f"Fig. 9. Contact on {specimen}, {condition}, near {PICTURED_N:g} N, with the {outlined}."
    title = "Contact at each angle at one force"
    yield designs.drawing(results, "fig09_first_contact", title, caption, f"{told}.", draw_contacts(panels, unit))


def _differences(results: StudyResults, condition: str) -> Drawing:
    """Figure 8: every press beside the mean of all specimens at its angle, and beside its specimen's at the first."""
    found, look = tested(results), designs.looks(results)
    table, of = found.table, found.area_by_angle
    own, unit, names = (
        table.of_condition(condition),
        area_unit(table.area_unit),
        [table.specimens[i] for i in table.known],
    )
    values, angles_deg = table.start_area[table.algorithm][own][:, table.known], table.angles_deg[own].tolist()
    means, angles = mean_of(values), [f"{angle:g}°" for angle in angles_deg]
    panels = []
    for angle, level, presses in zip(angles, np.nanmean(means, axis=1).tolist(), values, strict=True):
        each = zip(names, presses, strict=True)
        boxes = [(name, 100 * (finite(areas) / level - 1), look[name]) for name, areas in each]
        panels.append((f"{angle}\nmean {number(level)} {unit}", boxes))
    beside, bars = "", []
    if of and condition in of.conditions:
        shares = [finite((100 * (areas / means[0][:, None] - 1)).ravel()) for areas in values]
        panels.append((f"beside {angles[0]}", [(*each, POOLED) for each in zip(angles, shares, strict=True)]))
        beside = f"; right, from its specimen at {angles[0]} (Dunn's test, Bonferroni)"
        pairs = zip(of.pairs.first, of.pairs.second, of.pairs.p[of.conditions.index(condition)].tolist(), strict=True)
        ends = [(of.angles_deg[one], of.angles_deg[other], p) for one, other, p in pairs]
        bars = [PairBar(angles_deg.index(a), angles_deg.index(b), p) for a, b, p in ends if {a, b} <= {*angles_deg}]
    caption = (
        f"Fig. 8. Initial area where loading begins, {condition} ({table.algorithm} algorithm): difference of each "
        f"press from the mean at its angle{beside}."
    )
    told = designs.medians_said((title.replace("\n", ", "), [each[:2] for each in boxes]) for title, boxes in panels)
    title, figure = "Initial contact area by specimen and by angle", draw_areas(panels, bars)
    return designs.drawing(results, "fig08_initial_area", title, caption, f"Medians in percent. {told}.", figure)


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
