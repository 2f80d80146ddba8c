"""Stiffness of the new specimen: every estimate with its interval, and the paper's curves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from casr.kappa.posterior import DETERMINED
from emg2vsa.calibration.results import AlgorithmResult, CalibrationResults, ConditionResult, Headline, LawResult
from emg2vsa.claims import paper
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.figures.casr import Estimate, draw_calibrations, draw_estimates
from emg2vsa.report import designs
from emg2vsa.report.designs import of_kappa
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, fields_of, named, with_interval
from emg2vsa.report.section import Quantities, Section
from emg2vsa.report.sections import table_one
from emg2vsa.report.table import Cell, Column, Columns, Table, table_of
from emg2vsa.report.wording import interval, number

_STIFFEST, *_, _SOFTEST = paper.KAPPA_N_PER_MM
CUES = {"pins": "pins alone", "force": "force alone", "travel": "travel alone"}
"""Cues of ``casr.kappa`` to what people call them."""
_COLUMN = {RIGID: "new_vision", HUMAN_LIKE: "human_like"}
"""Column of Table I, by hexagons, in which each condition stands."""
_CURVES = {angle: f"{p:g} exp({rate:g} CASR)" for angle, (p, rate) in paper.CURVES.items()}
"""The paper's, by angle."""
LAW_ERRORS = (-0.154, 0.065)
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
    for vision, errors in table_one.PRINTED.values():
        for angle, error in errors.items():
            yield f"paper.kappa_error.{vision}.{angle:g}", error
    for condition, error in paper.ERROR_CONSTANT.items():
        yield f"paper.kappa_error.{condition}.0", error
    for condition, r2 in paper.WORST_ADJ_R2.items():
        yield f"paper.{condition}.worst_adj_r2", r2
    for angle, (p, q) in paper.CURVES.items():
        yield f"paper.modular.{angle:g}.curve.level_n_per_mm", p
        yield f"paper.modular.{angle:g}.curve.rate", q
        for name, kappa in paper.KAPPA_N_PER_MM.items():
            yield f"paper.modular.{angle:g}.casr_implied.{name}", paper.implied_casr(angle, kappa)
        yield f"paper.modular.{angle:g}.casr_implied.ratio", paper.implied_ratio(angle)
    yield "paper.casr_ratio_bound", paper.largest_ratio()
    found = _found(results)
    yield "runs.kappa.new_specimen", found.new_specimen
    yield "runs.kappa.known_n_per_mm", found.known_kappa_new
    yield "runs.kappa.mounting_sd_percent", results.study.calibration.mounting_sd_percent
    for each in found.conditions:
        name = f"runs.{each.condition}.{each.angle_deg:g}"
        yield from _headline(f"{name}.kappa", each, results.study.scoring.algorithm)
        for algorithm, of in each.algorithms.items():
            yield from _algorithm(f"{name}.{algorithm}.kappa", of)


def _headline(name: str, each: ConditionResult, algorithm: str) -> Items:
    one = each.headline(algorithm)
    yield f"{name}.by", "pins" if each.pins else algorithm
    if one is not None:
        yield from with_interval(f"{name}.n_per_mm", one.kappa, one.low, one.high)
        yield from fields_of(name, one, "determined", "error")
    if each.pins is not None:
        yield from fields_of(name, each.pins, "expected", "bound_sd", "efficiency", "misfit", "presses")
        for cue, (kappa, sd) in each.pins.by_cue.items():
            yield from named(f"{name}.cue.{cue}", n_per_mm=kappa, sd=sd)
        for specimen, kappa in zip(each.specimens, each.pins.left_out.tolist(), strict=True):
            yield f"{name}.left_out.{specimen}", kappa


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


def span(law: Headline | None) -> str:
    """``5.31 [5.20, 5.42]``, or that the presses determine no κ, and why."""
    if law is None or np.isnan(law.kappa):
        return "none: CASR does not follow κ in one direction, or no score"
    if np.isnan([law.low, law.high]).any():
        return f"{number(law.kappa)}, no interval: not determined"
    return f"{interval(law.kappa, law.low, law.high)}{'' if law.determined else ': not determined'}"


