"""The mixed model, its standard deviations and residuals: against lme4 and lmerTest, a dense likelihood, and the closed
form beside the search; and the boundary where iterative programs fail."""

from __future__ import annotations

import json

import mpmath
import numpy as np
import pytest
from scipy import special, stats

from emg2vsa.statistics.mixed import MixedModel, balanced_mixed, unbalanced_mixed
from emg2vsa.statistics.mixed_variances import MixedResiduals, MixedVariances, mixed_residuals, mixed_variances
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.reml import RemlFit, by_variances, fit_reml, lowest
from tests.statistics.conftest import LMER, STUDIES, clusters, dense_minus_2_reml, study


def fit_of(values: np.ndarray) -> RemlFit:
    found = fit_reml(values)
    assert isinstance(found, RemlFit)
    return found


def fitted(values: np.ndarray) -> MixedModel:
    return unbalanced_mixed(fit_of(values))


def variances(values: np.ndarray) -> MixedVariances:
    return mixed_variances(fit_of(values))


def residuals(values: np.ndarray) -> MixedResiduals:
    return mixed_residuals(values, fit_of(values))


def minus_2_reml(values: np.ndarray) -> float:
    """-2 log of the restricted likelihood of the data at its largest."""
    fit = fit_of(values)
    free = fit.cells.free
    return float(fit.at.deviance(free)) + free * (1 + np.log(2 * np.pi) + 2 * fit.unit * np.log(2))


