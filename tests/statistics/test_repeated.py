"""Treatments on the same people: against SciPy and statsmodels, published tables, and by counting all signs."""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.anova import AnovaRM

from emg2vsa.statistics.repeated import paired_tests, rm_anova


def treated(seed: int, n: int = 14, k: int = 5) -> np.ndarray:
    rng = np.random.default_rng(seed)
    mixing = np.eye(k) + 0.3 * rng.standard_normal((k, k))
    return np.asarray(rng.standard_normal((n, k)) @ mixing + 0.3 * np.arange(k) + rng.standard_normal((n, 1)))


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


def test_paired_t_is_scipys() -> None:
    values = np.random.default_rng(0).standard_normal((14, 4)) + np.array([0.0, 0.3, 1.0, 1.0])
    found = paired_tests(values)
    for pair, (i, j) in enumerate(zip(found.t.first, found.t.second, strict=True)):
        peer = stats.ttest_rel(values[:, i], values[:, j])
        interval = peer.confidence_interval()
        assert found.t.statistic[0, pair] == pytest.approx(peer.statistic, rel=1e-12)
        assert found.t.p[0, pair] == pytest.approx(peer.pvalue, rel=1e-11)
        assert (found.t.low[0, pair], found.t.high[0, pair]) == pytest.approx((interval.low, interval.high), rel=1e-10)


@pytest.mark.parametrize(
    "differences", [[1.0, 2.0, -3.0, 4.0, 5.0], [1.0, 1.0, -1.0, 2.0, 2.0, -2.0], [1.0, 0.0, 2.0, 3.0]]
)
def test_signed_ranks_count_all_signs(differences: list[float]) -> None:
    values = np.stack([differences, np.zeros(len(differences))], axis=1)
    own = np.array([d for d in differences if d != 0])
    ranks = stats.rankdata(np.abs(own))
    middle, seen = ranks.sum() / 2, ranks[own > 0].sum()
    sums = np.array([ranks[np.array(signs)].sum() for signs in product([True, False], repeat=own.size)])
    p = np.mean(np.abs(sums - middle) >= abs(seen - middle) - 1e-9)
    assert paired_tests(values).signed_rank_p[0, 0] == pytest.approx(p, rel=1e-13)


def test_signed_ranks_of_many_are_scipys() -> None:
    rng = np.random.default_rng(3)
    for n in (30, 200):
        values = rng.standard_normal((n, 2)) + np.array([0.2, 0.0])
        peer = stats.wilcoxon(*values.T, method="exact" if n == 30 else "asymptotic", correction=False)
        assert paired_tests(values).signed_rank_p[0, 0] == pytest.approx(peer.pvalue, rel=1e-10)


@pytest.mark.parametrize(
    ("tries", "low", "high"), [(200, 0.91, 0.985), pytest.param(2000, 0.93, 0.97, marks=pytest.mark.slow)]
)
def test_the_interval_of_g_covers(tries: int, low: float, high: float) -> None:
    """If 88 % were covered instead of 95 %, it would fail for 93 % of samples of 200 and all of those of 2000."""
    rng, inside = np.random.default_rng(5), 0
    for _ in range(tries):
        found = paired_tests(np.stack([rng.standard_normal(12) + 0.8, np.zeros(12)], axis=1))
        inside += found.g_low[0, 0] <= 0.8 * 0.9305 <= found.g_high[0, 0]  # the interval is shrunk as g is
    assert low < inside / tries < high


def test_a_gap_costs_its_own_pairs_only() -> None:
    values = np.random.default_rng(1).standard_normal((6, 3))
    gap = values.copy()
    gap[2, 0] = np.nan
    found, whole = paired_tests(gap), paired_tests(values)
    assert found.t.n[0].tolist() == [5, 5, 6]
    assert found.t.p[0, 2] == whole.t.p[0, 2]


@pytest.mark.parametrize("values", [np.ones((5, 2)), np.ones((1, 3)), np.full((4, 2), np.nan)])
def test_nothing_to_test_is_not_a_number(values: np.ndarray) -> None:
    found = paired_tests(values)
    assert np.isnan(found.t.p).all()
    assert np.isnan(found.signed_rank_p).all()


RATINGS = np.array([[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7.0]])
"""Four judges on six targets, Shrout and Fleiss (1979), table 2."""


def test_agreement_is_that_of_shrout_and_fleiss() -> None:
    """And of R, psych::ICC of the same table."""
    outcome = rm_anova(RATINGS).consistency()
    assert outcome.interval is not None
    assert [round(x, 3) for x in (outcome.estimate or 0, *outcome.interval)] == [0.715, 0.342, 0.946]
    assert (round(outcome.statistic or 0, 2), round(outcome.p or 0, 6)) == (11.03, 0.000135)
    assert (outcome.df, outcome.n) == ((5.0, 15.0), 24)


def test_intervals_of_agreement_cover() -> None:
    """Subject SD 1, error SD 1: the true value is 1 / 2, whatever the raters."""
    rng = np.random.default_rng(7)
    values = rng.standard_normal((4000, 12, 1)) + 0.5 * rng.standard_normal((4000, 1, 5))
    found = rm_anova(values + rng.standard_normal((4000, 12, 5)))
    ends = np.array([found.consistency(i).interval for i in range(4000)])
    assert np.mean((ends[:, 0] <= 0.5) & (ends[:, 1] >= 0.5)) == pytest.approx(0.95, abs=0.013)


def test_a_person_with_a_gap_is_left_out() -> None:
    x = treated(1)
    x[3, 2] = np.nan
    assert rm_anova(x).f[0] == pytest.approx(rm_anova(np.delete(x, 3, axis=0)).f[0], rel=1e-12)