def holds(of: Headline | None, truth: float) -> bool | None:
    """Whether the interval holds the known stiffness; None where either is missing or κ is not determined."""
    if of is None or not of.determined or np.isnan([of.low, truth, of.high]).any():
        return None
    return bool(of.low <= truth <= of.high)


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    found, (algorithm, own) = _found(results), _own(results)
    yield from table_one.tables(results, found)
    of_paper = [
        f"paper.kappa_error.{_COLUMN.get(each.condition, each.condition)}.{each.angle_deg:g}" for each, _ in own
    ]
    design: Columns = {designs.DESIGN: [_design(each) for each, _ in own]}
    level = f"{100 * results.study.calibration.confidence:g} %"
    yield _headlines(found, algorithm, [each for each, _ in own], design, level)
    caption = (
        f"κ of {found.new_specimen} by the law through CASR, {algorithm} algorithm; the interval holds what every law "
        "says that the known specimens do not reject"
    )
    columns: Columns = design | {
        Column("paper_error", "Paper's error, hexagon (%)", 100.0): list(map(q.get, of_paper)),
        Column("exponential_error", "Error here, paper's law (%)", 100.0): [of.paper.error for _, of in own],
        Column("paper_adj_r2", "Paper's worst adj. R²", digits=4): [
            paper.WORST_ADJ_R2.get(c.condition) if (c.condition, c.angle_deg) in paper.DESIGNS else None for c, _ in own
        ],
        Column("adj_r2", "adj. R² here, paper's law", digits=4): [of.paper.adj_r2 for _, of in own],
        Column("kappa_n_per_mm", "κ (N/mm)"): [of.chosen.kappa for _, of in own],
        Column("low", "Low"): [of.chosen.low for _, of in own],
        Column("high", "High"): [of.chosen.high for _, of in own],
        Column("determined", "Determined"): [bool(of.chosen.determined) for _, of in own],
        Column("error", "Error (%)", 100.0): [of.chosen.error for _, of in own],
        Column("holds", "Interval holds κ"): [holds(of.chosen, found.known_kappa_new) for _, of in own],
        Column("per_percent", "1 % of CASR is (% of κ)"): [of.chosen.amplification for _, of in own],
        Column("mountings", "SD between mountings (%)"): [
            f"{number(100 * of.chosen.mounting_sd)}, {'estimated' if of.chosen.mounting_freedom else 'assumed'}"
            for _, of in own
        ],
        Column("fused_error", "With indentation: error (%)", 100.0): [
            of.fused.error if of.fused else None for _, of in own
        ],
    }
    yield table_of("kappa_by_casr", caption, columns)
    yield _laws(own, design)
    yield _implied(results, q)


def _laws(own: list[tuple[ConditionResult, AlgorithmResult]], design: Columns) -> Table:
    """The laws of each design, ours and the paper's."""
    columns = design | {
        Column("chosen", "Law here"): [_equation(of.chosen) for _, of in own],
        Column("paper_law", "Paper's law here"): [_equation(of.paper) for _, of in own],
        Column("left_out", "Best on left-out specimens"): [of.best_law or None for _, of in own],
        Column("paper", "Paper's curve (unit of CASR not printed)"): [
            f"kappa = {_CURVES[c.angle_deg]}" if c.condition == HUMAN_LIKE and c.angle_deg in _CURVES else None
            for c, _ in own
        ],
    }
    return table_of("calibration_laws", "The laws from CASR to stiffness", columns)


