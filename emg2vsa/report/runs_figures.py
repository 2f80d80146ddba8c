"""Figures 8, 9, 10, 12, 13 and 14 of the runs, in the paper's arrangement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.boxes import PairBar
from emg2vsa.figures.canvas import style
from emg2vsa.figures.casr_areas import POOLED, AreaPanel, draw_areas, draw_contacts
from emg2vsa.figures.casr_calibration import draw_calibrations
from emg2vsa.figures.casr_rates import ConditionBoxes, RateSeries, draw_conditions, draw_rates
from emg2vsa.figures.palette import Look
from emg2vsa.figures.palette import looks as looks_of
from emg2vsa.report.drawing import STARS, Drawing
from emg2vsa.report.runs_tables import design_name
from emg2vsa.report.wording import SIMULATED, area_unit, listed, number
from emg2vsa.runs import RunScores

_BOXES = "Boxes are Hazen's quartiles, whiskers reach the furthest value within 1.5 interquartile ranges."
_RAW = (
    "Left: contact area against force, a part of the frames of all presses, and a power law through them. Right: CASR."
)


def runs_figures(
    runs: Sequence[RunScores],
    found: Discrimination,
    calibration: CalibrationResults | None,
    specimens: Sequence[str],
) -> dict[str, Drawing]:
    """Name to drawing; a figure whose runs are not there is absent. specimens : of the study: each keeps its look."""
    new = found.new.name if found.new else None
    others = [name for name in found.table.specimens if name != new]
    looks = looks_of(list(dict.fromkeys([*specimens, *others])), new)
    with style():
        drawings = [
            _areas(runs, found, looks),
            _contacts(runs, found),
            _rates(runs, found, looks, "fig10_rigid", "10", "rigid motor (high stiffness)", _of(found, RIGID)),
            _rates(
                runs, found, looks, "fig12_human_like", "12", "human-like stiffness (modular)", _of(found, HUMAN_LIKE)
            ),
            _rates(runs, found, looks, "fig13_constant", "13", "constant levels of the profile", _constant(found)),
            _conditions(runs, found, looks),
            _calibration(calibration, found.table.algorithm, looks) if calibration is not None else None,
        ]
    return {drawing.name: drawing for drawing in drawings if drawing is not None}


def _drawing(runs: Sequence[RunScores], name: str, title: str, caption: str, told: str, figure: Figure) -> Drawing:
    origin = f" {SIMULATED}" if any(run.simulated for run in runs) else ""
    return Drawing(name, title, caption + origin, f"{told}{origin}", figure, None)


def _of(found: Discrimination, condition: str) -> list[int]:
    return found.table.of_condition(condition)


def _constant(found: Discrimination) -> list[int]:
    """Lowest, highest and mean level, as the paper has them."""
    return [i for level in ("min", "max", "mean") for i in _of(found, f"constant-{level}")]


def _areas(runs: Sequence[RunScores], found: Discrimination, looks: Mapping[str, Look]) -> Drawing | None:
    table, known = found.table, found.table.known
    condition = RIGID if _of(found, RIGID) else table.conditions[0]
    designs, names = _of(found, condition), [table.specimens[i] for i in known]
    values = table.start_area[found.table.algorithm]
    p = found.area.groups.kruskal.p
    panels = [
        AreaPanel(
            f"{table.angles_deg[i]:g}°", names, [_finite(values[i, j]) for j in known], [looks[n] for n in names], ()
        )
        for i in designs
    ]
    pooled = _by_angle(found, condition) if len(designs) > 1 else None
    figure = draw_areas(panels, pooled, area_unit(table.area_unit))
    each = "; ".join(f"{panel.title}: p = {number(float(p[i]))}" for panel, i in zip(panels, designs, strict=True))
    caption = (
        f"Fig. 8. Initial area where loading begins, {condition}, by the {found.table.algorithm} algorithm: by "
        f"specimen at each angle (Kruskal-Wallis, {each})"
    )
    caption += f", and by angle, all specimens together (Dunn, Bonferroni: {STARS}). " if pooled else ". "
    told = "; ".join(
        f"{panel.title}: " + ", ".join(f"{n} {_median(v)}" for n, v in zip(panel.names, panel.values, strict=True))
        for panel in panels
    )
    title = "Initial contact area by specimen and by angle"
    return _drawing(runs, "fig08_initial_area", title, caption + _BOXES, f"Medians. {told}.", figure)


def _by_angle(found: Discrimination, condition: str) -> AreaPanel | None:
    of, table = found.area_by_angle, found.table
    if of is None or condition not in of.conditions:
        return None
    designs = _of(found, condition)
    values = table.start_area[found.table.algorithm]
    p = of.pairs.dunn.p[of.conditions.index(condition)]
    places = {float(angle): place for place, angle in enumerate(table.angles_deg[designs].tolist())}
    bars = [
        PairBar(places[ends[0]], places[ends[1]], float(p[q]))
        for q in range(p.size)
        if (ends := (float(of.angles_deg[of.pairs.first[q]]), float(of.angles_deg[of.pairs.second[q]])))
        and set(ends) <= set(places)
    ]
    names = [f"{table.angles_deg[i]:g}°" for i in designs]
    pooled = [_finite(values[i, table.known].ravel()) for i in designs]
    return AreaPanel("by angle", names, pooled, [POOLED] * len(designs), bars)


def _contacts(runs: Sequence[RunScores], found: Discrimination) -> Drawing | None:
    table = found.table
    designs = _of(found, RIGID) or _of(found, table.conditions[0])
    of = {(run.specimen, run.angle_deg, run.condition): run.picture for run in runs}
    known = [table.specimens[i] for i in table.known]
    for specimen in known:
        pictures = [(i, of.get((specimen, float(table.angles_deg[i]), table.conditions[i]))) for i in designs]
        shown = [(f"{table.angles_deg[i]:g}°", picture) for i, picture in pictures if picture is not None]
        if len(shown) == len(designs):
            break
    if not shown:
        return None
    unit = area_unit(table.area_unit)
    figure = draw_contacts(shown, unit)
    told = "; ".join(f"{title}: {number(picture.area_mm2)} {unit}" for title, picture in shown)
    caption = (
        f"Fig. 9. First contact on {specimen}, {table.conditions[designs[0]]}, with A_c0. Hexagons cover the pins "
        "counted as in contact, one pin each; the area is the algorithm's and need not be theirs."
    )
    return _drawing(runs, "fig09_first_contact", "First contact at each angle", caption, told + ".", figure)


def _rates(
    runs: Sequence[RunScores], found: Discrimination, looks: Mapping[str, Look], name: str, number_: str, what: str,
    designs: Sequence[int],
) -> Drawing | None:  # fmt: skip
    if not designs:
        return None
    table, unit = found.table, area_unit(found.table.area_unit)
    rows = [(design_name(table, i), _series(runs, found, looks, i)) for i in designs]
    figure = draw_rates(rows, unit)
    told = "; ".join(
        f"{title}: " + ", ".join(f"{each.name} {_median(each.casr)}" for each in row) for title, row in rows
    )
    specimens = listed(list(dict.fromkeys(each.name for _, row in rows for each in row)))
    caption = f"Fig. {number_}. CASR of {specimens}, {what}. {_RAW} {_BOXES}"
    title = f"Contact area against force and CASR, {what}"
    return _drawing(runs, name, title, caption, f"Median CASR in {unit}/N. {told}.", figure)


def _series(
    runs: Sequence[RunScores], found: Discrimination, looks: Mapping[str, Look], design: int
) -> list[RateSeries]:
    table, series = found.table, []
    scores = table.casr[found.table.algorithm][design]
    for place, specimen in enumerate(table.specimens):
        of = (specimen, table.conditions[design], float(table.angles_deg[design]))
        run = next((run for run in runs if (run.specimen, run.condition, run.angle_deg) == of), None)
        if run is not None:
            force = np.concatenate([curve.force_n for curve in run.curves] or [np.empty(0)])
            area = np.concatenate([curve.area_mm2 for curve in run.curves] or [np.empty(0)])
            series.append(RateSeries(specimen, looks[specimen], force, area, _finite(scores[place])))
    return series


def _conditions(runs: Sequence[RunScores], found: Discrimination, looks: Mapping[str, Look]) -> Drawing | None:
    table, unit = found.table, area_unit(found.table.area_unit)
    values = table.casr[found.table.algorithm]
    both = [(i, table.design(HUMAN_LIKE, float(table.angles_deg[i]))) for i in _of(found, RIGID)]
    panels = [
        (
            f"{table.angles_deg[rigid]:g}°",
            [
                ConditionBoxes(name, looks[name], _finite(values[rigid, j]), _finite(values[human, j]))
                for j, name in enumerate(table.specimens)
            ],
        )
        for rigid, human in both
        if human >= 0
    ]
    if not panels:
        return None
    told = "; ".join(
        f"{title}: " + ", ".join(f"{b.name} {_median(b.rigid)} and {_median(b.human_like)}" for b in boxes)
        for title, boxes in panels
    )
    caption = (
        f"Fig. 14. CASR with the rigid motor (left, hollow) and human-like stiffness (right, filled), "
        f"{found.table.algorithm} algorithm at every angle. {_BOXES}"
    )
    title = "CASR with rigid and human-like stiffness"
    figure = draw_conditions(panels, unit)
    return _drawing(runs, "fig14_conditions", title, caption, f"Median CASR in {unit}/N. {told}.", figure)


def _calibration(found: CalibrationResults, algorithm: str, looks: Mapping[str, Look]) -> Drawing | None:
    """The calibration of every angle and condition by one vision algorithm."""
    panels = [
        (f"{each.condition}, {each.angle_deg:g}°", each, each.algorithms[algorithm])
        for each in found.conditions
        if algorithm in each.algorithms
    ]
    if not panels:
        return None
    new = found.new_specimen
    figure = draw_calibrations(panels, looks, new, found.known_kappa_new)
    law = panels[0][2].chosen.law
    origin = f" {SIMULATED}" if any(each.simulated for each in found.conditions) else ""
    caption = (
        f"Calibration. Stiffness against CASR by the {algorithm} algorithm: pale marks are presses, others their "
        f"means, the full line the {law} law, the dotted one the paper's exponential. {new} is read off the full "
        f"line, with the interval from repeated presses.{origin}"
    )
    told = "; ".join(
        f"{title}: {number(of.chosen.kappa)} N/mm, {number(of.chosen.low)} to {number(of.chosen.high)}"
        for title, _, of in panels
    )
    title = f"Calibration, and stiffness of {new}"
    return Drawing("figcal_calibration", title, caption, f"{told}.{origin}", figure, None)


def _finite(values: Floats) -> Floats:
    return np.asarray(values[np.isfinite(values)])


def _median(values: Floats) -> str:
    return number(float(np.median(values))) if values.size else "none"
