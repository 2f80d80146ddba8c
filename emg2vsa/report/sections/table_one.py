"""Table I of the paper beside ours: the error on the stiffness of the new specimen by vision algorithm and actuator."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from casr.kappa.posterior import DETERMINED
from emg2vsa.calibration.results import CalibrationResults, Headline
from emg2vsa.claims import paper
from emg2vsa.claims.kappa import PINS
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr import Estimate, draw_estimates
from emg2vsa.figures.palette import BLUE, INK, Look
from emg2vsa.report import designs
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.table import Cell, Column, Columns, Table, table_of
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, ends, number, signed
from emg2vsa.settings import PAPER

_ACTUATORS = (
    (RIGID, "rigid", "Rigid", Look(INK, "o", "-")),
    (HUMAN_LIKE, "human_like", "Human-like", Look(BLUE, "s", "-")),
)
"""Condition, key, head and look of the two halves of Table I."""
PRINTED = {
    ("circle", RIGID): ("old_vision", paper.ERROR_OLD_VISION),
    ("paper", RIGID): ("new_vision", paper.ERROR_NEW_VISION),
    ("paper", HUMAN_LIKE): ("human_like", paper.ERROR_HUMAN_LIKE),
}
"""Vision algorithm and condition to the key and the errors of a column of the paper's Table I."""
ALGORITHM_NAMES = {
    "circle": "circle (previous)", "paper": "{area_rule} (paper)", "hexagon": "filled hexagon (ours)",
    "edge": "edge (ours)", "front": "front (ours)", PINS: "field of pins (ours)",
}  # fmt: skip


def _name(results: StudyResults, algorithm: str) -> str:
    """Name of the algorithm; that of "paper" by its area rule, which a key of the study can set: hexagon (paper)
    unless it does.
    """
    if algorithm == PINS:
        return ALGORITHM_NAMES[PINS]
    rule = results.study.scoring.recipe_of(algorithm).area_rule
    return ALGORITHM_NAMES[algorithm].format(area_rule="hexagon" if rule == "paper" else rule)


def _compared(results: StudyResults) -> tuple[str, ...]:
    study = results.study
    return tuple(dict.fromkeys((study.discrimination.old_algorithm, "paper", "front", study.scoring.algorithm)))


def _by_pins(found: CalibrationResults) -> tuple[str, ...]:
    return (PINS,) if any(each.pins for each in found.conditions) else ()


def _estimate(found: CalibrationResults, condition: str, angle_deg: float, name: str) -> Headline | None:
    """Estimate of a vision algorithm by the law of the study, or by the pins."""
    if name != PINS:
        return found.law(condition, angle_deg, name)
    design = found.find(angle_deg, condition)
    return design.pins if design else None


def _angles(found: CalibrationResults) -> list[float]:
    ours = {each.angle_deg for each in found.conditions if each.condition in (RIGID, HUMAN_LIKE)}
    return sorted(ours | set(paper.ANGLES_DEG))


def _printed(condition: str, angle_deg: float, algorithm: str) -> float:
    """The paper's error as a share, NaN where it has none."""
    return PRINTED.get((algorithm, condition), ("", {}))[1].get(angle_deg, np.nan)


def _over_array(results: StudyResults, condition: str, angle_deg: float, algorithm: str) -> tuple[float, int, int]:
    """Largest area over that of the pin array, of the presses that have no CASR for it; how many, of how many."""
    runs = [run for run in results.pressed.scores if (run.angle_deg, run.condition) == (angle_deg, condition)]
    every = np.concatenate([np.empty(0), *(run.over_array[algorithm] for run in runs if algorithm in run.over_array)])
    over = every[np.isfinite(every)]
    return (float(over.max()) if over.size else np.nan), over.size, every.size


def tables(results: StudyResults, found: CalibrationResults) -> Iterator[Table]:
    """Table I, and how each of its algorithms scores a press."""
    compared, settings, angles = _compared(results), results.study.calibration, _angles(found)
    rows = [(angle, name) for angle in angles for name in (*compared, *_by_pins(found))]
    # the exponential law of the paper, and that of the study where it is another
    laws = [("_same", "paper's law"), ("", "law of this study")]
    if all(getattr(settings, key) == value for key, value in PAPER["calibration"].items()):
        laws.pop()
    names = [_name(results, name) for _, name in rows]
    columns: Columns = {
        Column("angle_deg", "Angle (°)", digits=2): [angle for angle, _ in rows],
        Column("algorithm", "Vision algorithm"): names,
    }
    told: dict[str, list[Cell]] = {"algorithm": [name.replace(" ", NO_BREAK) for name in names]}
    beyond = {(c, *row): _over_array(results, c, *row) for row in rows for c, *_ in _ACTUATORS}
    for condition, key, head, _ in _ACTUATORS:
        printed = Column(f"{key}_paper", f"{head}: paper (%)", 100.0, 2)
        columns[printed] = [_printed(condition, *row) for row in rows]
        at = [(found.find(angle, condition), name) for angle, name in rows]
        of_paper = [of.algorithms[name].paper if of and name in of.algorithms else None for of, name in at]
        ours = [_estimate(found, condition, *row) for row in rows]
        for end, law in laws:
            by: Sequence[Headline | None] = of_paper if end else ours
            columns[Column(f"{key}{end}", f"{head}: here, {law} (%)", 100.0)] = [o.error if o else np.nan for o in by]
            told[f"{key}{end}"] = [
                _error_said(of, found.known_kappa_new, beyond[condition, *row][0]) if of else None
                for of, row in zip(by, rows, strict=True)
            ]
    made = table_of("table_one", "", columns)
    shown = tuple(row | {key: cells[i] for key, cells in told.items()} for i, row in enumerate(map(dict, made.rows)))
    yield replace(made, caption=_caption(results, found, compared, beyond), shown_rows=shown)
    yield _recipes(results, compared)


