"""Every number of section IV.B under one flat name: what results.json holds, and the page and the macros read."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.fits import usable
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO
from emg2vsa.report.hypothesis_quantities import hypothesis_quantities
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.quantity import Items, Quantity, least
from emg2vsa.report.recovery import Recovery, recover
from emg2vsa.schedules import Schedule
from emg2vsa.stats.power import power_rm

PAPER_PARTICIPANTS, PAPER_REPETITIONS, PAPER_ALPHA = 14, 10, 0.05


def quantities(results: StudyResults) -> dict[str, Quantity]:
    """Name to value, sorted by name; NaN where a number is not defined, absent where a stage failed."""
    parts = (_study, _trials, _fit, _hypotheses, _power, _profiles, _schedules, _recovery)
    return dict(sorted(item for part in parts for item in part(results)))


def activity_suffix(results: StudyResults) -> str:
    """End of the names of activities: their unit, unless they are normalised."""
    return "_v" if results.fits.activity_unit == "V" else ""


def _study(results: StudyResults) -> Items:
    study = results.study
    yield "study.name", study.name
    yield "study.mode", study.mode
    yield "study.truth_found", results.truth is not None
    yield "study.participants", len(study.participants)
    yield "study.specimens", len(study.specimens)
    yield "study.recordings", len(study.recordings)
    yield "study.recordings_read", len(results.trials)
    yield "study.failures", len(results.failures)


def _trials(results: StudyResults) -> Items:
    yield "trials.total", int(results.fits.verdict.size)
    for verdict, n in results.verdict_counts().items():
        yield f"trials.{verdict}", n
    if results.trials:
        yield "trials.largest_delay_mismatch_s", max(abs(t.delay.mismatch_s) for t in results.trials)


def _fit(results: StudyResults) -> Items:
    fits = results.fits
    used = usable(fits, results.study.hypotheses.use)
    yield "fit.curves", int(np.count_nonzero(np.isfinite(fits.b_v)))
    yield "fit.used", int(np.count_nonzero(used))
    yield "fit.points", fits.points
    yield "fit.weights", fits.weights
    yield "fit.confidence", fits.confidence
    yield "fit.activity_unit", fits.activity_unit
    yield "fit.b_not_positive", int(np.count_nonzero(fits.b_v[used] <= 0))
    for name in ("adj_r2", "adj_r2_bins", "adj_r2_samples", "r2_bins", "r2_samples"):
        values = getattr(fits, name)[used]
        yield f"fit.{name}.min", least(values)
        yield f"fit.{name}.median", _median(values)
    yield "fit.n_effective.median", _median(fits.n_effective[used])
    yield "fit.lag1.median", _median(fits.lag1[used])
    for specimen in (s.name for s in results.study.specimens):
        of = used & (fits.specimen == specimen)
        yield f"fit.{specimen}.n", int(np.count_nonzero(of))
        for name in ("a", "b"):
            values, name = getattr(fits, f"{name}_v")[of], name + activity_suffix(results)
            yield f"fit.{specimen}.{name}.mean", float(np.mean(values)) if values.size else np.nan
            yield f"fit.{specimen}.{name}.sd", float(np.std(values, ddof=1)) if values.size > 1 else np.nan


def _hypotheses(results: StudyResults) -> Items:
    if results.hypotheses is not None:
        yield from hypothesis_quantities(results.hypotheses)


def _power(results: StudyResults) -> Items:
    yield (
        f"power.n{PAPER_PARTICIPANTS}",
        float(power_rm(PAPER_PARTICIPANTS, PAPER_REPETITIONS, EFFECT_F, RHO, EPSILON, PAPER_ALPHA)),
    )
    if results.hypotheses is not None:
        yield "power.study", results.hypotheses.power.repetitions
        yield "power.study_specimens", results.hypotheses.power.specimens
        yield "power.people_for_specimens", results.hypotheses.power.people


def _profiles(results: StudyResults) -> Items:
    profiles, v = results.profiles, activity_suffix(results)
    if profiles is None:
        return
    yield "profiles.participant", profiles.participant or "all"
    for profile in profiles.profiles:
        yield f"profiles.{profile.specimen}.a{v}", profile.a_v
        yield f"profiles.{profile.specimen}.b{v}", profile.b_v
        yield f"profiles.{profile.specimen}.n_trials", profile.n_trials
    for left in profiles.leave_one_out:
        yield f"profiles.leave_one_out.{left.specimen}.rmse{v}", left.rmse_v
        yield f"profiles.leave_one_out.{left.specimen}.relative", left.relative
    if profiles.new is not None:
        name = f"profiles.{profiles.new.specimen}"
        yield f"{name}.alpha", profiles.weight_alpha
        yield f"{name}.a{v}", profiles.new.a_v
        yield f"{name}.b{v}", profiles.new.b_v
        if profiles.new_error is not None:
            yield f"{name}.measured_as", profiles.new_error.specimen
            yield f"{name}.rmse{v}", profiles.new_error.rmse_v
            yield f"{name}.rmse_relative", profiles.new_error.relative


def _schedules(results: StudyResults) -> Items:
    for schedule in results.schedules:
        yield from _schedule(schedule, f"schedules.{schedule.specimen}.{schedule.condition}")


def _schedule(schedule: Schedule, name: str) -> Items:
    if schedule.condition == "modular":
        yield f"{name}.steps", int(schedule.stiffness_percent.size)
        yield f"{name}.last_step_short", bool(schedule.last_step_short)
        yield f"{name}.min_percent", float(schedule.stiffness_percent.min())
        yield f"{name}.max_percent", float(schedule.stiffness_percent.max())
        yield f"{name}.max_nm_per_rad", float(schedule.stiffness_nm_per_rad.max())
    else:
        yield f"{name}.percent", float(schedule.stiffness_percent[0])
        yield f"{name}.nm_per_rad", float(schedule.stiffness_nm_per_rad[0])
    yield f"{name}.duration_s", float(schedule.ramp.duration_s)


def _recovery(results: StudyResults) -> Items:
    if results.truth is None or results.fits.activity_unit != "V":
        return
    use = results.study.hypotheses.use
    yield from _recovered("recovery", recover(results.fits, results.truth, use))
    for specimen in (s.name for s in results.study.specimens):
        yield from _recovered(f"recovery.{specimen}", recover(results.fits, results.truth, use, specimen))


def _recovered(name: str, recovery: Recovery) -> Items:
    for key, value in vars(recovery).items():
        yield f"{name}.{key}", value


def _median(values: Floats) -> float:
    return float(np.nanmedian(values)) if np.isfinite(values).any() else np.nan
