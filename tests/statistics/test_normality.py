"""Kolmogorov-Smirnov: the statistic against scipy, the p against exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from math import factorial, floor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.statistics.ks_exact import ks_survival
from emg2vsa.statistics.normality import ks_normal


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
        assert abs(tests.d[i] - peer.statistic) < 1e-15
        assert abs(tests.p[i] - peer.pvalue) < 2e-15
        assert tests.n[i] == x.size


def test_positive_samples_of_ten_are_never_raw_normal() -> None:
    tests = ks_normal(np.random.default_rng(4).uniform(1e-6, 5e-6, (50, 10)), standardise=False)
    assert (tests.d >= 0.5).all()
    assert (tests.p <= 0.0079).all()


@given(st.integers(0, 2**32 - 1), st.floats(-1e5, 1e5), st.floats(1e-3, 1e3))
@settings(max_examples=40, deadline=None)
def test_standardised_does_not_know_unit_sign_or_order(seed: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    x = rng.standard_normal(10)
    d = ks_normal(x, standardise=True).d
    for other in ((x + shift) * scale, -x, rng.permutation(x), x * 1e-300, x * 1e300):
        np.testing.assert_allclose(ks_normal(other, standardise=True).d, d, atol=1e-8)


@pytest.mark.parametrize("row", [[0.1] * 10, [0.1], [np.nan, np.nan], [1e300] * 3])
def test_no_spread_is_undefined_and_says_so(row: list[float]) -> None:
    tests = ks_normal(row, standardise=True)
    assert np.isnan(tests.d[0])
    assert np.isnan(tests.p[0])
    assert tests.outcome().notes[-1].startswith("undefined")


def test_outcome_names_the_variant() -> None:
    x = np.arange(10.0)
    assert "standardised" in ks_normal(x, standardise=True).outcome().method
    raw = ks_normal(x, standardise=False).outcome()
    assert "raw" in raw.method
    assert raw.n == 10
    assert raw.statistic_name == "D"
    assert raw.p < 0.05


def test_no_rows() -> None:
    assert ks_normal(np.empty((0, 4)), standardise=True).d.shape == (0,)
