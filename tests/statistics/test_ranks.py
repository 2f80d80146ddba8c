"""Tests on ranks beside scipy, published numbers, and what must not change the answer."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.statistics.kruskal import dunn, kruskal, midranks, smallest_worst_p
from emg2vsa.statistics.mann_whitney import differences_at, mann_whitney
from emg2vsa.statistics.repeated import friedman

SEPARATED = np.arange(30.0).reshape(3, 10)


def tied(seed: int, k: int = 4, n: int = 9) -> np.ndarray:
    rng = np.random.default_rng(seed)
    values = np.floor(rng.uniform(0, 8, (k, n)) + 0.7 * np.arange(k)[:, None])
    values[np.arange(n) >= rng.integers(3, n + 1, (k, 1))] = np.nan
    return values


DESIGNS = np.array([tied(seed) for seed in range(15)])


def groups_of(design: np.ndarray) -> list[np.ndarray]:
    return [group[np.isfinite(group)] for group in design]


def test_midranks_are_scipys_and_skip_nan() -> None:
    rows = DESIGNS.reshape(15, -1)
    np.testing.assert_array_equal(midranks(rows), stats.rankdata(rows, axis=1, nan_policy="omit"))


def test_kruskal_is_scipys() -> None:
    found = kruskal(DESIGNS)
    for i, design in enumerate(DESIGNS):
        np.testing.assert_allclose([found.h[i], found.p[i]], stats.kruskal(*groups_of(design)), rtol=1e-13)
        assert found.epsilon2[i] == pytest.approx(found.h[i] / (found.count[i].sum() - 1), rel=1e-14)


def test_separated_groups_give_the_p_of_the_notes() -> None:
    found = kruskal(SEPARATED)
    assert found.p[0] == pytest.approx(2.49e-6, rel=1e-3)
    assert dunn(found).p[0, 0] == pytest.approx(0.03326, abs=5e-6)
    assert 3 * mann_whitney(SEPARATED).p[0, 0] == pytest.approx(6 / 184756, rel=1e-13)


def test_floor_of_the_worst_p() -> None:
    assert smallest_worst_p(3, 10)[1] == pytest.approx(dunn(kruskal(SEPARATED)).p.max(), rel=1e-13)
    assert smallest_worst_p(4, 10) == pytest.approx((0.0558, 0.335), abs=5e-4)
    assert smallest_worst_p(4, 2)[1] == 1.0
    assert np.isnan(smallest_worst_p(1, 10)).all()


@given(st.integers(0, 2**32 - 1), st.integers(2, 5), st.integers(2, 8))
@settings(max_examples=40, deadline=None)
def test_no_untied_design_beats_the_floor(seed: int, groups: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((groups, count)) + rng.permutation(groups)[:, None] * rng.choice([0.5, 2.0, 5.0])
    assert dunn(kruskal(values)).p.max() >= smallest_worst_p(groups, count)[1] * (1 - 1e-12)


def test_two_groups_of_dunn_are_kruskal() -> None:
    found = kruskal(DESIGNS[:, :2])
    np.testing.assert_allclose(dunn(found).p[:, 0], found.p, rtol=1e-12)


def test_exact_p_counts_every_permutation_with_ties() -> None:
    for seed in range(6):
        x, y = np.random.default_rng(seed).integers(0, 5, (2, 6)).astype(float)
        peer = stats.mannwhitneyu(x, y, method=stats.PermutationMethod(n_resamples=10**6))
        found = mann_whitney(np.array([x, y]))
        assert found.u[0, 0] == peer.statistic
        assert found.p[0, 0] == pytest.approx(peer.pvalue, rel=1e-13)
        assert found.rank_biserial[0, 0] == pytest.approx(2 * peer.statistic / 36 - 1)


@pytest.mark.parametrize(("n1", "n2"), [(5, 5), (10, 10), (4, 12), (30, 40)])
def test_exact_p_without_ties_is_scipys(n1: int, n2: int) -> None:
    rng = np.random.default_rng(n1)
    values = np.full((2, max(n1, n2)), np.nan)
    values[0, :n1], values[1, :n2] = rng.standard_normal(n1), rng.standard_normal(n2) + 0.8
    peer = stats.mannwhitneyu(*groups_of(values), method="exact")
    np.testing.assert_allclose(mann_whitney(values).p[0, 0], peer.pvalue, rtol=1e-11)


def test_interval_holds_the_shifts_that_are_not_rejected() -> None:
    x, y = np.random.default_rng(3).standard_normal((2, 9))
    found = mann_whitney(np.array([x + 1.3, y]))
    low, high = found.low[0, 0], found.high[0, 0]
    assert low < found.shift[0, 0] < high
    for shift, kept in ((low - 1e-9, False), (low + 1e-9, True), (high - 1e-9, True), (high + 1e-9, False)):
        assert bool(mann_whitney(np.array([x + 1.3 - shift, y])).p[0, 0] > 0.05) == kept


def test_differences_of_long_samples_are_those_of_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(9)
    values = np.round(rng.standard_normal((3, 4, 14)) * 3, 1)  # rounded: with ties
    values[0, 1, 5:] = np.nan
    direct = mann_whitney(values)
    monkeypatch.setattr("emg2vsa.statistics.mann_whitney._FEW", 0)
    monkeypatch.setattr("emg2vsa.statistics.mann_whitney._MANY", 20)
    searched = mann_whitney(values)
    for name in ("shift", "low", "high"):
        np.testing.assert_allclose(getattr(searched, name), getattr(direct, name), rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", ["smooth", "tied", "skewed", "rounded"])
def test_order_statistics_of_differences_are_those_of_the_sorted_ones(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("emg2vsa.statistics.mann_whitney._MANY", 2000)
    rng = np.random.default_rng(len(kind))
    for _ in range(10):
        n, m = rng.integers(200, 600, 2)
        x, y = {
            "smooth": (rng.standard_normal(n), rng.standard_normal(m)),
            "tied": (rng.integers(0, 30, n), rng.integers(0, 25, m)),
            "skewed": (rng.standard_exponential(n) ** 3, rng.standard_normal(m)),
            "rounded": (np.round(rng.standard_normal(n), 2), np.round(rng.standard_cauchy(m), 1)),
        }[kind]
        width = max(n, m)
        left, right = (np.pad(side.astype(float), (0, width - side.size), constant_values=np.nan) for side in (x, y))
        places = np.concatenate([rng.integers(0, n * m, 6), [0, n * m - 1]])
        found = differences_at(left[None, None], right[None, None], places[:, None, None])[:, 0, 0]
        ordered = np.sort(np.subtract.outer(x, y).ravel())[places]
        np.testing.assert_allclose(found, ordered, rtol=4e-16, atol=1e-15)


def test_friedman_is_scipys_and_leaves_gaps_out() -> None:
    values = np.random.default_rng(2).integers(0, 6, (5, 9, 4)).astype(float)
    values[0, 3, 1] = np.nan
    found = friedman(values)
    for i, design in enumerate(values):
        complete = design[np.isfinite(design).all(axis=1)]
        np.testing.assert_allclose([found.statistic[i], found.p[i]], stats.friedmanchisquare(*complete.T), rtol=1e-12)
    assert found.n[0] == 8
    assert "left out" in found.outcome(0).notes[0]


def test_few_values_and_many() -> None:
    single = mann_whitney(np.array([[1.0], [2.0]]))
    assert (single.p[0, 0], single.low[0, 0], single.high[0, 0]) == (1.0, -np.inf, np.inf)
    assert mann_whitney(np.full((2, 2), 3.0)).p[0, 0] == 1.0
    large = np.random.default_rng(1).standard_normal((2, 60))
    assert "normal" in mann_whitney(large).outcome().method
    np.testing.assert_allclose(mann_whitney(large).p[:, 0], kruskal(large).p, rtol=1e-12)