def _implied(results: StudyResults, q: Quantities) -> Table:
    """What the paper's curves would make of CASR."""
    columns: Columns = {
        Column("angle_deg", "Angle (°)", digits=2): [*_CURVES],
        Column("curve", "κ (N/mm) as printed"): [*_CURVES.values()],
        **{
            Column(f"casr_{name}", f"{name}, {kappa:g} N/mm"): [paper.implied_casr(angle, kappa) for angle in _CURVES]
            for name, kappa in paper.KAPPA_N_PER_MM.items()
        },
        Column("ratio", f"{_SOFTEST} : {_STIFFEST} implied"): list(map(paper.implied_ratio, _CURVES)),
        Column("bound", "Largest possible", digits=2): [paper.largest_ratio()] * len(_CURVES),
        Column("here", f"{_SOFTEST} : {_STIFFEST} here"): [_ratio_here(results, q, angle) for angle in _CURVES],
    }
    caption = (
        "CASR of each specimen at which the paper's curves give its stiffness. No unit explains that it falls with the "
        "angle. Hertz's contact bounds the ratio, and a sensor that yields makes it smaller"
    )
    return table_of("casr_implied", caption, columns)


def _headlines(
    found: CalibrationResults, algorithm: str, designs: Sequence[ConditionResult], first: Columns, level: str
) -> Table:
    """The one estimate of every design, and what it rests on. level : of its intervals."""
    every, pins = [each.headline(algorithm) for each in designs], [each.pins for each in designs]

    def of(key: str, from_: Sequence[Headline | None] = every) -> list[Cell]:
        return [getattr(one, key) if one else None for one in from_]

    cues = [one.by_cue if one else {} for one in pins]
    columns: Columns = first | {
        Column("by", "By"): ["pins" if one else f"CASR, {algorithm}" for one in pins],
        Column("kappa_n_per_mm", "κ (N/mm)"): of("kappa"),
        Column("low", "Low"): of("low"),
        Column("high", "High"): of("high"),
        Column("determined", "Determined"): [None if one is None else bool(one.determined) for one in every],
        Column("error", "Error (%)", 100.0): of("error"),
        Column("holds", "Interval holds κ"): [holds(one, found.known_kappa_new) for one in every],
        Column("expected", "Half width expected (%)", 100.0, 2): of("expected", pins),
        Column("bound_sd", "SD by the pins' noise alone (%)", 100.0, 2): of("bound_sd", pins),
        Column("efficiency", "That over SD reached", digits=2): of("efficiency", pins),
        **{
            Column(f"by_{cue}", f"By {words} (N/mm)"): [
                f"{number(each[cue][0])} ± {number(100 * each[cue][1], 2)} %" if cue in each else None for each in cues
            ]
            for cue, words in CUES.items() if any(cue in each for each in cues)
        },
    }  # fmt: skip
    caption = (
        f"κ of {found.new_specimen}: where pins and forces would lie on domes like this sensor's, corrected by the "
        f"known specimens; its total {level} interval. κ is determined where presses and specimens "
        "promise a half width of "
        f"{100 * DETERMINED:g} % or less. The last columns are of one cue alone, with its standard error. By CASR: "
        "the pins tell none, and κ is by the law of this study"
    )
    return table_of("kappa_new", caption, columns)


def _equation(law: LawResult) -> str | None:
    return law.equation if np.isfinite(law.parameters).all() else None


def _ratio_here(results: StudyResults, q: Quantities, angle_deg: float) -> float:
    """Mean CASR of the softest over that of the stiffest of the paper's specimens; NaN where one was not pressed."""
    unit, ends = results.pressed.scores[0].area_unit, (_SOFTEST, _STIFFEST)
    if any(results.study.stiffness_n_per_mm.get(name) != paper.KAPPA_N_PER_MM[name] for name in ends):
        return np.nan
    of = [f"runs.{HUMAN_LIKE}.{angle_deg:g}.{name}.casr_{unit}_per_n.mean" for name in ends]
    softest, stiffest = (np.float64(q.get(key, np.nan)) for key in of)
    return float(softest / stiffest)