def _caption(
    results: StudyResults, found: CalibrationResults, compared: Sequence[str],
    beyond: Mapping[tuple[str, float, str], tuple[float, int, int]],
) -> str:  # fmt: skip
    """What the errors are, and which presses have none. beyond : see ``_over_array``."""
    over = results.study.scoring.force_n
    caption = (
        f"Table I: error on κ of {found.new_specimen} ({number(found.known_kappa_new)} N/mm) over the forces of CASR, "
        f"{over[0]:g} to {over[1]:g} N. Ours have a sign, plus "
        "for too stiff, and an interval. Not determined: so few presses and mountings promise an interval wider than "
        f"the range of the known stiffnesses ({ALGORITHM_NAMES[PINS]}: a half width above {100 * DETERMINED:g} %), or "
        "the law rises or explains nothing. –: not in the paper or not pressed"
    )
    start = ". Presses with areas above that of the pin array have no CASR: "
    for name in compared:
        ratios, lost, presses = zip(*(of for key, of in beyond.items() if key[-1] == name), strict=True)
        if sum(lost):
            caption += f"{start}{_name(results, name)}, {sum(lost)} of {sum(presses)}, up to "
            caption, start = f"{caption}{number(np.nanmax(ratios), 2)} × the pin array", "; "
    return caption


def _error_said(law: Headline, truth: float, over_array: float) -> str:
    """The error with its interval; in its place the largest area over that of the pin array, where areas beyond it
    leave no κ."""
    if np.isnan(law.kappa) and over_array == over_array:
        return f"areas up to {number(over_array, 2)} × the pin array"
    if not law.determined or np.isnan([law.low, law.high]).any():
        return "not determined"
    if truth != truth:
        return UNDEFINED
    error, *interval = _errors(law, truth)
    return f"{signed(error)} {ends(*interval)}"


def picture(results: StudyResults, found: CalibrationResults) -> Drawing:
    """Table I as a plot: a panel for each angle, a row for each algorithm and actuator."""
    truth, panels, told = found.known_kappa_new, [], []
    for angle in _angles(found):
        rows = []
        for name in (*_compared(results), *_by_pins(found)):
            for condition, _, head, look in _ACTUATORS:
                law, printed = _estimate(found, condition, angle, name), 100 * _printed(condition, angle, name)
                errors, known = (_errors(law, truth), law.determined) if law else ((np.nan,) * 3, False)
                rows.append(Estimate(f"{name}, {head.lower()}", *errors, known, look, printed))
        panels.append((f"{angle:g}°", rows))
        said = [f"{row.name} {signed(row.value)}{'' if row.determined else ' (not determined)'}" for row in rows]
        told.append(f"{angle:g}°: {', '.join(said)}")
    figure = draw_estimates(panels, "Error on κ (%)", 0.0)
    caption = (
        f"Table I as a plot: error on κ of {found.new_specimen} by the study's law through CASR, and by the pins, with "
        f"{100 * results.study.calibration.confidence:g} % intervals. "
        "Brackets: the paper's, printed without sign; hollow: not determined; no mark: no estimate, or not pressed."
    )
    title = "Table I: error on the stiffness of the new specimen"
    said_all = f"Known: {number(truth)} N/mm. {'; '.join(told)}."
    return designs.drawing(results, "figtable1_errors", title, caption, said_all, figure)


def _errors(law: Headline, truth: float) -> tuple[float, float, float]:
    """Percent: error, low and high."""
    return 100 * law.error, 100 * (law.low / truth - 1), 100 * (law.high / truth - 1)


_STEPS = {
    "edge": "edge of the contact", "hexagon": "hexagons, filled", "circle": "circle",
    "pin-affine": "motion of the pins", "horn-schunck": "dense, Horn and Schunck", "dis": "dense, DIS",
    "exposure": "at exposure", "mean": "mean of its rows", "ode": "A_c0 exp(Σ growth)",
    "power": "mean slope of a power law", "slope": "slope of a line",
}  # fmt: skip
_AS_PRINTED = {"area_rule": "hexagons of Algorithm 1", "law": "equation (1)", "rate": "equation (2)"}


_STEP_HEADS = {
    "area_rule": "Initial area", "engine": "Growth", "force_rule": "Force of a frame", "law": "Area", "rate": "CASR",
}  # fmt: skip


def _recipes(results: StudyResults, algorithms: Sequence[str]) -> Table:
    """Every step of the algorithms that are compared, by the name of its setting."""
    settings = results.study.scoring
    told = []
    for name in algorithms:
        recipe = settings.recipe_of(name)._asdict()
        steps = {key: _AS_PRINTED[key] if recipe[key] == "paper" else _STEPS[recipe[key]] for key in _STEP_HEADS}
        if recipe["region"] == "image":
            steps["engine"] += ", whole image"
        if name == "front":
            steps |= {"area_rule": "front in every frame", "engine": UNDEFINED, "law": UNDEFINED}
        told.append(steps)
    low, high = settings.force_n
    columns: Columns = {
        Column("algorithm", "Vision algorithm"): [_name(results, name) for name in algorithms],
        **{Column(key, head): [steps[key] for steps in told] for key, head in _STEP_HEADS.items()},
        Column("force_low_n", "From (N)"): [low] * len(told),
        Column("force_high_n", "To (N)"): [high] * len(told),
    }
    return table_of("recipes", "How each vision algorithm scores a press", columns)
