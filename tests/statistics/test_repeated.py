"""Repeated measures and mixed models: peers, a dense likelihood, and the boundary where iterative programs fail."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.anova import AnovaRM

from emg2vsa.errors import DataError
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.repeated import rm_anova


def treated(seed: int, n: int = 14, k: int = 5) -> np.ndarray:
    rng = np.random.default_rng(seed)
    mixing = np.eye(k) + 0.3 * rng.standard_normal((k, k))
    return np.asarray(rng.standard_normal((n, k)) @ mixing + 0.3 * np.arange(k) + rng.standard_normal((n, 1)))


def study(
    seed: int, person: float = 0.7, interaction: float = 0.4, shape: tuple[int, int, int] = (14, 5, 10)
) -> np.ndarray:
    rng = np.random.default_rng(seed)
    p, s, _ = shape
    y = (
        rng.standard_normal(shape)
        + person * rng.standard_normal((p, 1, 1))
        + interaction * rng.standard_normal((p, s, 1))
    )
    return np.asarray(y + 0.3 * np.arange(s)[None, :, None])


def test_f_is_statsmodels_anovarm() -> None:
    designs = np.array([treated(seed) for seed in range(5)])
    found = rm_anova(designs)
    for i, x in enumerate(designs):
        table = pd.DataFrame({"y": x.ravel(), "p": np.repeat(np.arange(14), 5), "s": np.tile(np.arange(5), 14)})
        peer = AnovaRM(table, "y", "p", within=["s"]).fit().anova_table
        assert found.f[i] == pytest.approx(peer["F Value"].iloc[0], rel=1e-11)
        assert found.p[i] == pytest.approx(peer["Pr > F"].iloc[0], rel=1e-9)


def test_corrections_are_the_textbook_formulas() -> None:
    x = treated(3)
    found = rm_anova(x)
    s = np.cov(x.T)
    k, n = 5, 14
    c = np.eye(k) - 1 / k
    centred = c @ s @ c
    gg = np.trace(centred) ** 2 / ((k - 1) * np.sum(centred**2))
    assert found.epsilon_gg[0] == pytest.approx(gg, rel=1e-12)
    assert found.epsilon_hf[0] == pytest.approx((n * (k - 1) * gg - 2) / ((k - 1) * (n - 1 - (k - 1) * gg)), rel=1e-12)
    assert found.p_gg[0] == pytest.approx(stats.f.sf(found.f[0], gg * 4, gg * 52), rel=1e-10)
    assert found.outcome(0).df == pytest.approx((4 * gg, 52 * gg))


def test_mauchly_holds_its_level() -> None:
    x = np.random.default_rng(1).standard_normal((4000, 14, 4))
    assert abs(np.mean(rm_anova(x).mauchly_p < 0.05) - 0.05) < 3 * np.sqrt(0.05 * 0.95 / 4000)


@given(st.integers(0, 2**32 - 1), st.floats(-1e3, 1e3))
@settings(max_examples=30, deadline=None)
def test_two_treatments_are_the_paired_t_test(seed: int, shift: float) -> None:
    x = treated(seed, k=2)
    found = rm_anova((x + shift) * 1e-200)
    t = stats.ttest_rel(x[:, 0], x[:, 1])
    assert found.f[0] == pytest.approx(t.statistic**2, rel=1e-6)
    assert found.epsilon_gg[0] == pytest.approx(1.0)
    assert np.isnan(found.mauchly_p[0])


def test_gaps_and_hostile_designs() -> None:
    x = treated(1)
    x[3, 2] = np.nan
    found = rm_anova(x)
    assert found.f[0] == pytest.approx(rm_anova(np.delete(x, 3, axis=0)).f[0], rel=1e-12)
    assert "1 people with a gap" in found.outcome().notes[0]
    for hostile in (np.ones((5, 3)), np.ones((1, 3)), np.full((4, 3), np.nan)):
        outcome = rm_anova(hostile).outcome()
        assert np.isnan(outcome.statistic or 0.0)
        assert "undefined" in outcome.notes[-1]


def restricted_likelihood(y: np.ndarray, variance: np.ndarray) -> float:
    """From the dense covariance matrix of all values."""
    p, s, r = (index.ravel() for index in np.indices(y.shape))
    same_p, same_s = p[:, None] == p, s[:, None] == s
    v = variance[0] * same_p + variance[1] * (same_p & same_s) + variance[2] * ((same_p & same_s) & (r[:, None] == r))
    x = (s[:, None] == np.arange(y.shape[1])).astype(float)
    inverse = np.linalg.inv(v)
    information = x.T @ inverse @ x
    residual = y.ravel() - x @ np.linalg.solve(information, x.T @ inverse @ y.ravel())
    logs = np.linalg.slogdet(v)[1] + np.linalg.slogdet(information)[1]
    return float(-(logs + residual @ inverse @ residual + (y.size - x.shape[1]) * np.log(2 * np.pi)) / 2)


@pytest.mark.parametrize(("person", "interaction"), [(0.7, 0.4), (0.0, 0.0), (0.6, 0.0), (0.0, 0.5)])
def test_no_variances_are_likelier(person: float, interaction: float) -> None:
    for seed in range(3):
        y = study(seed, person, interaction, (6, 3, 4))
        found = balanced_mixed(y)
        best = restricted_likelihood(y, found.variance[0])
        for step in np.random.default_rng(seed).standard_normal((40, 3)) * 0.05:
            other = np.maximum(found.variance[0] + step, [0, 0, 1e-3])
            assert restricted_likelihood(y, other) <= best + 1e-9


@given(st.integers(0, 2**32 - 1), st.floats(-100, 100), st.sampled_from([1e-150, 1e-6, 1.0, 1e150]))
@settings(max_examples=30, deadline=None)
def test_unit_and_origin_of_the_mixed_model(seed: int, shift: float, scale: float) -> None:
    y = study(seed, shape=(5, 3, 4))
    found, other = balanced_mixed(y), balanced_mixed((y + shift) * scale)
    np.testing.assert_allclose(other.f, found.f, rtol=1e-8)
    np.testing.assert_allclose(other.variance / scale**2, found.variance, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(other.sd_ratio, found.sd_ratio, rtol=1e-6, atol=1e-6)


def test_beyond_all_numbers_a_variance_of_zero_stays_zero() -> None:
    y = study(next(s for s in range(50) if balanced_mixed(study(s, 0.0, 0.0)).variance[0, 0] == 0), 0.0, 0.0)
    with np.errstate(all="raise"):
        variance = balanced_mixed(y * 1e160).variance[0]
    assert variance[0] == 0
    assert np.isinf(variance[2])


def test_variance_zero_is_said() -> None:
    seed = next(s for s in range(50) if balanced_mixed(study(s, 0.0, 0.0)).variance[0, 0] == 0)
    outcome = balanced_mixed(study(seed, 0.0, 0.0)).outcome()
    assert "estimated as 0" in outcome.notes[0]
    assert outcome.estimate == 0.0
    assert outcome.interval is not None
    assert outcome.interval[1] > 0


def test_intervals_of_the_variances_cover() -> None:
    rng = np.random.default_rng(8)
    shape = (3000, 10, 4, 5)
    truth = np.array([0.5, 0.2, 1.0])
    y = rng.standard_normal(shape) + np.sqrt(0.5) * rng.standard_normal((3000, 10, 1, 1))
    y += np.sqrt(0.2) * rng.standard_normal((3000, 10, 4, 1))
    found = balanced_mixed(y)
    covered = np.mean((found.low <= truth) & (truth <= found.high), axis=0)
    assert (covered > 0.935).all()
    assert (covered < 0.985).all()


@pytest.mark.parametrize("values", [np.ones((1, 3, 2)), np.ones((4, 3, 1)), np.full((4, 3, 2), np.nan), np.ones(4)])
def test_gaps_and_missing_replicates_are_named(values: np.ndarray) -> None:
    with pytest.raises(DataError, match="balanced mixed model"):
        balanced_mixed(values)
