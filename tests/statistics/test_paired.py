"""Paired t and signed ranks: against SciPy, by counting all signs, and where a pair is not there."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy import stats

from emg2vsa.statistics.paired import paired_tests


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