@pytest.mark.parametrize("name", STUDIES)
def test_lmer_says_the_same(name: str) -> None:
    """lme4 stops searching at 1e-4 of a variance; its likelihood, F and contrasts are better than that.

    Without a variance of participants by specimens lmerTest counts all repetitions as independent; ours never has more
    degrees of freedom than participants by specimens have.
    """
    lmer = json.loads((LMER / "lmer.json").read_text())[name]
    found = fitted(clusters(name).values)
    assert minus_2_reml(clusters(name).values) == pytest.approx(lmer["reml"][0], rel=1e-11)
    np.testing.assert_allclose(found.variance, lmer["variance"], rtol=1e-3, atol=1e-8)
    count = clusters(name).count
    interaction = (count.shape[0] - 1.0) * (count.shape[1] - 1) - np.count_nonzero(count == 0)
    pooled = not found.variance[1]
    assert found.f == pytest.approx(lmer["f_df_p"][0], rel=3e-6)
    assert found.df2 == pytest.approx(min(lmer["f_df_p"][1], interaction) if pooled else lmer["f_df_p"][1], rel=3e-6)
    assert pooled or found.p == pytest.approx(lmer["f_df_p"][2], rel=3e-6)
    pairs = np.array(lmer["pairs"])
    np.testing.assert_allclose(found.pairs.difference[0], pairs[:, 0], rtol=1e-6)
    np.testing.assert_allclose(found.pairs.difference[0] / found.pairs.statistic[0], pairs[:, 1], rtol=1e-6)
    np.testing.assert_allclose(found.pairs.df[0], np.minimum(pairs[:, 2], interaction) if pooled else pairs[:, 2], 2e-5)
    if not pooled:
        np.testing.assert_allclose(found.pairs.p[0], pairs[:, 4], rtol=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", STUDIES)
def test_the_dense_likelihood_in_thirty_digits(name: str) -> None:
    """Same value, and no slope along any variance that is not 0: a thousandth of the SE of lme4's stop would show."""
    of = clusters(name)
    found = fitted(of.values)
    with mpmath.workdps(30):
        variance = [mpmath.mpf(float(v)) for v in found.variance]
        at = dense_minus_2_reml(of, variance)
        assert abs(at - mpmath.mpf(minus_2_reml(of.values))) < 1e-9
        for i, value in enumerate(variance):
            step = mpmath.mpf("1e-6")
            up = [*variance[:i], value + step, *variance[i + 1 :]]
            if value == 0:
                assert dense_minus_2_reml(of, up) > at
                continue
            down = [*variance[:i], value - step, *variance[i + 1 :]]
            above, below = dense_minus_2_reml(of, up), dense_minus_2_reml(of, down)
            curvature = (above - 2 * at + below) / step**2
            assert abs((above - below) / (2 * step) / curvature) < 1e-9 * value


@pytest.mark.parametrize(("person", "interaction"), [(0.5, 0.3), (0.3, 0.0), (0.0, 0.5), (0.0, 0.0)])
def test_without_gaps_it_is_the_closed_form(person: float, interaction: float) -> None:
    for seed in range(3):
        y = study(seed, person, interaction)
        found, closed = fitted(y), balanced_mixed(y)
        np.testing.assert_allclose(found.variance, closed.variance, rtol=1e-11, atol=1e-15)
        np.testing.assert_allclose(found.mean, closed.mean, rtol=1e-13)
        if found.variance.all():  # at 0 the closed form keeps the mean square of the interaction, lme4 pools it
            assert found.f == pytest.approx(closed.f, rel=1e-11)
            assert found.df2 == pytest.approx(closed.df2, rel=1e-9)
            np.testing.assert_allclose(found.pairs.p, closed.pairs.p, rtol=1e-9)


def test_a_lost_cell_does_not_turn_repetitions_into_people() -> None:
    """Without a variance of participants by specimens: 52 degrees of freedom, and 51 without a cell, not 674."""
    values = study(4, 1.0, 0.0)
    values -= (
        values.mean(axis=2, keepdims=True) - values.mean(axis=(0, 2))[:, None] - values.mean(axis=(1, 2))[:, None, None]
    )
    values += np.arange(5)[:, None]
    whole = fitted(values)
    values[3, 2] = np.nan
    lost = fitted(values)
    assert whole.variance[1] == lost.variance[1] == 0
    assert (whole.df2, lost.df2) == (52, 51)
    assert set(lost.pairs.df[0]) == {51}


def test_one_missing_trial_changes_next_to_nothing() -> None:
    """The paper's own case: equal participants, and one of 700 trials rejected."""
    y = study(0, 0.0, 0.0)
    whole = balanced_mixed(y).outcome()
    y[3, 2, 4] = np.nan
    found = fitted(y).outcome()
    assert found.n == 699
    assert found.estimate == pytest.approx(whole.estimate, abs=0.02)
    assert found.interval is not None
    assert whole.interval is not None
    assert found.interval[1] == pytest.approx(whole.interval[1], rel=0.15)


@pytest.mark.slow
def test_the_interval_of_the_ratio_covers() -> None:
    inside = 0
    for seed in range(300):
        y = study(seed, 0.6, 0.3, (10, 4, 5))
        y.ravel()[np.random.default_rng(seed).choice(y.size, 30, replace=False)] = np.nan
        found = fitted(y)
        inside += found.ratio_low <= 0.6 <= found.ratio_high
    assert 0.91 < inside / 300 < 0.985


@pytest.mark.slow
def test_size_of_the_tests() -> None:
    """No specimen differs: F and each contrast reject in 5 % of studies, with gaps and whatever the variances."""
    for person, interaction in ((0.0, 0.0), (0.0, 0.5), (1.0, 0.5)):
        rejected = []
        for seed in range(250):
            rng = np.random.default_rng(seed)
            y = rng.standard_normal((8, 4, 5)) + person * rng.standard_normal((8, 1, 1))
            y += interaction * rng.standard_normal((8, 4, 1))
            y.ravel()[rng.choice(y.size, 24, replace=False)] = np.nan
            found = fitted(y)
            rejected.append([found.p < 0.05, found.pairs.p[0, 0] < 0.05])
        assert (np.mean(rejected, axis=0) < 0.08).all()
        assert (np.mean(rejected, axis=0) > 0.02).all()


@pytest.mark.parametrize(
    ("values", "why"),
    [
        (np.full((3, 2, 2), np.nan), "fewer than two"),
        (np.ones((1, 3, 2)), "fewer than two"),
        (np.random.default_rng(0).standard_normal((4, 3, 1)), "two values"),
        (np.ones((4, 3, 2)), "do not differ"),
        (study(0, 1.0, 0.3, (4, 3, 1)) + 1e-9 * study(1, 0.0, 0.0, (4, 3, 5)), "million times less"),
        (np.where(np.arange(3)[:, None] == 1, np.nan, np.random.default_rng(0).random((4, 3, 2))), "has no values"),
    ],
)
def test_a_study_that_cannot_bear_the_model_is_told_why(values: np.ndarray, why: str) -> None:
    found = fit_reml(values)
    assert isinstance(found, Outcome)
    assert np.isnan(found.p or 0.0)
    assert why in found.notes[0]


@pytest.mark.parametrize("name", STUDIES)
def test_intervals_are_those_of_lme4s_restricted_likelihood(name: str) -> None:
    lme4 = json.loads((LMER / "profile.json").read_text())[name]
    found = variances(clusters(name).values)
    for key, ends in (("sd_low", found.low), ("sd_high", found.high)):
        np.testing.assert_allclose(ends, lme4[key], rtol=1e-10, atol=1e-10)
    for key, ends in (("ratio_low", found.ratio_low), ("ratio_high", found.ratio_high)):
        np.testing.assert_allclose(ends, lme4[key], rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("name", STUDIES)
def test_fitted_values_are_those_of_lme4(name: str) -> None:
    """As near as lme4 stops to the best variances."""
    lme4 = json.loads((LMER / "profile.json").read_text())[name]
    np.testing.assert_allclose(residuals(clusters(name).values).fitted, lme4["fitted"], atol=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "source"), [("interior.csv", 0), ("interior.csv", 1), ("no_participants.csv", 2)])
def test_ends_in_thirty_digits(name: str, source: int) -> None:
    """At an end, the dense likelihood lies a quantile of chi squared above its best: the others at their best."""
    of = clusters(name)
    found, best_of_all = variances(of.values), mpmath.mpf(minus_2_reml(of.values))
    quantile = special.chdtri(1, 0.05)

    def dense(variance: list[float]) -> float:
        with mpmath.workdps(30):
            return float(dense_minus_2_reml(of, [mpmath.mpf(v) for v in variance]) - best_of_all)

    end = found.high[source] ** 2
    others = [i for i in range(3) if i != source]
    best = _best_of_others(of.values, source, end)
    at = np.empty(3)
    at[source], at[others] = end, best
    assert dense(at.tolist()) == pytest.approx(quantile, abs=1e-9)
    for i in others:  # any other choice is higher: the end is the profile's
        up = at.copy()
        up[i] += 1e-4
        assert dense(up.tolist()) > quantile


def _best_of_others(values: np.ndarray, source: int, end: float) -> np.ndarray:
    cells, unit = fit_of(values).cells, fit_of(values).unit
    start = np.full(3, np.ldexp(1.0, -2 * unit))
    start[source] = np.ldexp(end, -2 * unit)
    best = lowest(by_variances(cells), start, np.arange(3) != source, search=True)
    return np.ldexp(best[np.arange(3) != source], 2 * unit)


def test_without_gaps_the_estimates_are_the_closed_form() -> None:
    for seed in range(3):
        y = study(seed, 0.5, 0.3)
        np.testing.assert_allclose(variances(y).sd, np.sqrt(balanced_mixed(y).variance), rtol=1e-11)


def test_a_variance_at_the_boundary_is_said() -> None:
    found = variances(clusters("no_participants.csv").values)
    assert found.sd[0] == found.low[0] == 0 < found.high[0]
    notes = [outcome.notes for outcome in found.outcomes()]
    assert "variance of 0" in notes[0][0]
    assert "variance of 0" in notes[3][0]
    assert notes[1] == notes[2] == ()


@pytest.mark.parametrize(("shift", "scale"), [(1e6, 1.0), (0.0, 1e-150), (0.0, 1e150), (-3.0, 1e-6)])
def test_unit_and_origin_of_the_standard_deviations(shift: float, scale: float) -> None:
    y = study(4, 0.4, 0.3, (6, 3, 4))
    y[0, 1] = np.nan
    found, other = variances(y), variances((y + shift) * scale)
    np.testing.assert_allclose(other.high / scale, found.high, rtol=1e-7)
    np.testing.assert_allclose(other.ratio_high, found.ratio_high, rtol=1e-7)
    np.testing.assert_allclose(residuals((y + shift) * scale).residual, residuals(y).residual, atol=1e-7)


@pytest.mark.slow
def test_intervals_cover() -> None:
    truth = np.array([0.6, 0.3, 1.0])
    inside = np.zeros(3)
    for seed in range(300):
        y = study(seed, 0.6, 0.3, (10, 4, 5))
        y.ravel()[np.random.default_rng(seed).choice(y.size, 30, replace=False)] = np.nan
        found = variances(y)
        inside += (found.low <= truth) & (truth <= found.high)
    assert (inside / 300 > 0.91).all()
    assert (inside / 300 < 0.985).all()


def test_residuals_lie_on_the_line_and_their_tests_are_no_surprise() -> None:
    found = residuals(study(0, 0.5, 0.3))
    spread = np.sqrt(1 - 70 / 700)  # 70 cells were fitted
    assert stats.linregress(found.quantile, found.residual).slope == pytest.approx(spread, abs=0.03)
    normal, level = found.outcomes()
    assert normal.statistic == pytest.approx(stats.shapiro(found.residual).statistic, rel=1e-8)
    rho = stats.spearmanr(np.abs(found.residual), found.fitted)
    assert level.effect_size == pytest.approx(rho.statistic, rel=1e-12)
    assert level.p == pytest.approx(rho.pvalue, rel=1e-9)


def test_scatter_that_grows_with_the_level_is_seen() -> None:
    y = 5 + study(0, 1.0, 0.0)
    y += (y - y.mean(axis=2, keepdims=True)) * 0.5 * (y.mean(axis=2, keepdims=True) - 5)
    level = residuals(y).outcomes()[1]
    assert level.p is not None
    assert level.p < 1e-6
    assert level.effect_size is not None
    assert level.effect_size > 0.2


def test_beyond_all_numbers_a_variance_of_zero_stays_zero() -> None:
    y = study(next(s for s in range(50) if balanced_mixed(study(s, 0.0, 0.0)).variance[0] == 0), 0.0, 0.0)
    with np.errstate(all="raise"):
        variance = balanced_mixed(y * 1e160).variance
    assert variance[0] == 0
    assert np.isinf(variance[2])


def test_variance_zero_is_said() -> None:
    seed = next(s for s in range(50) if balanced_mixed(study(s, 0.0, 0.0)).variance[0] == 0)
    outcome = balanced_mixed(study(seed, 0.0, 0.0)).outcome()
    assert "estimated as 0" in outcome.notes[0]
    assert outcome.estimate == 0.0
    assert outcome.interval is not None
    assert outcome.interval[1] > 0


def test_the_interval_of_the_participants_covers() -> None:
    rng = np.random.default_rng(8)
    shape = (1500, 10, 4, 5)
    y = rng.standard_normal(shape) + np.sqrt(0.5) * rng.standard_normal((1500, 10, 1, 1))
    y += np.sqrt(0.2) * rng.standard_normal((1500, 10, 4, 1))
    inside = 0
    for each in y:
        found = balanced_mixed(each)
        low, high = np.array([found.ratio_low, found.ratio_high]) ** 2 * found.variance[2]
        inside += low <= 0.5 <= high
    assert 0.935 < inside / len(y) < 0.985
