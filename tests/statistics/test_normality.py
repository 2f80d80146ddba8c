"""Kolmogorov-Smirnov and Shapiro-Wilk: against scipy, exact rational arithmetic, and a published sample."""

from __future__ import annotations

from fractions import Fraction
from math import factorial, floor

import numpy as np
import pytest
from scipy import stats

from emg2vsa.statistics.normality import ks_normal, ks_survival, shapiro_wilk


def exact_survival(d: float, n: int) -> Fraction:
    """Marsaglia, Tsang and Wang (2003) in rational arithmetic."""
    k = floor(n * Fraction(d)) + 1
    m, h = 2 * k - 1, k - n * Fraction(d)
    matrix = [[Fraction(int(i - j + 1 >= 0)) for j in range(m)] for i in range(m)]
    for i in range(m):
        matrix[i][0] -= h ** (i + 1)
        matrix[m - 1][i] -= h ** (m - i)
    matrix[m - 1][0] += max(2 * h - 1, Fraction(0)) ** m
    for i in range(m):
        for j in range(i + 1):
            matrix[i][j] /= factorial(i - j + 1)
    row = [Fraction(int(i == k - 1)) for i in range(m)]
    for _ in range(n):
        row = [sum((row[i] * matrix[i][j] for i in range(m)), Fraction(0)) for j in range(m)]
    return 1 - row[k - 1] * factorial(n) / Fraction(n) ** n


@pytest.mark.parametrize("n", [1, 2, 5, 10, 20])
def test_p_is_exact_to_1e_15(n: int) -> None:
    d = np.random.default_rng(n).uniform(0.5 / n, min(0.99, 1.9 / np.sqrt(n)), 20)
    p = ks_survival(d, n)
    assert max(abs(float(Fraction(p[i]) - exact_survival(float(d[i]), n))) for i in range(20)) <= 1e-15


@pytest.mark.parametrize("n", [10, 20])
def test_tail_keeps_its_digits(n: int) -> None:
    d = np.array([0.55, 0.7, 0.9])
    relative = [
        float(Fraction(p) / exact_survival(x, n) - 1) for p, x in zip(ks_survival(d, n), d.tolist(), strict=True)
    ]
    np.testing.assert_allclose(relative, 0, atol=1e-11)


def test_branches_meet() -> None:
    n = 200
    d = np.sqrt(5.0 / n) + np.array([-1e-9, 1e-9])
    p = ks_survival(d, n)
    assert p[0] >= p[1]
    assert p[0] - p[1] < 1e-10


def test_survival_at_its_ends_and_for_long_samples() -> None:
    np.testing.assert_array_equal(ks_survival([0.0, 0.04, 1.0], 10), [1.0, 1.0, 0.0])
    assert np.isnan(ks_survival([np.nan], 10)[0])
    np.testing.assert_allclose(ks_survival([0.012], 10_000), stats.kstwo.sf(0.012, 10_000), atol=5e-3)


@pytest.mark.parametrize("standardise", [True, False])
def test_clusters_of_different_size_are_scipys(standardise: bool) -> None:
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((30, 12)) * 0.7 + 0.3
    rows[np.arange(12) >= rng.integers(3, 13, (30, 1))] = np.nan
    tests = ks_normal(rows, standardise=standardise)
    for i, row in enumerate(rows):
        x = row[np.isfinite(row)]
        peer = stats.ks_1samp((x - x.mean()) / x.std(ddof=1) if standardise else x, stats.norm.cdf)
        assert abs(tests.statistic[i] - peer.statistic) < 1e-15
        assert abs(tests.p[i] - peer.pvalue) < 2e-15
        assert tests.n[i] == x.size


def test_positive_samples_of_ten_are_never_raw_normal() -> None:
    tests = ks_normal(np.random.default_rng(4).uniform(1e-6, 5e-6, (50, 10)), standardise=False)
    assert (tests.statistic >= 0.5).all()
    assert (tests.p <= 0.0079).all()


def test_outcome_names_the_variant() -> None:
    x = np.arange(10.0)
    assert "standardised" in ks_normal(x, standardise=True).outcome().method
    raw = ks_normal(x, standardise=False).outcome()
    assert "raw" in raw.method
    assert raw.n == 10
    assert raw.statistic_name == "D"
    assert raw.p < 0.05


@pytest.mark.parametrize("n", [3, 4, 5, 6, 7, 10, 11, 12, 20, 50, 300, 5000])
def test_w_and_p_are_scipys_to_nine_digits(n: int) -> None:
    rng = np.random.default_rng(n)
    rows = np.concatenate([rng.standard_normal((6, n)), rng.exponential(size=(6, n))]) * 3e-6 + 1e-5
    found = shapiro_wilk(rows)
    peers = [stats.shapiro(row) for row in rows]
    # scipy takes its normal quantiles to 7 digits
    np.testing.assert_allclose(found.statistic, [peer.statistic for peer in peers], rtol=3e-9)
    np.testing.assert_allclose(found.p, [peer.pvalue for peer in peers], rtol=1e-7 if n <= 300 else 3e-6)


def test_the_eleven_men_of_shapiro_and_wilk() -> None:
    """Their weights (1965); R prints W = 0.78881, p-value = 0.006704."""
    found = shapiro_wilk([148, 154, 158, 160, 161, 162, 166, 170, 182, 195, 236])
    assert round(found.statistic[0], 5) == 0.78881
    assert round(found.p[0], 6) == 0.006704


def test_three_values_are_exact() -> None:
    x = np.array([0.0, 1.0, 3.0])
    w = np.max(np.diff(x[[0, 2]])) ** 2 / 2 / np.sum((x - x.mean()) ** 2)
    found = shapiro_wilk(x)
    assert found.statistic[0] == pytest.approx(w, rel=1e-14)
    assert found.p[0] == pytest.approx(6 / np.pi * (np.arcsin(np.sqrt(w)) - np.arcsin(np.sqrt(0.75))), rel=1e-13)
    assert shapiro_wilk([1.0, 2.0, 3.0]).p[0] == 1.0
    assert shapiro_wilk([1.0, 1.0, 3.0]).p[0] == pytest.approx(0.0, abs=1e-7)


def test_size_is_alpha() -> None:
    found = shapiro_wilk(np.random.default_rng(1).standard_normal((20_000, 10)))
    assert np.mean(found.p < 0.05) == pytest.approx(0.05, abs=0.005)


def test_rows_of_different_length_do_not_mix() -> None:
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((30, 14))
    rows[rng.random((30, 14)) < 0.4] = np.nan
    found = shapiro_wilk(rows)
    for i, row in enumerate(rows):
        alone = shapiro_wilk(row[np.isfinite(row)])
        np.testing.assert_allclose([found.statistic[i], found.p[i]], [alone.statistic[0], alone.p[0]], rtol=1e-12)
        assert found.n[i] == np.isfinite(row).sum()