def _drawings(results: StudyResults) -> Iterator[Drawing]:
    """Estimates beside the known stiffness, Table I, and the calibration of every design."""
    found, (algorithm, own) = _found(results), _own(results)
    yield table_one.picture(results, found)
    if not own:
        return
    new, look = found.new_specimen, designs.looks(results)
    every = [(_design(each), each.headline(algorithm)) for each, _ in own]
    truth, told = found.known_kappa_new, "; ".join(f"{design}: {span(one)} N/mm" for design, one in every)
    rows = [Estimate(design, one.kappa, one.low, one.high, one.determined, look[new]) for design, one in every if one]
    known = dict(zip(own[0][0].specimens, own[0][0].known_kappa.tolist(), strict=True))
    figure = draw_estimates([("", rows)], f"κ of {new} (N/mm)", truth, known)
    caption = (
        f"Fig. C2. κ of {new} in every design, with {100 * results.study.calibration.confidence:g} % intervals, "
        "on a logarithmic axis; dashed: known κ; "
        "hollow: not determined."
    )
    title = f"Stiffness of {new} beside the known one"
    yield designs.drawing(results, "figkappa_truth", title, caption, f"Known: {number(truth)} N/mm. {told}.", figure)
    figure = draw_calibrations([(_design(each), each, of) for each, of in own], look, new, truth)
    caption = (
        f"Fig. C1. Calibration by CASR ({algorithm} algorithm), and κ of {new} by it. Full line: "
        f"{own[0][1].chosen.law} law; dotted: the paper's exponential; pale: presses."
    )
    title = f"Calibration by CASR, and stiffness of {new}"
    told = "; ".join(f"{_design(each)}: {span(of.chosen)} N/mm" for each, of in own)
    yield designs.drawing(results, "figcal_calibration", title, caption, f"{told}.", figure)


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    found, (algorithm, own) = _found(results), _own(results)
    every = [each.headline(algorithm) for each, _ in own]
    notes: dict[str, list[str]] = {}
    for each, of in own:
        of_pins = each.pins.notes if each.pins else (f"κ is by CASR, for the pins tell none: {each.no_pins}",)
        for note in (*of_pins, *(f"By CASR: {note}" for note in of.chosen.notes)):
            notes.setdefault(note, []).append(_design(each))
    told = [f"{n} ({'every design' if len(of) == len(own) else '; '.join(of)})" for n, of in notes.items()]
    return {
        "notes": [*told, *found.notes],
        "designs": len(own),
        "determined": sum(one.determined for one in every if one),
        "held": [holds(one, found.known_kappa_new) for one in every].count(True),
        "truth_known": found.known_kappa_new == found.known_kappa_new,
        "new": found.new_specimen,
        "assumed": any(of.chosen.mounting_freedom == 0 for _, of in own),
        "law_errors": [100 * error for error in LAW_ERRORS],
    }


_TEXT = """
{{ figure("figkappa_truth") }}
<p>The presses determine κ in {{ determined }} of {{ designs }} designs{% if determined and truth_known %}; in
{{ held }} of these the interval holds the known κ{% endif %}.
{% if not truth_known %}The stiffness of {{ new }} is not known, so no error can be stated. {% endif %}</p>
{{ table("kappa_new") }}
{{ figure("figtable1_errors") }}
{{ folded("table_one", "Table I of the paper beside ours") }}
{{ folded("recipes", "How each algorithm scores a press") }}
{{ figure("figcal_calibration") }}
<p>The law through CASR is a companion.
{% if assumed %}
Its intervals assume an SD of {{ q["runs.kappa.mounting_sd_percent"] | number(2) }} % of CASR between mountings.
{% endif %}
{% if truth_known and runs.simulated and study.calibration.law == "compliance" %}
On simulated sensors it errs by {{ law_errors[0] | signed }} to {{ law_errors[1] | signed }} %.
{% endif %}</p>
{{ folded("kappa_by_casr", "κ by CASR in every design") }}
{{ folded("calibration_laws", "The fitted laws") }}
{{ folded("casr_implied", "CASR that the paper's curves imply") }}
{% if notes %}
<details><summary>Notes on the estimates</summary>{{ notes | bullets }}</details>
{% endif %}
"""

KAPPA = Section("kappa", "Stiffness of the new specimen", _TEXT, of_kappa, _quantities, _tables, _drawings, _words)
