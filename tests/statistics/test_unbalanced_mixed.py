"""The mixed model of a study with gaps: against lme4 and lmerTest, a dense likelihood, and the closed form."""

from __future__ import annotations

import json

import mpmath
import numpy as np
import pytest

from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.unbalanced_mixed import UnbalancedMixed, unbalanced_mixed
from tests.statistics.conftest import LMER, STUDIES, clusters, dense_minus_2_reml, study


def fitted(values: np.ndarray) -> UnbalancedMixed:
    found = unbalanced_mixed(values)
    assert isinstance(found, UnbalancedMixed)
    return found


@pytest.mark.parametrize("name", STUDIES)
def test_lmer_says_the_same(name: str) -> None:
    """lme4 stops searching at 1e-4 of a variance; its likelihood, F and contrasts are better than that."""
    lmer = json.loads((LMER / "lmer.json").read_text())[name]
    found = fitted(clusters(name).values)
    assert found.minus_2_reml == pytest.approx(lmer["reml"][0], rel=1e-11)
    np.testing.assert_allclose(found.variance, lmer["variance"], rtol=1e-3, atol=1e-8)
    assert (found.f, found.df2, found.p) == pytest.approx(lmer["f_df_p"], rel=3e-6)
    pairs = np.array(lmer["pairs"])
    np.testing.assert_allclose(found.pairs.difference[0], pairs[:, 0], rtol=1e-6)
    np.testing.assert_allclose(found.pairs.difference[0] / found.pairs.statistic[0], pairs[:, 1], rtol=1e-6)
    np.testing.assert_allclose(found.pairs.df[0], pairs[:, 2], rtol=2e-5)
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
        assert abs(at - mpmath.mpf(found.minus_2_reml)) < 1e-9
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
        np.testing.assert_allclose(found.variance, closed.variance[0], rtol=1e-11, atol=1e-15)
        np.testing.assert_allclose(found.mean, closed.mean[0], rtol=1e-13)
        if found.variance.all():  # at 0 the closed form keeps the mean square of the interaction, lme4 pools it
            assert found.f == pytest.approx(closed.f[0], rel=1e-11)
            assert found.df2 == pytest.approx(closed.df2, rel=1e-9)
            np.testing.assert_allclose(found.pairs.p, closed.pairs().p, rtol=1e-9)


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


@pytest.mark.parametrize(("shift", "scale"), [(1e6, 1.0), (0.0, 1e-150), (0.0, 1e150), (-3.0, 1e-6)])
def test_unit_and_origin(shift: float, scale: float) -> None:
    y = study(4, 0.4, 0.3, (6, 3, 4))
    y[0, 1] = np.nan
    found, other = fitted(y), fitted((y + shift) * scale)
    assert other.f == pytest.approx(found.f, rel=1e-8)
    np.testing.assert_allclose(other.variance / scale**2, found.variance, rtol=1e-7)
    assert other.ratio_high == pytest.approx(found.ratio_high, rel=1e-6)


def test_the_order_of_people_and_repetitions_does_not_count() -> None:
    y = study(2, 0.5, 0.3, (6, 3, 4))
    y[2, 0, 1:] = np.nan
    found, other = fitted(y), fitted(y[::-1, :, ::-1])
    assert other.f == pytest.approx(found.f, rel=1e-11)
    assert other.variance == pytest.approx(found.variance, rel=1e-10)


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
    found = unbalanced_mixed(values)
    assert isinstance(found, Outcome)
    assert np.isnan(found.p or 0.0)
    assert why in found.notes[0]
