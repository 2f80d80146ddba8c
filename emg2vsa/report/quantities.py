"""Every number of section IV.B under one flat name: what results.json holds, and the page and the macros read."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.companions.groups import GroupTests
from emg2vsa.fits import usable
from emg2vsa.hypotheses import EFFECT_F, EPSILON, RHO, Hypotheses
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.quantity import Items, Quantity, least, most
from emg2vsa.schedules import Schedule
from emg2vsa.stats.clusters import Names
from emg2vsa.stats.mixed import MixedModel
from emg2vsa.stats.power import power_rm
from emg2vsa.stats.unbalanced_mixed import UnbalancedMixed
from emg2vsa.truth import Recovery, recover

PAPER_PARTICIPANTS, PAPER_REPETITIONS, PAPER_ALPHA = 14, 10, 0.05


def quantities(results: StudyResults) -> dict[str, Quantity]:
    """Name to value, sorted by name; NaN where a number is not defined, absent where a stage failed."""
    of_people = (_people, _trials, _fit, _hypotheses, _power, _profiles, _schedules, _recovery)
    parts = (_study, *(of_people if results.fits is not None else ()))
    return dict(sorted(item for part in parts for item in part(results)))


def activity_suffix(results: StudyResults) -> str:
    """End of the names of activities: their unit, unless they are normalised."""
    return "_v" if results.fitted.activity_unit == "V" else ""


def _study(results: StudyResults) -> Items:
    study = results.study
    yield "study.name", study.name
    yield "study.mode", study.mode
    yield "study.truth_found", results.truth is not None
    yield "study.specimens", len(study.specimens)
    yield "study.failures", len(results.failures)


def _people(results: StudyResults) -> Items:
    yield "study.participants", len(results.study.participants)
    yield "study.recordings", len(results.study.recordings)
    yield "study.recordings_read", len(results.trials)


def _trials(results: StudyResults) -> Items:
    yield "trials.total", int(results.fitted.verdict.size)
    for verdict, n in results.verdict_counts().items():
        yield f"trials.{verdict}", n
    if results.trials:
        yield "trials.largest_delay_mismatch_s", max(abs(t.delay.mismatch_s) for t in results.trials)


def _fit(results: StudyResults) -> Items:
    fits = results.fitted
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
    if results.truth is None or results.fitted.activity_unit != "V":
        return
    use = results.study.hypotheses.use
    yield from _recovered("recovery", recover(results.fitted, results.truth, use))
    for specimen in (s.name for s in results.study.specimens):
        yield from _recovered(f"recovery.{specimen}", recover(results.fitted, results.truth, use, specimen))


def _recovered(name: str, recovery: Recovery) -> Items:
    for key, value in vars(recovery).items():
        yield f"{name}.{key}", value


def _median(values: Floats) -> float:
    return float(np.nanmedian(values)) if np.isfinite(values).any() else np.nan


def _hypotheses(results: StudyResults) -> Items:
    if (found := results.hypotheses) is None:
        return
    yield "hypotheses.alpha", found.alpha
    yield "hypotheses.kept", ", ".join(found.kept)
    yield "hypotheses.worst_p", found.worst_p
    yield "hypotheses.worst_pair", found.worst_pair
    yield from _normality(found)
    yield from _designs("between_participants", found.specimens, found.tests.between_blocks, found.alpha)
    yield from _designs("between_specimens", found.participants, found.tests.between_groups, found.alpha)
    yield from _pairs(found)
    yield from _over_people(found)


def _normality(found: Hypotheses) -> Items:
    tests = found.tests.normality
    yield "hypotheses.normality.clusters", int(np.count_nonzero(found.count))
    families = {
        "standardised": tests.standardised.p, "raw": tests.raw.p, "lilliefors": tests.lilliefors.p,
        "shapiro": tests.shapiro.p,
    }  # fmt: skip
    for kind, p in families.items():
        yield from _how_many(f"hypotheses.normality.{kind}", p, found.alpha)
        yield f"hypotheses.normality.{kind}.smallest_p", least(p)


def _designs(name: str, designs: Names, tests: GroupTests, alpha: float) -> Items:
    name, anova = f"hypotheses.{name}", tests.anova
    yield from _how_many(name, anova.p, alpha)
    yield f"{name}.smallest_p", least(anova.p)
    yield f"{name}.largest_p", most(anova.p)
    companions = {
        "welch": tests.welch.p, "kruskal": tests.kruskal.p, "brown_forsythe": tests.brown_forsythe.anova.p,
    }  # fmt: skip
    for kind, p in companions.items():
        yield f"{name}.{kind}.significant", int(np.count_nonzero(p < alpha))
    numbers = {key: getattr(anova, key) for key in ("f", "df1", "df2", "p", "eta2")}
    numbers |= {"eta2_low": tests.eta2_low, "eta2_high": tests.eta2_high, "bf01": tests.bayes.bf01}
    for i, design in enumerate(designs[: anova.f.size].tolist()):
        yield from ((f"{name}.{design}.{key}", values[i].item()) for key, values in numbers.items())


def _pairs(found: Hypotheses) -> Items:
    pairs, name = found.tests.pairs, "hypotheses.pairs"
    yield from _how_many(name, pairs.lsd.p, found.alpha)
    corrected = {
        "holm": pairs.p_holm, "tukey": pairs.tukey.p, "games_howell": pairs.games_howell.p, "fdr": pairs.p_fdr,
        "dunn": pairs.dunn.p, "mann_whitney": pairs.p_rank_holm,
    }  # fmt: skip
    for kind, p in corrected.items():
        yield f"{name}.{kind}.significant", int(np.count_nonzero(p < found.alpha))
        yield f"hypotheses.worst_p.{kind}", float(p[found.worst]) if found.worst[0] >= 0 else np.nan
    for i, participant in enumerate(found.participants[: len(pairs.lsd.p)].tolist()):
        for j, (first, second) in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
            if found.specimens.size > 1:
                ends = f"{found.specimens[first]}-{found.specimens[second]}"
                yield f"{name}.{participant}.{ends}.p", pairs.lsd.p[i, j].item()


def _over_people(found: Hypotheses) -> Items:
    equality, blocks, name = found.tests.equality, found.tests.blocks, "hypotheses.over_people"
    yield "hypotheses.equality.bound_sd", most(equality.bound_sd)
    if equality.tost is not None and equality.margin is not None:
        yield "hypotheses.equality.margin_sd", equality.margin
        yield "hypotheses.equality.pairs_shown_equal", int(np.count_nonzero(equality.tost.p < found.alpha))
        yield "hypotheses.equality.pairs", int(np.count_nonzero(np.isfinite(equality.tost.p)))
    if blocks is None:
        return
    repeated = blocks.repeated
    yield f"{name}.repeated.f", repeated.f[0].item()
    for key in ("p", "p_gg", "p_hf", "epsilon_gg", "epsilon_hf", "mauchly_p", "eta2_generalised"):
        yield f"{name}.repeated.{key}", getattr(repeated, key)[0].item()
    yield f"{name}.friedman.chi2", blocks.friedman.chi2[0].item()
    yield f"{name}.friedman.p", blocks.friedman.p[0].item()
    if blocks.mixed is not None:
        yield f"{name}.mixed.f", _plain(blocks.mixed.statistic)
        yield f"{name}.mixed.p", _plain(blocks.mixed.p)
        yield f"{name}.mixed.icc", _plain(blocks.mixed.effect_size)
    if isinstance(blocks.model, MixedModel | UnbalancedMixed):
        for key in ("sd_ratio", "ratio_low", "ratio_high"):
            yield f"{name}.mixed.{key}", np.ravel(getattr(blocks.model, key))[0].item()
    pairs = blocks.paired.t
    for j, (first, second) in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        ends = f"{name}.pairs.{found.specimens[first]}-{found.specimens[second]}"
        for test, p in blocks.pair_families.items():
            yield f"{ends}.{test.lower().replace(' ', '_').replace('-', '_')}.p_holm", p[0, j].item()
        for key in ("g", "g_low", "g_high"):
            yield f"{ends}.{key}", getattr(blocks.paired, key)[0, j].item()


def _plain(value: float | None) -> float:
    return np.nan if value is None else value


def _how_many(name: str, p: Floats, alpha: float) -> Items:
    """``chance_of_any``: that of at least one rejection where nothing differs and the tests are independent."""
    tested = int(np.count_nonzero(np.isfinite(p)))
    yield f"{name}.tested", tested
    yield f"{name}.significant", int(np.count_nonzero(p < alpha))
    yield f"{name}.chance_of_any", 1 - (1 - alpha) ** tested
