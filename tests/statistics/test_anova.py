"""One-way ANOVA and LSD: NIST, scipy, and what must not change the answer."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.oneway import anova_oneway

from emg2vsa.companions.groups import group_tests
from emg2vsa.statistics.anova import brown_forsythe, one_way, welch
from emg2vsa.statistics.post_hoc import lsd
from tests.statistics.unequal_groups import DESIGNS, groups_of

CEILING = {
    "SiRstv": 13.1, "SmLs01": 15, "SmLs02": 15, "SmLs03": 15, "AtmWtAg": 10.2, "SmLs04": 10.4,
    "SmLs05": 10.2, "SmLs06": 10.2, "SmLs07": 4.4, "SmLs08": 4.2, "SmLs09": 4.2,
}  # fmt: skip
"""Digits of F that exact arithmetic gives on the doubles nearest to the decimal data."""


def nist(path: Path) -> tuple[list[list[str]], list[str]]:
    """Groups of decimal numbers as text, and the numbers of the certified table from the between row on."""
    lines = path.read_text().splitlines()
    rows = [line.split() for line in lines[60:] if len(line.split()) == 2]
    groups: dict[str, list[str]] = {}
    for group, value in rows:
        groups.setdefault(group, []).append(value)
    certified = " ".join(line for line in lines[40:60] if line.strip())
    numbers = [word for word in certified.split() if any(c.isdigit() for c in word)]
    return list(groups.values()), numbers


def digits(value: float, certified: str) -> float:
    error = abs(Decimal(float(value)) - Decimal(certified)) / abs(Decimal(certified))
    return 15.0 if error == 0 else min(15.0, -float(error.log10()))


@pytest.mark.parametrize("name", CEILING)
def test_nist_reaches_what_doubles_allow(name: str, shared_data: Callable[[str], Path]) -> None:
    groups, certified = nist(shared_data(f"nist/nist_anova/{name}.dat"))
    anova = one_way(np.array(groups, dtype=np.float64))
    assert digits(anova.f[0], certified[3]) >= CEILING[name] - 0.1
    assert anova.df1[0] == int(certified[0])
    assert anova.df2[0] == int(certified[4])


@pytest.mark.parametrize("name", CEILING)
def test_nist_from_decimal_text_is_right_to_14_digits(name: str, shared_data: Callable[[str], Path]) -> None:
    groups, certified = nist(shared_data(f"nist/nist_anova/{name}.dat"))
    anova = one_way([[Decimal(value) for value in group] for group in groups])
    assert digits(anova.f[0], certified[3]) >= 14.5
    assert digits(anova.eta2[0], certified[7]) >= 14.4
    assert digits(anova.sd[0], certified[8]) >= 14.4


def unbalanced(seed: int, k: int = 5, n: int = 10) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((k, n)) + 0.4 * np.arange(k)[:, None]
    values[np.arange(n) >= rng.integers(2, n + 1, (k, 1))] = np.nan
    return values


def test_batch_of_unbalanced_designs_is_scipys() -> None:
    designs = np.array([unbalanced(seed) for seed in range(30)])
    anova = one_way(designs)
    for i, design in enumerate(designs):
        peer = stats.f_oneway(*(group[np.isfinite(group)] for group in design))
        np.testing.assert_allclose([anova.f[i], anova.p[i]], peer, rtol=1e-12)
    np.testing.assert_allclose(anova.mean, np.nanmean(designs, axis=2), rtol=1e-13)
    np.testing.assert_array_equal(anova.count, np.isfinite(designs).sum(axis=2))


def test_empty_groups_do_not_count() -> None:
    values = unbalanced(1)
    padded = np.vstack([np.full(10, np.nan), values[:2], np.full(10, np.nan), values[2:]])
    with_empty, without = one_way(padded), one_way(values)
    assert with_empty.df1[0] == 4
    np.testing.assert_allclose(with_empty.f, without.f, rtol=1e-14)
    assert np.isnan(lsd(with_empty).p[0, 0])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_f_is_t_squared_with_two_groups(seed: int) -> None:
    anova = one_way(unbalanced(seed, k=2))
    pair = lsd(anova)
    np.testing.assert_allclose(anova.f[0], pair.statistic[0, 0] ** 2, rtol=1e-10)
    np.testing.assert_allclose(anova.p[0], pair.p[0, 0], rtol=1e-9)


def test_lsd_pools_the_sd_of_all_groups() -> None:
    values = unbalanced(3)
    anova = one_way(values)
    pairs = lsd(anova, 0.99)
    groups = [group[np.isfinite(group)] for group in values]
    df = sum(map(len, groups)) - 5
    sd = np.sqrt(sum(((g - g.mean()) ** 2).sum() for g in groups) / df)
    assert pairs.first.size == 10
    for q, (i, j) in enumerate(zip(pairs.first, pairs.second, strict=True)):
        se = sd * np.sqrt(1 / groups[i].size + 1 / groups[j].size)
        difference = groups[i].mean() - groups[j].mean()
        np.testing.assert_allclose(pairs.statistic[0, q], difference / se, rtol=1e-11)
        np.testing.assert_allclose(pairs.p[0, q], 2 * stats.t.sf(abs(difference / se), df), rtol=1e-11)
        np.testing.assert_allclose(pairs.high[0, q], difference + stats.t.ppf(0.995, df) * se, rtol=1e-11)
    outcome = pairs.outcome(0, 9)
    assert outcome.n == groups[3].size + groups[4].size
    assert outcome.confidence == 0.99
    assert outcome.interval is not None
    assert outcome.interval[0] < (outcome.estimate or 0) < outcome.interval[1]


def test_interval_excludes_zero_exactly_when_p_is_small() -> None:
    pairs = lsd(one_way(np.array([unbalanced(seed) for seed in range(40)])), 0.95)
    np.testing.assert_array_equal((pairs.low > 0) | (pairs.high < 0), pairs.p < 0.05)


def test_exact_types_and_gaps() -> None:
    exact = one_way([[Fraction(1, 3), 2, None], [Decimal("4.5"), float("nan"), 5]])
    np.testing.assert_allclose(exact.f, one_way([[1 / 3, 2, np.nan], [4.5, np.nan, 5]]).f, rtol=1e-14)
    np.testing.assert_allclose(exact.mean[0], [7 / 6, 4.75], rtol=1e-15)


def test_groups_of_two_are_no_test() -> None:
    """Both values are equally far from their median: F would be infinite for any data."""
    found = brown_forsythe(np.random.default_rng(0).standard_normal((200, 3, 2)))
    assert np.isnan([found.statistic, found.p]).all()


def test_size_with_four_and_more() -> None:
    for n, most in ((4, 0.09), (10, 0.06)):
        p = brown_forsythe(np.random.default_rng(2).standard_normal((4000, 5, n))).p
        assert 0.02 < np.mean(p < 0.05) < most


def test_welch_is_statsmodels() -> None:
    found = welch(DESIGNS)
    for i, design in enumerate(DESIGNS):
        peer = anova_oneway(groups_of(design), use_var="unequal")
        np.testing.assert_allclose(
            [found.statistic[i], found.df[1][i], found.p[i]], [peer.statistic, peer.df[1], peer.pvalue], 1e-11
        )


def test_brown_forsythe_is_scipys() -> None:
    found = brown_forsythe(DESIGNS)
    for i, design in enumerate(DESIGNS):
        np.testing.assert_allclose([found.statistic[i], found.p[i]], stats.levene(*groups_of(design)), rtol=1e-10)


def test_groups_of_two_in_rational_numbers() -> None:
    values = [[1, 4], [2, 3], [10, 12]]
    found = group_tests(np.array(values, dtype=float))
    exact = [[Fraction(v) for v in group] for group in values]
    means, grand = [sum(g) / 2 for g in exact], Fraction(sum(map(sum, values)), 6)
    between = 2 * sum((m - grand) ** 2 for m in means)
    within = sum((v - m) ** 2 for g, m in zip(exact, means, strict=True) for v in g)
    assert found.anova.f[0] == pytest.approx(float(between / 2 / (within / 3)), rel=1e-14)
    with mpmath.workdps(30):
        x = mpmath.mpf(3) / (3 + 2 * mpmath.mpf(between / 2 / (within / 3)).real)
        assert found.anova.p[0] == pytest.approx(float(mpmath.betainc(1.5, 1, 0, x, regularized=True)), rel=1e-13)
    pair = lsd(found.anova)
    t = (means[0] - means[1]) / mpmath.sqrt(mpmath.mpf(within.numerator) / within.denominator / 3)
    assert pair.statistic[0, 0] == pytest.approx(float(t), abs=1e-15)


def test_sd_of_one_constant_group_beside_another() -> None:
    values = np.array([[1.0, 1.0, 1.0], [2.0, 2.5, 2.0]])
    peer = stats.ttest_ind_from_stats(1, 0, 3, 13 / 6, np.std(values[1], ddof=1), 3)
    assert lsd(one_way(values)).p[0, 0] == pytest.approx(peer.pvalue, rel=1e-12)
