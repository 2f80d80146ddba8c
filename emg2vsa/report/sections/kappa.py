"""Stiffness of the new specimen: Table I beside the paper's, and every estimate with its interval."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, ConditionResult, LawResult
from emg2vsa.claims import paper
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr import draw_calibrations
from emg2vsa.report.designs import DESIGN, looks, of_kappa
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.table import Cell, Column, Columns, Table, table_of
from emg2vsa.report.wording import NO_BREAK, SIMULATED, UNDEFINED, ends, interval, number, signed
from emg2vsa.settings import PAPER

ACTUATORS = ((RIGID, "rigid", "Rigid"), (HUMAN_LIKE, "human_like", "Human-like"))
"""Condition, key and head of the two halves of Table I."""
PRINTED = {
    ("circle", RIGID): ("old_vision", paper.ERROR_OLD_VISION),
    ("paper", RIGID): ("new_vision", paper.ERROR_NEW_VISION),
    ("paper", HUMAN_LIKE): ("human_like", paper.ERROR_HUMAN_LIKE),
}
"""Vision algorithm and condition to the key and the errors of a column of the paper's Table I."""
ALGORITHM_NAMES = {
    "circle": "circle (previous)",
    "paper": "{area_rule} (paper)",
    "hexagon": "filled hexagon (ours)",
    "edge": "edge (ours)",
    "front": "front (ours)",
}


def _name(results: StudyResults, algorithm: str) -> str:
    """That of "paper" by its area rule, which a key of the study can set: hexagon (paper) unless it does."""
    rule = results.study.scoring.recipe_of(algorithm).area_rule
    return ALGORITHM_NAMES[algorithm].format(area_rule="hexagon" if rule == "paper" else rule)


ADVANCING_FRONT_ERROR = 0.096
"""Median error of κ from one press in the world whose contact is a front alone (benchmarks/results/press_worlds)."""
LAW_ERRORS = (-0.086, 0.108)
"""Least and largest median error of κ by the true CASR, over simulated sensors: benchmarks/results/press_worlds."""


def _found(results: StudyResults) -> CalibrationResults:
    found = results.pressed.calibration
    assert found is not None
    return found


def _own(results: StudyResults) -> tuple[str, list[tuple[ConditionResult, AlgorithmResult]]]:
    """The algorithm that counts, and what it gives in every condition."""
    name = results.study.scoring.algorithm
    return name, [(each, each.algorithms[name]) for each in _found(results).conditions if name in each.algorithms]


def _design(each: ConditionResult) -> str:
    return f"{each.condition}, {each.angle_deg:g}°"


def _quantities(results: StudyResults) -> Items:
    for vision, errors in PRINTED.values():
        for angle, error in errors.items():
            yield f"paper.kappa_error.{vision}.{angle:g}", error
    for condition, error in paper.ERROR_CONSTANT.items():
        yield f"paper.kappa_error.{condition}.0", error
    for condition, r2 in paper.WORST_ADJ_R2.items():
        yield f"paper.{condition}.worst_adj_r2", r2
    for angle, (p, q) in paper.CURVES.items():
        yield f"paper.modular.{angle:g}.curve.level_n_per_mm", p
        yield f"paper.modular.{angle:g}.curve.rate", q
    found = _found(results)
    yield "runs.kappa.new_specimen", found.new_specimen
    yield "runs.kappa.known_n_per_mm", found.known_kappa_new
    yield "runs.kappa.advancing_front_error", ADVANCING_FRONT_ERROR
    yield "runs.kappa.mounting_sd_percent", results.study.calibration.mounting_sd_percent
    for each in found.conditions:
        for name, of in each.algorithms.items():
            yield from _algorithm(f"runs.{each.condition}.{each.angle_deg:g}.{name}.kappa", of)


