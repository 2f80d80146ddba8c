"""Claims of the paper on settings and arithmetic: exact numbers but for the lines of plates."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from emg2vsa.claims import paper
from emg2vsa.claims.claim import UNKNOWN, Claim, Found, exactly, largest, size, student
from emg2vsa.curves.plate_tests import PlateTests
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO
from emg2vsa.rig.executor.motion import MovingAverage
from emg2vsa.statistics.power import power_rm
from emg2vsa.study import Study

QUESTION = "settings and arithmetic"
FILTER = MovingAverage(5, 200.0)
"""Filter of the force, as the paper describes it."""
_ROUNDED, _HALF_DIGIT = 0.005, 0.0005
_LEAST_PLATE_R2 = 0.882
_BENT = 0.1
"""Share by which κ may change over the range of force before a line no longer describes the press."""


@dataclass(frozen=True)
class Counted:
    """Presses that gave a curve, that were recorded, and that the study asked for, 0 where nobody can say."""

    curves: int
    recorded: int
    asked: int


def arithmetic_claims(
    study: Study,
    *,
    weight_alpha: float = np.nan,
    counted: Counted | None = None,
    runs: bool = False,
    plates: PlateTests | None = None,
) -> Iterator[Claim]:
    """weight_alpha : of the softer neighbour in the profile of the new specimen, NaN where none was made. runs :
    whether the rig pressed anything. plates : indentations of the specimens."""
    if counted is not None:
        yield from _of_people(study, weight_alpha, counted)
        yield _of_plates(study, plates)
    if runs:
        off = abs(FILTER.cutoff_hz / paper.FILTER_CUTOFF_HZ - 1)
        yield _claim(
            "force_filter", "a mean of five samples at 200 Hz cuts off at 5 Hz", "distance of the cut-off, %",
            exactly(off), 0.1, "runs", factor=100,
        )  # fmt: skip
        implied = max(paper.implied_ratio(angle) for angle in paper.CURVES) / paper.largest_ratio()
        yield _claim(
            "kappa_curves", "one exponential curve for each angle gives κ of CASR",
            "ratio S5 : S1 that the curves imply, over the largest that contact mechanics allows", exactly(implied),
            1.0, "runs",
        )  # fmt: skip


def _of_people(study: Study, weight_alpha: float, counted: Counted) -> Iterator[Claim]:
    r2 = [specimen.plate_adjusted_r2 for specimen in study.specimens]
    known = [1 - value for value in r2 if value is not None]
    worst = max(known, default=np.nan)
    yield _claim(
        "plate_r2", "the adjusted R² of every plate line is .882 or more", "1 less the worst adj. R²",
        exactly(worst, worst if len(known) == len(r2) else max(worst, 1.0)), 1 - _LEAST_PLATE_R2,
        "plates", why="" if len(known) == len(r2) else "R² of some specimens is not known (emg2vsa rig run --plate).",
    )  # fmt: skip
    lost, waiting = counted.recorded - counted.curves, max(counted.asked - counted.recorded, 0)
    yield _claim(
        "curves", "every press of every participant gives a curve", "presses without a curve",
        exactly(lost, lost + waiting if counted.asked else np.inf), 0.5, "fits",
        why="Presses that the study asks for were not recorded or not read." if waiting or not counted.asked else "",
    )  # fmt: skip
    yield _claim(
        "power", "14 participants with ten movements suffice (f = .25, α = .05)", "power below .80",
        exactly(max(0.8 - float(power_rm(14, 10, EFFECT_F, RHO, EPSILON, 0.05)), 0.0)), _ROUNDED, "participants",
        why="The study does not test repetitions.",
    )  # fmt: skip
    if weight_alpha == weight_alpha:
        yield _claim(
            "interpolation_weight", f"the weight α of the softer neighbour of {study.profile.new_specimen} is .532",
            "distance from .532", exactly(abs(weight_alpha - paper.WEIGHT_ALPHA)), _HALF_DIGIT, "profiles",
            why=f"Rule here: {study.profile.interpolation}.",
        )  # fmt: skip
    schedule = study.schedule
    others = int(schedule.stiffness_percent != paper.SCHEDULE_PERCENT) + int(schedule.step_n != paper.SCHEDULE_STEP_N)
    yield _claim(
        "schedule_range", "profiles are mapped on 20 to 80 % stiffness in steps of 0.3 N", "settings that differ",
        exactly(others), 0.5, "schedules",
    )  # fmt: skip


def _of_plates(study: Study, plates: PlateTests | None) -> Claim:
    """Claim that kappa of every specimen stays the same over the range of force."""
    names = [specimen.name for specimen in study.specimens]
    pressed = [of for name in names if plates and (of := plates.specimen(name))]
    missing = sorted(set(names) - {of.name for of in pressed})
    bends = [size(student(of.bend, of.bend_se, of.bend_dof)) for of in pressed]
    return Claim(
        "plate_line", QUESTION, "a straight line describes every plate indentation",
        "largest change of κ over the range of force, %", "within", largest(bends) if not missing else UNKNOWN, _BENT,
        "mounting", "plates", factor=100,
        why=f"No plate pressed {', '.join(missing)} (emg2vsa rig run --plate)." if missing else "",
    )  # fmt: skip


def _claim(
    key: str, says: str, estimand: str, found: Found, margin: float, section: str, *, factor: float = 1.0, why: str = ""
) -> Claim:
    return Claim(key, QUESTION, says, estimand, "within", found, margin, "none", section, factor=factor, why=why)
