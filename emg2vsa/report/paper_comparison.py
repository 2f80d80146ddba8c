"""The numbers the paper prints in section IV.B, beside ours."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.quantities import Quantity
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import bounded, listed, number, percent

PROVENANCE = {
    True: (
        "These results come from a simulation.",
        "Every recording was synthesised from chosen curves plus noise. Numbers on this page show that the method "
        "finds what was put in; they are no evidence about people, and agreement with the paper is not a replication.",
    ),
    False: ("These results come from recorded data.", "Nothing on this page was simulated."),
}


def paper_comparison(results: StudyResults, found: Mapping[str, Quantity]) -> Table:
    """Quantity, the paper's value, ours, and what to mind; ours is missing where its stage failed."""
    rows = [*_curves(found), *_tests(found), *_new_specimen(results, found), *_design(results, found)]
    columns = (Column("quantity", "Quantity"), Column("paper", "Paper"), Column("here", "Here"), Column("mind", "Mind"))
    source = "simulated data" if results.simulated else "recorded data"
    return Table("paper_comparison", f"The paper's numbers beside ours ({source})", columns, tuple(rows))


def _curves(found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    worst = [_share(found, f"fit.adj_r2_{stage}.min") for stage in ("samples", "bins")]
    return [
        ("fitted curves", "700", f"{found['fit.curves']}", f"{found['fit.used']} of {found['trials.total']} trials used"),
        (
            "worst adjusted R² of the logarithmic fit", ".832", f"{worst[0]} on samples, {worst[1]} on bins",
            "the paper does not say how smooth its curves were; R² depends on it",
        ),
    ]  # fmt: skip


def _tests(found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    if "hypotheses.worst_p" not in found:
        return []
    normal = "hypotheses.normality"
    rejected = f"{found[f'{normal}.standardised.significant']} of {found[f'{normal}.clusters']} (standardised)"
    return [
        (
            "clusters of b that are not Gaussian", "0 of 70", rejected,
            f"raw N(0, 1) test: {found[f'{normal}.raw.significant']}; the paper does not say which of the two it ran",
        ),
        (
            "specimens for which participants differ", "0 of 5",
            f"{found['hypotheses.between_participants.significant']} of {_count(found, 'between_participants')}",
            "not finding a difference does not show equality",
        ),
        (
            f"worst p among {listed(str(found['hypotheses.kept']).split())}", ".0391 (S1, S3 and S5)",
            _p(found["hypotheses.worst_p"]), f"{found['hypotheses.worst_pair']}; LSD without correction" ,
        ),
    ]  # fmt: skip


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
    if f"{name}.rmse_v" in found:
        unit = f" {results.fits.activity_unit}" if results.fits.activity_unit == "V" else ""
        rmse, relative = float(found[f"{name}.rmse_v"]), float(found[f"{name}.rmse_relative"])
        rows.append(
            (
                "interpolated profile against measured, RMSE", "0.0002 V", f"{number(rmse)}{unit}",
                f"{percent(relative)} of the measured level; volts depend on electrodes and gain, the share does not",
            )
        )  # fmt: skip
    return rows


def _design(results: StudyResults, found: Mapping[str, Quantity]) -> list[tuple[Cell, ...]]:
    low, high = results.study.schedule.stiffness_percent
    mapped = f"{low:g} to {high:g} %, {results.study.schedule.step_n:g} N"
    planned = f"{found['power.n14']:.3f} for 14 people and ten repetitions"
    mind = "it is the power to tell repetitions apart, at a correlation of .5; not specimens, not participants"
    return [
        ("stiffness range and force step of the schedules", "20 to 80 %, 0.3 N", mapped, "settings, not results"),
        ("planned power", "about .80 (f = .25, α = .05)", planned.lstrip("0"), mind),
    ]


def _count(found: Mapping[str, Quantity], test: str) -> int:
    return sum(key.startswith(f"hypotheses.{test}.") and key.endswith(".df1") for key in found)


def _share(found: Mapping[str, Quantity], key: str) -> str:
    return bounded(float(found.get(key, np.nan)))


def _p(p: Quantity) -> str:
    p = float(p)
    return bounded(p, 4) if p >= 1e-4 or np.isnan(p) else number(p, 2)