def _algorithm(name: str, of: AlgorithmResult) -> Items:
    for prefix, law in ((name, of.chosen), (f"{name}.paper_law", of.paper)):
        yield from with_interval(f"{prefix}.n_per_mm", law.kappa, law.low, law.high)
        yield from fields_of(prefix, law, "determined", "widened", "law_p", "serial_p", "effective_presses")
        yield from fields_of(prefix, law, "mounting_freedom", "error", "adj_r2", "law")
        yield f"{prefix}.percent_per_percent_casr", law.amplification
        yield f"{prefix}.mounting_sd_percent", 100 * law.mounting_sd
        for key, value in zip(("first", "second"), law.parameters, strict=True):
            yield f"{prefix}.parameter.{key}", value
    for law_name, rms in of.left_out_rms.items():
        yield f"{name}.left_out_rms.{law_name}", rms
    if of.fused is not None:
        yield f"{name}.fused.n_per_mm", of.fused.kappa
        yield from fields_of(f"{name}.fused", of.fused, "error", "weight")


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found, settings = _found(results), results.study.calibration
    algorithms = (results.study.discrimination.old_algorithm, "paper", "front", results.study.scoring.algorithm)
    compared = tuple(dict.fromkeys(algorithms))
    ours = {each.angle_deg for each in found.conditions if each.condition in (RIGID, HUMAN_LIKE)}
    designs = [(angle, name) for angle in sorted(ours | set(paper.ANGLES_DEG)) for name in compared]
    same = all(getattr(settings, key) == value for key, value in PAPER["calibration"].items())
    laws = (_PAPERS,) if same else (_PAPERS, _OURS)
    yield _table_one(results, designs, laws)
    yield _recipes(results, compared)
    yield _every(results)
    yield _laws(results)


def _at(found: CalibrationResults, angle_deg: float, condition: str, algorithm: str) -> AlgorithmResult | None:
    each = found.find(angle_deg, condition)
    return each.algorithms.get(algorithm) if each else None


_Designs = Sequence[tuple[float, str]]
"""Angle and vision algorithm of every row."""
_PAPERS, _OURS = ("_same", "paper's law"), ("", "law of this study")
"""End of a key and name: the exponential law of the paper, and that of the study where it is another."""


_Laws = Sequence[tuple[str, str]]


def _by(of: AlgorithmResult, law: tuple[str, str]) -> LawResult:
    return of.paper if law is _PAPERS else of.chosen


def _first(results: StudyResults, designs: _Designs) -> Columns:
    return {
        Column("angle_deg", "Angle (°)", digits=2): [angle for angle, _ in designs],
        Column("algorithm", "Vision algorithm"): [_name(results, name) for _, name in designs],
    }


def _over_array(results: StudyResults, angle_deg: float, condition: str, algorithm: str) -> tuple[float, int, int]:
    """Largest area over that of the pin array, of the presses that have no CASR for it; how many, of how many."""
    runs = [run for run in results.pressed.scores if (run.angle_deg, run.condition) == (angle_deg, condition)]
    every = np.concatenate([np.empty(0), *(run.over_array[algorithm] for run in runs if algorithm in run.over_array)])
    over = every[np.isfinite(every)]
    return (float(over.max()) if over.size else np.nan), over.size, every.size


def _table_one(results: StudyResults, designs: _Designs, laws: _Laws) -> Table:
    found, columns, said = _found(results), _first(results, designs), dict[str, list[Cell]]()
    for condition, key, head in ACTUATORS:
        printed = [PRINTED.get((name, condition), ("", {}))[1].get(angle, np.nan) for angle, name in designs]
        columns[Column(f"{key}_paper", f"{head}: paper (%)", 100.0, 2)] = printed
        for law in laws:
            column = Column(f"{key}{law[0]}", f"{head}: here, {law[1]} (%)", 100.0)
            each = [_at(found, angle, condition, name) for angle, name in designs]
            columns[column] = [_by(of, law).error if of else np.nan for of in each]
            said[column.key] = [
                _error_said(_by(of, law), found.known_kappa_new, _over_array(results, angle, condition, name)[0])
                if of
                else None
                for of, (angle, name) in zip(each, designs, strict=True)
            ]
    made = table_of("table_one", "", columns)
    said["algorithm"] = [str(row["algorithm"]).replace(" ", NO_BREAK) for row in made.rows]
    shown = tuple(row | {key: cells[i] for key, cells in said.items()} for i, row in enumerate(map(dict, made.rows)))
    caption = (
        f"Table I: error on κ of {found.new_specimen} ({number(found.known_kappa_new)} N/mm). Ours have a sign, plus "
        "for too stiff, and an interval. Not determined: so few presses and mountings promise an interval wider than "
        "the range of the known stiffnesses, or the law rises or explains nothing. –: not in the paper or not pressed"
    )
    if told := list(_beyond(results, designs)):
        caption += f". Presses with areas above that of the pin array have no CASR: {'; '.join(told)}"
    return replace(made, caption=caption, shown_rows=shown)


def _beyond(results: StudyResults, designs: _Designs) -> Iterator[str]:
    """Of every algorithm that lost presses in this way, how many."""
    angles = {angle for angle, _ in designs}
    for name in dict.fromkeys(name for _, name in designs):
        each = [_over_array(results, angle, condition, name) for angle in angles for condition, *_ in ACTUATORS]
        if lost := sum(n for _, n, _ in each):
            most = np.nanmax([ratio for ratio, *_ in each])
            presses = sum(n for *_, n in each)
            yield f"{_name(results, name)}, {lost} of {presses}, up to {number(most, 2)} × the pin array"


