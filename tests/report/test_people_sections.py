"""The sections on fits, the recovery of a simulated truth, and all data together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from emg2vsa.discrimination import discriminate
from emg2vsa.hypotheses import EPSILON, RHO
from emg2vsa.hypotheses import test_hypotheses as run_hypotheses
from emg2vsa.report.inputs import Runs
from emg2vsa.report.section import Content, rendered
from emg2vsa.report.sections.actuators import FACTORS
from emg2vsa.report.sections.fits import FITS
from emg2vsa.report.sections.hypotheses import HYPOTHESES
from emg2vsa.report.sections.participants import PARTICIPANTS
from emg2vsa.report.sections.profiles import SCHEDULES
from emg2vsa.report.study_report import contents
from emg2vsa.report.table import FEW_ON_PAGE
from emg2vsa.schedules.build import build_schedules
from emg2vsa.truth import recover


@pytest.fixture(scope="module")
def whole(results, runs, stiffness_n_per_mm):
    mounted = tuple(replace(run, mounting=1 + np.arange(run.repetitions.size) % 5) for run in runs)
    return replace(results, runs=Runs(mounted, discriminate(mounted, stiffness_n_per_mm, "S_new")))


@pytest.fixture(scope="module")
def content(whole) -> Content:
    return contents(whole)


def test_quantities_are_those_of_the_models(whole, content: Content) -> None:
    q, found = content.quantities, whole.people.hypotheses
    variances = found.tests.blocks.variances
    name = "hypotheses.over_people.mixed.sd_participants_v"
    assert [q[name], q[f"{name}.low"], q[f"{name}.high"]] == [
        each[0] for each in (variances.sd, variances.low, variances.high)
    ]
    assert q["hypotheses.trend.p"] == found.trend.p
    model = whole.runs.discrimination.factors.casr
    i = model.effects.index("condition × angle")
    assert q["runs.factors.casr.condition-angle.omega2"] == model.omega2[i]
    assert q["runs.factors.casr.condition-angle.omega2.high"] == model.high[i]
    assert q["fit.laws.leave_one_bin_out.power.p"] == found.laws.p[1, 1]
    assert q["fit.laws.power.distance"] == found.misfits.together[1].share
    assert q["fit.laws.power.distance_p"] == found.misfits.together[1].p


def test_tables_hold_every_effect_and_residual(whole, content: Content) -> None:
    rows = {name: len(content.tables[name].rows) for name in ("factors", "mixed_sd", "force_laws", "law_misfits")}
    assert rows == {"factors": 14, "mixed_sd": 3, "force_laws": 6, "law_misfits": 9}
    assert len(content.tables["mixed_residuals"].rows) == np.count_nonzero(whole.used)
    people, found = content.tables["person_slopes"].rows, whole.recorded.hypotheses
    assert [(row["participant"], row["specimen"]) for row in people[:2]] == [("P01", "S1"), ("P01", "S2")]
    assert [row["b_v"] for row in people] == found.people.mean.tolist()
    assert [row["person_v"] for row in people[:: found.specimens.size]] == found.tests.blocks.predicted.person.tolist()
    assert [row["participant"] for row in content.tables["trend"].rows] == ["P01", "P02", "P03"]


def test_the_figure_shows_every_residual_against_its_quantile_and_its_fitted_value(whole, content: Content) -> None:
    found = whole.people.hypotheses.tests.blocks.residuals
    normal, level = content.drawings["mixed_residuals"].figure.axes
    np.testing.assert_array_equal(normal.lines[-1].get_xydata(), np.column_stack([found.quantile, found.residual]))
    fitted = found.fitted * whole.scale.factor
    np.testing.assert_array_equal(level.lines[-1].get_xydata(), np.column_stack([fitted, found.residual]))
    assert whole.scale.label("Fitted b") == level.get_xlabel()
    text = rendered(HYPOTHESES, whole, content)
    assert "Residuals of the mixed model</summary>" in text
    assert text.count('role="img"') == 1


def test_the_text_says_how_the_trend_was_tested(whole, content: Content) -> None:
    assert "t test over participants" in rendered(HYPOTHESES, whole, content)


@pytest.mark.parametrize("part", ["people", "runs"])
def test_a_study_of_one_half_has_the_models_of_that_half(whole, part: str) -> None:
    half = replace(whole, people=None) if part == "runs" else replace(whole, runs=None)
    content = contents(half)
    assert ("mixed_sd" in content.tables) == ("mixed_residuals" in content.drawings) == (part == "people")
    assert ("factors" in content.tables) == (part == "runs")
    assert rendered(FACTORS if part == "runs" else HYPOTHESES, half, content)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_a_specimen_has_a_mean_from_one_fit_on_and_a_spread_from_two(results, n):
    fits = results.recorded.fits
    verdict = fits.verdict.copy()
    (of_s1,) = np.nonzero(results.used & (fits.specimen == "S1"))
    verdict[of_s1[n:]] = "rejected"
    few = replace(results, people=replace(results.recorded, fits=replace(fits, verdict=verdict)))
    found, b_v = dict(FITS.quantities(few)), fits.b_v[of_s1[:n]]
    assert found["fit.S1.n"] == n
    expected = np.mean(b_v) if n else np.nan, np.ptp(b_v) / np.sqrt(2) if n == 2 else np.nan
    b = f"fit.S1.b{results.activity_suffix}"
    assert (found[f"{b}.mean"], found[f"{b}.sd"]) == pytest.approx(expected, nan_ok=True)


@pytest.fixture
def biased(results):
    """Every b 2 % above its truth; one interval in four misses it."""
    true_b = np.array([results.people.truth[key][1] for key in keys_of(results.people.fits)])
    miss = np.arange(true_b.size) % 4 == 0
    low = np.where(miss, 1.01, 0.9) * true_b
    return replace(results.people.fits, b_v=1.02 * true_b, b_lo_v=low, b_hi_v=1.2 * true_b)


def keys_of(fits):
    return list(zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True))


def test_bias_and_coverage_are_found(results, biased):
    found = recover(biased, results.people.truth, "ok+doubtful")
    used = biased.verdict != "rejected"
    covered = np.mean(np.arange(used.size)[used] % 4 != 0)
    assert found.n == 71
    assert found.mean_b_error == pytest.approx(0.02)
    assert found.sd_b_error == pytest.approx(0.0, abs=1e-12)
    assert found.coverage == pytest.approx(covered)
    assert found.coverage_mcse == pytest.approx(np.sqrt(covered * (1 - covered) / 71))


def test_monte_carlo_error_is_the_standard_error_of_the_mean(results):
    found = recover(results.people.fits, results.people.truth, "ok+doubtful")
    assert found.mean_b_error_mcse == pytest.approx(found.sd_b_error / np.sqrt(found.n))
    assert abs(found.mean_b_error) < 4 * found.mean_b_error_mcse


def test_only_known_and_usable_trials_enter(results):
    known = {key: value for key, value in results.people.truth.items() if key[1] == "S3"}
    assert recover(results.people.fits, known, "ok+doubtful").n == 17
    assert recover(results.people.fits, known, "ok").n == 16
    assert recover(results.people.fits, known, "ok", "S1").n == 0
    assert np.isnan(recover(results.people.fits, known, "ok", "S1").mean_b_error)


def test_mean_slopes_have_students_interval_over_people(results) -> None:
    q, fits = contents(results).quantities, results.recorded.fits
    for specimen in ("S1", "S5"):
        of = results.used & (fits.specimen == specimen)
        people = [np.mean(fits.b_v[of & (fits.participant == who)]) for who in np.unique(fits.participant[of])]
        mean, half = np.mean(people), stats.t.ppf(0.975, len(people) - 1) * stats.sem(people)
        assert len(people) > 1
        assert q[f"fit.{specimen}.b_v.mean"] == pytest.approx(mean)
        assert q[f"fit.{specimen}.b_v.low"] == pytest.approx(mean - half)
        assert q[f"fit.{specimen}.b_v.high"] == pytest.approx(mean + half)


def test_mean_slopes_of_one_person_have_it_over_presses(results) -> None:
    fits = results.recorded.fits
    alone = fits.participant == "P02"
    verdict = np.where(alone, fits.verdict, "rejected")
    one = replace(results, people=replace(results.people, fits=replace(fits, verdict=verdict), hypotheses=None))
    q = contents(one).quantities
    b = fits.b_v[alone & (fits.specimen == "S1")]
    plain = stats.t.ppf(0.975, b.size - 1) * stats.sem(b)
    assert float(q["fit.S1.b_v.high"]) - b.mean() >= plain * (1 - 1e-9)


def test_profiles_and_schedules_show_their_intervals(results) -> None:
    content = contents(results)
    q, profiles = content.quantities, results.recorded.profiles
    assert profiles is not None
    assert profiles.new is not None
    name = profiles.new.specimen
    half = profiles.half_widths(profiles.new)[1]
    assert (q[f"profiles.{name}.b_v.low"], q[f"profiles.{name}.b_v.high"]) == pytest.approx(
        (profiles.new.b_v - half, profiles.new.b_v + half)
    )
    assert q[f"profiles.{name}.half_width_v"] == pytest.approx(np.max(profiles.half_width_v(profiles.new)))
    for schedule in results.recorded.schedules:
        key = f"schedules.{schedule.specimen}.{schedule.condition}"
        low, high = schedule.interval
        assert q[f"{key}.half_width_percent"] == pytest.approx(np.max(high - low) / 2)
        if schedule.condition != "modular":
            assert (q[f"{key}.percent.low"], q[f"{key}.percent.high"]) == (low[0], high[0])
    row = content.tables["schedules"].rows[3]
    assert row["stiffness_low_percent"] <= row["stiffness_percent"] <= row["stiffness_high_percent"]


@pytest.mark.parametrize("curve", ["log", "spline"])
def test_the_report_says_by_how_much_schedules_of_both_curves_differ(results, curve: str) -> None:
    study = replace(results.study, profile=replace(results.study.profile, curve=curve))
    results = replace(results, study=study)
    content, profiles = contents(results), results.recorded.profiles
    modular = replace(study.schedule, conditions=("modular",))
    log, spline = (
        np.array([each.stiffness_percent for each in build_schedules(profiles.along(way), modular, {})])
        for way in ("log", "spline")
    )
    apart = np.abs(spline - log)
    assert apart.max() > 0.1
    assert content.quantities["schedules.curves_apart.percent"] == pytest.approx(apart.max())
    text = " ".join(rendered(SCHEDULES, results, content).split())
    names = {"log": "v = a + b ln F", "spline": "monotone splines through the force bins"}
    other = names["spline" if curve == "log" else "log"]
    assert f"The schedules follow {names[curve]}; by {other} presets would differ by at most" in text


def test_schedules_without_splines_have_nothing_to_be_compared_with(results) -> None:
    bare = replace(
        results.recorded.profiles,
        profiles=tuple(replace(each, spline=None) for each in results.recorded.profiles.profiles),
    )
    content = contents(replace(results, people=replace(results.people, profiles=bare)))
    assert "schedules.curves_apart.percent" not in content.quantities
    assert "presets would" not in rendered(SCHEDULES, results, content)


def test_tables_of_single_pairs_show_their_first_rows_on_the_page(whole, content: Content) -> None:
    text = rendered(HYPOTHESES, whole, content)
    pairs = len(content.tables["lsd_pairs"].rows)
    assert pairs == 18  # three people, six pairs of four specimens: they fit
    statements = len(content.tables["statements"].rows)
    assert statements > FEW_ON_PAGE
    assert f"The first {FEW_ON_PAGE} of {statements} rows" in text
    assert "The first 20 of 18 rows" not in text


def test_figure_4_is_seen_at_once_and_says_what_its_bands_and_stars_are(whole, content: Content) -> None:
    text = rendered(FITS, whole, content)
    assert text.index("<figure>") < text.index("<details>") if "<details>" in text else "<figure>" in text
    caption = content.drawings["fig04_cocontraction"].caption
    assert len(caption.split()) <= 35
    assert "bands are one SD between trials" in caption
    assert "Stars: p of the uncorrected LSD" in caption


def test_people_have_the_power_of_both_tests(whole, content: Content) -> None:
    text = " ".join(rendered(PARTICIPANTS, whole, content).split())
    of = [f"{content.quantities[f'power.{key}']:.3f}".lstrip("0") for key in ("study", "study_specimens")]
    assert f"that test has a power of {of[0]}, and a test between specimens has {of[1]}, at a" in text
    assert f"at a correlation ρ of {RHO:g} and a sphericity ε of {EPSILON:g}.</p>" in text
    assert "power_sensitivity" in content.tables
    content.quantities |= {"power.study_specimens": np.nan}
    text = " ".join(rendered(PARTICIPANTS, whole, content).split())
    assert f"that test has a power of {of[0]}, at a" in text


def test_a_study_of_one_person_claims_no_power(whole, fits_of) -> None:
    trials = tuple(trial for trial in whole.people.trials if trial.participant == "P02")
    fits = fits_of(list(trials), whole.study)
    found = run_hypotheses(fits, whole.study.hypotheses)
    one = replace(whole, people=replace(whole.people, fits=fits, trials=trials, hypotheses=found), runs=None)
    content = contents(one)
    assert "power_sensitivity" not in content.tables
    assert "that test has a power" not in rendered(PARTICIPANTS, one, content)
    text = rendered(HYPOTHESES, one, content)
    assert "nothing to compare between participants" in text
    assert "Are the participants equal?" not in text
