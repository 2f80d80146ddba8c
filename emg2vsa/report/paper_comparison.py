"""The numbers that the paper prints in sections IV.B and VI, and ours beside them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.discrimination import Discrimination
from emg2vsa.report.inputs import StudyResults, origin
from emg2vsa.report.quantities import activity_suffix
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.study_tables import scale_of
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.verdicts import dunn_bounds
from emg2vsa.report.wording import UNDEFINED, activity, bounded, exact_p, listed, number, percent

ANGLES_DEG = (0.0, 30.0, 45.0)
AREA_SPECIMENS_P = {0.0: 0.51, 30.0: 0.74, 45.0: 0.61}
"""Kruskal-Wallis of A_c0 between specimens."""
AREA_ANGLES_WORST_P = 3.1079e-05
CASR_WORST_P = {
    ("high-stiffness", 30.0): 0.0111,
    ("high-stiffness", 45.0): 0.0111,
    ("modular", 0.0): 0.0034,
    ("modular", 30.0): 0.0034,
    ("modular", 45.0): 0.0018,
    ("constant-min", 0.0): 0.0037,
    ("constant-mean", 0.0): 0.0018,
    ("constant-max", 0.0): 0.0018,
}
"""Between specimens; the rigid one is the worst of all its angles, that of 0° and 30° modular the worst of both."""
DESIGNS = frozenset(CASR_WORST_P)
"""Conditions and angles that section VI reports; the rigid motor at 0° is of the previous work."""
NEW_MIN_STIFFNESS_P = 0.3799
"""Of S_new against S1 at the lowest constant stiffness: the one condition that did not discriminate it."""
ERROR_OLD_VISION = {0.0: 0.06, 30.0: 0.25, 45.0: 0.28}
ERROR_NEW_VISION = {30.0: 0.07, 45.0: 0.13}
ERROR_HUMAN_LIKE = {0.0: 0.03, 30.0: 0.03, 45.0: 0.04}
"""On the stiffness of S_new, sign not printed (Table I)."""
ERROR_CONSTANT = {"constant-max": 0.0472, "constant-mean": 0.05}
WORST_ADJ_R2 = {"high-stiffness": 0.8963, "modular": 0.9753, "constant-max": 0.9849, "constant-mean": 0.9996}
"""Of the exponential law, the worst over the angles of ``DESIGNS``."""
CURVES = {0.0: (10.21, -1.567), 30.0: (14.76, -23.94), 45.0: (8.639, -58.67)}
"""kappa = p exp(q CASR) of the human-like condition: p in N/mm, q per unit of CASR, which is not printed."""
_COLUMNS = Column("quantity", "Quantity"), Column("paper", "Paper"), Column("here", "Here"), Column("mind", "Mind")


def _papers_bounds() -> tuple[float, float]:
    """Smallest worst p of Dunn's test with the paper's three groups of ten."""
    bounds = dunn_bounds(np.array([10, 10, 10]))
    assert bounds is not None
    return bounds


def paper_comparison(results: StudyResults, found: Mapping[str, Quantity]) -> Table:
    """Quantity, the paper's value, ours, and what to mind; ours is missing where its stage failed."""
    rows = [
        *_plate(results),
        *_curves(found),
        *_tests(results, found),
        *_new_specimen(results, found),
        *_design(results, found),
        *_dunn_reach(),
    ]
    caption = f"The paper's numbers beside ours ({origin(results).source})"
    return Table("paper_comparison", caption, _COLUMNS, tuple(rows))


def _plate(results: StudyResults) -> list[tuple[Cell, ...]]:
    """How straight the plate indentations are; no row where the study file does not say."""
    said = {s.name: s.plate_adjusted_r2 for s in results.study.specimens if s.plate_adjusted_r2 is not None}
    if not said:
        return []
    worst = min(said, key=lambda name: said[name])
    mind = f"{worst} is the worst; the line begins where contact is found (emg2vsa stiffness)"
    return [("worst adjusted R² of the plate indentations", ".882", number(said[worst], 3), mind)]