def _error_said(law: LawResult, truth: float, over_array: float) -> str:
    """The error with its interval; in its place the largest area over that of the pin array, where areas beyond it
    leave no κ."""
    if np.isnan(law.kappa) and over_array == over_array:
        return f"areas up to {number(over_array, 2)} × the pin array"
    if not law.determined or np.isnan([law.low, law.high]).any():
        return "not determined"
    if truth != truth:
        return UNDEFINED
    return f"{signed(100 * law.error)} {ends(*(100 * (end / truth - 1) for end in (law.low, law.high)))}"


_STEPS = {
    "edge": "edge of the contact", "hexagon": "hexagons, filled", "circle": "circle",
    "pin-affine": "motion of the pins", "horn-schunck": "dense, Horn and Schunck", "dis": "dense, DIS",
    "exposure": "at exposure", "mean": "mean of its rows", "ode": "A_c0 exp(Σ growth)",
    "power": "mean slope of a power law", "slope": "slope of a line",
}  # fmt: skip
_AS_PRINTED = {"area_rule": "hexagons of Algorithm 1", "law": "equation (1)", "rate": "equation (2)"}


_STEP_HEADS = {"area_rule": "Initial area", "engine": "Growth", "force_rule": "Force of a frame", "law": "Area"}
_STEP_HEADS |= {"rate": "CASR"}


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


def span(law: LawResult) -> str:
    """``5.31 [5.20, 5.42]``, or that the presses determine no κ, and why."""
    if np.isnan(law.kappa):
        return "none: CASR does not follow κ in one direction, or no score"
    if np.isnan([law.low, law.high]).any():
        return f"{number(law.kappa)}, no interval: not determined"
    return f"{interval(law.kappa, law.low, law.high)}{'' if law.determined else ': not determined'}"


def holds(of: AlgorithmResult, truth: float) -> bool | None:
    """Whether the interval holds the known stiffness; None where either is missing or κ is not determined."""
    low, high = of.chosen.low, of.chosen.high
    if not of.chosen.determined or np.isnan([low, truth, high]).any():
        return None
    return bool(low <= truth <= high)


def _every(results: StudyResults) -> Table:
    found, (algorithm, own) = _found(results), _own(results)
    printed = [
        paper.WORST_ADJ_R2.get(each.condition) if (each.condition, each.angle_deg) in paper.DESIGNS else None
        for each, _ in own
    ]
    columns: Columns = {
        DESIGN: [_design(each) for each, _ in own],
        Column("paper_error", "Paper's error, hexagon (%)", 100.0): [_paper_error(each) for each, _ in own],
        Column("exponential_error", "Error here, paper's law (%)", 100.0): [of.paper.error for _, of in own],
        Column("paper_adj_r2", "Paper's worst adj. R²", digits=4): printed,
        Column("adj_r2", "adj. R² here, paper's law", digits=4): [of.paper.adj_r2 for _, of in own],
        Column("kappa_n_per_mm", "κ (N/mm)"): [of.chosen.kappa for _, of in own],
        Column("low", "Low"): [of.chosen.low for _, of in own],
        Column("high", "High"): [of.chosen.high for _, of in own],
        Column("determined", "Determined"): [bool(of.chosen.determined) for _, of in own],
        Column("error", "Error (%)", 100.0): [of.chosen.error for _, of in own],
        Column("holds", "Interval holds κ"): [holds(of, found.known_kappa_new) for _, of in own],
        Column("per_percent", "1 % of CASR is (% of κ)"): [of.chosen.amplification for _, of in own],
        Column("mountings", "SD between mountings (%)"): [_mountings(of.chosen) for _, of in own],
        Column("fused_error", "With indentation: error (%)", 100.0): [
            of.fused.error if of.fused else None for _, of in own
        ],
    }
    caption = (
        f"κ of {found.new_specimen} by the {algorithm} algorithm; the interval holds what every law says that the "
        "known specimens do not reject"
    )
    return table_of("kappa_new", caption, columns)


def _mountings(law: LawResult) -> str:
    return f"{number(100 * law.mounting_sd)}, {'estimated' if law.mounting_freedom else 'assumed'}"


