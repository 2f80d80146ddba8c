"""Bayes factors beside adaptive high-precision integrals of their definition, and published values."""

from __future__ import annotations

import tracemalloc

import mpmath as mp
import numpy as np
import pytest
from scipy import integrate, linalg

from emg2vsa.companions.groups import equality_tests
from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.bayes import SCALE, jzs_anova

CASES = [(20, 20, 1.1), (10, 10, 0.0), (5, 9, -9.0), (2, 1, 1.5), (300, 700, 0.2)]


def of_the_paper(t: float, n1: int, n2: int | None, r: float) -> mp.mpf:
    """BF01, equation 1 of Rouder and others (2009), with the scale r."""
    n = mp.mpf(n1) if n2 is None else mp.mpf(n1) * n2 / (n1 + n2)
    df = n1 - 1 if n2 is None else n1 + n2 - 2

    def integrand(log_g: mp.mpf) -> mp.mpf:
        g = mp.exp(log_g)
        shrink = 1 + n * g * mp.mpf(r) ** 2
        fit = (1 + mp.mpf(t) ** 2 / (shrink * df)) ** (-mp.mpf(df + 1) / 2)
        return fit * mp.exp(-1 / (2 * g)) / mp.sqrt(shrink * 2 * mp.pi * g)

    with_effect = mp.quad(integrand, [-6, -3, -1, 0, 1, 2, 4, 8, 12, 20, 40, 80])
    return (1 + mp.mpf(t) ** 2 / df) ** (-mp.mpf(df + 1) / 2) / with_effect


@pytest.mark.parametrize("case", CASES)
def test_two_groups_have_the_integral_of_the_paper(case: tuple[int, int, float]) -> None:
    n1, n2, shift = case
    values = np.full((2, max(n1, n2)), np.nan)
    rng = np.random.default_rng(n1)
    values[0, :n1], values[1, :n2] = rng.standard_normal(n1), shift + rng.standard_normal(n2)
    t = float(np.sqrt(one_way(values).f[0]))
    with mp.workdps(30):
        # the difference of two groups has the scale r sqrt(2) where their effects have r
        expected = of_the_paper(t, n1, n2, SCALE * np.sqrt(2))
        assert abs(mp.mpf(float(jzs_anova(values).bf01[0])) / expected - 1) < 2e-12


def test_the_paper_s_integral_gives_published_values() -> None:
    """Rouder and others (2009): t = 2.03, N = 80, r = 1 gives 1.56 for the null."""
    assert round(float(of_the_paper(2.03, 80, None, 1.0)), 2) == 1.56
    # R, BayesFactor 0.9: ttestBF(sleep$extra[1:10], sleep$extra[11:20], paired = TRUE) = 17.25888
    extra = np.array(
        [[0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0], [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]]
    )
    difference = extra[0] - extra[1]
    t = difference.mean() / difference.std(ddof=1) * np.sqrt(10)
    assert 1 / float(of_the_paper(t, 10, None, np.sqrt(0.5))) == pytest.approx(17.25888, abs=5e-6)


def by_matrices(groups: list[np.ndarray]) -> float:
    """BF01 of a one-way design from its marginal likelihood, Rouder and others (2012), section on fixed effects."""
    y = np.concatenate(groups)
    k, n = len(groups), y.size
    dummies = np.repeat(np.eye(k), [len(group) for group in groups], axis=0)
    sums_to_zero = linalg.null_space(np.ones((1, k)))
    x = dummies @ sums_to_zero
    x, y = x - x.mean(axis=0), y - y.mean()

    def integrand(log_g: float) -> float:
        g = np.exp(log_g)
        precision = x.T @ x + np.eye(k - 1) / g
        left = 1 - y @ x @ np.linalg.solve(precision, x.T @ y) / (y @ y)
        log = -(k - 1) / 2 * log_g - np.linalg.slogdet(precision)[1] / 2 - (n - 1) / 2 * np.log(left)
        prior = np.log(SCALE) - np.log(2 * np.pi) / 2 - log_g / 2 - SCALE**2 / (2 * g)
        return float(np.exp(log + prior))

    return 1 / integrate.quad(integrand, -12, 60, epsabs=0, epsrel=1e-11, limit=500)[0]


def test_unbalanced_designs_are_their_marginal_likelihood() -> None:
    rng = np.random.default_rng(3)
    values = rng.standard_normal((5, 4, 10)) + 0.5 * np.arange(4)[:, None]
    values[1, 0, 3:] = values[1, 2, 8:] = values[3, 1] = np.nan
    found = jzs_anova(values)
    for i, design in enumerate(values):
        groups = [group[np.isfinite(group)] for group in design]
        peer = by_matrices([group for group in groups if group.size])
        assert found.bf01[i] == pytest.approx(peer, rel=1e-9)


def test_equal_groups_speak_for_the_null_the_more_the_more_values() -> None:
    values = np.full((4, 2, 5000), np.nan)
    for row, n in zip(values, (6, 50, 500, 5000), strict=True):
        row[:, :n] = np.resize([1.0, -1.0], n)
    assert (np.diff(jzs_anova(values).bf01) > 0).all()
    apart = np.array([0.0, 1.0, 2.0, 9.0, 50.0])[:, None, None] * np.array([[0.0], [1.0]]) + values[1, :, :10]
    assert (np.diff(jzs_anova(apart).bf01) < 0).all()


def test_many_groups_take_no_matrix_of_all_pairs_of_them() -> None:
    values = np.random.default_rng(0).standard_normal((1, 1000, 4))
    values[0, ::3, 2:] = np.nan
    jzs_anova(values[:, :2])
    tracemalloc.start()
    found = jzs_anova(values)
    equality_tests(values, one_way(values), 0.05)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.isfinite(found.log_bf01[0])
    assert peak < 4e6  # one number of every pair is 8 MB
