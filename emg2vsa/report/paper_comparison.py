"""The numbers the paper prints in section IV.B, beside ours."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.origin import origin
from emg2vsa.report.p_bounds import dunn_bounds
from emg2vsa.report.quantities import activity_suffix
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.study_tables import scale_of
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import activity, bounded, listed, number, percent


def paper_comparison(results: StudyResults, found: Mapping[str, Quantity]) -> Table:
    """Quantity, the paper's value, ours, and what to mind; ours is missing where its stage failed."""
    rows = [
        *_curves(found),
        *_tests(results, found),
        *_new_specimen(results, found),
        *_design(results, found),
        *_reach(),
    ]
    columns = (Column("quantity", "Quantity"), Column("paper", "Paper"), Column("here", "Here"), Column("mind", "Mind"))
    caption = f"The paper's numbers beside ours ({origin(results).source})"
    return Table("paper_comparison", caption, columns, tuple(rows))


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
    whose = f"{pair}; LSD without correction; Holm {_p(float(found['hypotheses.worst_p.holm']))}"
    return [
        ("clusters of b that are not Gaussian", "0 of 70", f"{normal['standardised']} (standardised)", which),
        ("specimens for which participants differ", "0 of 5", different, "no difference found is not equality shown"),
        (
            f"worst p among {listed(tested.kept)}", ".0391 (S1, S3 and S5)", _p(tested.worst_p),
            whose if pair else "no pair could be tested",
        ),
    ]  # fmt: skip


def _reach() -> list[tuple[Cell, ...]]:
    """p that the paper prints in section VI beside what its test can give at all with three groups of ten."""
    bounds = dunn_bounds(np.array([10, 10, 10]))
    assert bounds is not None
    uncorrected, corrected = map(_p, bounds)
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


def _p(p: float) -> str:
    return bounded(p, 4) if p >= 1e-4 or np.isnan(p) else number(p, 2)