def _laws(results: StudyResults) -> Table:
    _, own = _own(results)
    curves = {angle: f"kappa = {p:g} exp({q:g} CASR)" for angle, (p, q) in paper.CURVES.items()}
    columns: Columns = {
        DESIGN: [_design(each) for each, _ in own],
        Column("chosen", "Law here"): [_equation(of.chosen) for _, of in own],
        Column("paper_law", "Paper's law here"): [_equation(of.paper) for _, of in own],
        Column("left_out", "Best on left-out specimens"): [of.best_law or None for _, of in own],
        Column("paper", "Paper's curve (unit of CASR not printed)"): [
            curves.get(each.angle_deg) if each.condition == HUMAN_LIKE else None for each, _ in own
        ],
    }
    return table_of("calibration_laws", "The laws from CASR to stiffness", columns)


def _equation(law: LawResult) -> str | None:
    return law.equation if np.isfinite(law.parameters).all() else None


def _paper_error(each: ConditionResult) -> float | None:
    condition, angle_deg = each.condition, each.angle_deg
    if condition in paper.ERROR_CONSTANT and (condition, angle_deg) in paper.DESIGNS:
        return paper.ERROR_CONSTANT[condition]
    return {RIGID: paper.ERROR_NEW_VISION, HUMAN_LIKE: paper.ERROR_HUMAN_LIKE}.get(condition, {}).get(angle_deg)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    """The calibration of every angle and condition by one vision algorithm."""
    found, (algorithm, own) = _found(results), _own(results)
    if not own:
        return
    new = found.new_specimen
    panels = [(_design(each), each, of) for each, of in own]
    figure = draw_calibrations(panels, looks(results), new, found.known_kappa_new)
    origin = f" {SIMULATED}" if any(each.simulated for each in found.conditions) else ""
    caption = (
        f"Fig. C1. Calibration: stiffness against CASR by the {algorithm} algorithm; pale marks are presses, others "
        f"their means, the full line the {own[0][1].chosen.law} law, the dotted one the paper's exponential. {new} is "
        f"read off the full line.{origin}"
    )
    told = "; ".join(f"{title}: {span(of.chosen)} N/mm" for title, _, of in panels)
    yield Drawing(
        "figcal_calibration", f"Calibration, and stiffness of {new}", caption, f"{told}.{origin}", figure, None
    )


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found, (algorithm, own) = _found(results), _own(results)
    notes: dict[str, list[str]] = {}
    for each, of in own:
        for note in of.chosen.notes:
            notes.setdefault(note, []).append(_design(each))
    told = [f"{n} ({'every design' if len(of) == len(own) else '; '.join(of)})" for n, of in notes.items()]
    held = [holds(of, found.known_kappa_new) for _, of in own]
    return {
        "notes": [*told, *found.notes],
        "algorithm": algorithm,
        "designs": len(own),
        "determined": sum(of.chosen.determined for _, of in own),
        "held": held.count(True),
        "of_held": len(held) - held.count(None),
        "truth_known": found.known_kappa_new == found.known_kappa_new,
        "new": found.new_specimen,
        "mountings_assumed": any(of.chosen.mounting_freedom == 0 for _, of in own),
        "law_errors": [100 * error for error in LAW_ERRORS],
    }


_TEXT = """
<p>{% if not truth_known %}
The stiffness of {{ new }} is not known, so that no error can be stated.
{% elif runs.simulated and study.calibration.law == "compliance" %}
Sensor and specimen yield in series in the law of this study and in the simulated world, so a small error is no evidence
for that law. By the true CASR of other simulated sensors it is {{ law_errors[0] | signed }} to
{{ law_errors[1] | signed }} % off.
{% endif %}</p>
{{ folded("table_one", "Table I of the paper beside ours") }}
<p>By {{ algorithm }}, κ is determined in {{ determined }} of {{ designs }} designs{% if of_held %}, and in {{ held }}
of these the interval holds the known stiffness{% endif %}.
{% if mountings_assumed %}The intervals assume an SD of
{{ q['runs.kappa.mounting_sd_percent'] | number(2) }} % of CASR between mountings, because too few were repeated to show
it.{% else %}The intervals include the scatter of CASR between mountings that repeated mountings show.{% endif %}
No interval knows of a law that fails between the known specimens alone.</p>
{{ folded("recipes", "How each algorithm scores a press") }}
{{ folded("kappa_new", "κ in every design") }}
{{ folded("calibration_laws", "The fitted laws") }}
{{ folded("figcal_calibration", "Figure C1: calibration of every design") }}
{% if notes %}
<details><summary>Notes on the estimates</summary>{{ notes | bullets }}</details>
{% endif %}
"""

KAPPA = Section("kappa", "Stiffness of the new specimen", _TEXT, of_kappa, _quantities, _tables, _drawings, _words)