def _curves(found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    worst = [_share(found, f"fit.adj_r2_{stage}.min") for stage in ("samples", "bins")]
    return [
        ("fitted curves", "700", str(found["fit.curves"]), f"{found['fit.used']} used, {found['trials.total']} found"),
        (
            "worst adjusted R² of the logarithmic fit", ".832", f"{worst[0]} on samples, {worst[1]} on bins",
            "the paper does not say how smooth its curves were; R² depends on it",
        ),
    ]  # fmt: skip


def _tests(results: StudyResults, found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    tested = results.hypotheses
    if tested is None:
        return []
    normal = {kind: _of_tested(found, f"hypotheses.normality.{kind}") for kind in ("standardised", "raw", "lilliefors")}
    different = _of_tested(found, "hypotheses.between_participants")
    which = (
        f"raw N(0, 1): {normal['raw']}; Lilliefors: {normal['lilliefors']}; the paper does not say which of the first "
        "two it ran"
    )
    pair = tested.worst_pair
    whose = f"{pair}; LSD without correction; Holm {exact_p(float(found['hypotheses.worst_p.holm']))}"
    return [
        ("clusters of b that are not Gaussian", "0 of 70", f"{normal['standardised']} (standardised)", which),
        ("specimens for which participants differ", "0 of 5", different, "no difference found is not equality shown"),
        (
            f"worst p among {listed(tested.kept)}", ".0391 (S1, S3 and S5)", exact_p(tested.worst_p),
            whose if pair else "no pair could be tested",
        ),
    ]  # fmt: skip


def _dunn_reach() -> list[tuple[Cell, ...]]:
    """p that the paper prints in section VI beside what its test can give at all with three groups of ten."""
    uncorrected, corrected = map(exact_p, _papers_bounds())
    mind = (
        "three groups of ten compared by pooled mean ranks, as MATLAB's multcompare does: .0034, .0037 and .0018 "
        "cannot come from this test; .0111 is its uncorrected bound for groups that do not overlap (.01109)"
    )
    here = f"the worst pair cannot have less than {uncorrected}, or {corrected} with Bonferroni"
    return [("worst p of CASR between specimens (section VI)", ".0111, .0034, .0037 and .0018", here, mind)]


def _new_specimen(results: StudyResults, found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    if results.profiles is None or results.profiles.new is None:
        return []
    name = f"profiles.{results.profiles.new.specimen}"
    rule = results.study.profile.interpolation
    rows: list[tuple[Cell, ...]] = [
        (
            "interpolation weight of the softer neighbour",
            "0.532",
            number(float(found[f"{name}.alpha"]), 4),
            f"rule: {rule}",
        )
    ]
    if f"{name}.rmse_relative" in found:
        scale, relative = scale_of(results), float(found[f"{name}.rmse_relative"])
        rmse = activity(float(found[f"{name}.rmse{activity_suffix(results)}"]), scale)
        rows.append(
            (
                "interpolated profile against measured, RMSE", "0.0002 V (200 µV)", rmse,
                f"{percent(relative)} of the measured level; volts depend on electrodes and gain, the share does not",
            )
        )  # fmt: skip
    return rows


def _design(results: StudyResults, found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    low, high = results.study.schedule.stiffness_percent
    mapped = f"{low:g} to {high:g} %, {results.study.schedule.step_n:g} N"
    planned = f"{found['power.n14']:.3f} for 14 people and ten repetitions"
    mind = "the power to tell repetitions apart, at a correlation of .5; for five specimens it is .604, and 21 people"
    return [
        ("stiffness range and force step of the schedules", "20 to 80 %, 0.3 N", mapped, "settings, not results"),
        ("planned power", "about .80 (f = .25, α = .05)", planned.lstrip("0"), mind),
    ]


def _of_tested(found: Mapping[str, Quantity], test: str) -> str:
    return f"{found[f'{test}.significant']} of {found[f'{test}.tested']}"


def _share(found: Mapping[str, Quantity], key: str) -> str:
    return bounded(float(found.get(key, np.nan)))


def runs_comparison(found: Discrimination, numbers: Mapping[str, Quantity], simulated: bool) -> Table:
    """Quantity, the paper's value, ours, and what to mind; ours is missing where nothing was pressed."""
    source = "simulated rig" if simulated else "measured runs"
    rows = (*_areas(numbers), *_rates(found, numbers), *_new(found, numbers))
    return Table("paper_comparison_runs", f"The paper's numbers of section VI beside ours ({source})", _COLUMNS, rows)


def _areas(numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    rigid = "runs.high-stiffness"
    rows: list[tuple[Cell, ...]] = [
        (
            f"A_c0 between specimens at {angle:g}°, Kruskal-Wallis", f"p = {bounded(p, 2)}",
            _p(numbers, f"{rigid}.{angle:g}.area.specimens_p"), "a large p shows no difference, not equality",
        )
        for angle, p in AREA_SPECIMENS_P.items()
    ]  # fmt: skip
    angles = (
        "A_c0 between angles, worst pair", f"p = {AREA_ANGLES_WORST_P:.5g}",
        _p(numbers, f"{rigid}.area.angles.worst_p"), "all specimens pooled; Dunn on mean ranks, Bonferroni",
    )  # fmt: skip
    return [*rows, angles]


def _rates(found: Discrimination, numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    counts = found.spread.groups.kruskal.count
    bounds = dunn_bounds(counts[0])
    least = f"cannot be less than {exact_p(bounds[1])} in this test" if bounds else "Dunn on mean ranks, Bonferroni"
    rows: list[tuple[Cell, ...]] = []
    for (condition, angle), p in CASR_WORST_P.items():
        key = f"runs.{condition}.{angle:g}.casr.worst_p"
        holm = _p(numbers, f"{key}.holm")
        rows.append(
            (
                f"CASR between specimens, {condition} at {angle:g}°, worst pair", f"p = {exact_p(p)}",
                _p(numbers, key), f"{least}; {_reach(p, _papers_bounds()[0])}; exact Mann-Whitney, Holm: {holm}",
            )
        )  # fmt: skip
    return rows


def _reach(p: float, bound: float) -> str:
    """The paper's p beside what its test gives at the very least without a correction."""
    least = f"the bound of three separated groups of ten without correction, {bounded(bound, 5)}"
    return f"the paper's p equals {least}" if exact_p(p) == exact_p(bound) else f"the paper's p is below even {least}"


def _new(found: Discrimination, numbers: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    if found.new is None or not all(found.new.neighbours):
        return []
    new, stiffer = found.new.name, found.new.neighbours[0]
    least = "runs.constant-min.0.new"
    told = f"{numbers['runs.new.discriminated']} of {numbers['runs.new.designs']} designs"
    return [
        (
            f"{new} against {stiffer}, lowest constant stiffness",
            f"p = {exact_p(NEW_MIN_STIFFNESS_P)}: not told apart", _p(numbers, f"{least}.stiffer_p"),
            f"exact Mann-Whitney, Holm over both neighbours; Dunn over all specimens "
            f"{_p(numbers, f'{least}.stiffer_mean_rank_p')}",
        ),
        (
            f"{new} told from both neighbours", "all but the lowest constant stiffness", told,
            "exact Mann-Whitney against each neighbour, and between them",
        ),
    ]  # fmt: skip


def _p(numbers: Mapping[str, Quantity], key: str) -> str:
    p = float(numbers.get(key, np.nan))
    return UNDEFINED if p != p else f"p = {exact_p(p)}"
