"""Equivalence: the two one-sided tests of scipy, their interval, and a power from simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from emg2vsa.errors import SettingError
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.post_hoc import pair_numbers
from emg2vsa.statistics.power import power_tost

DESIGNS = np.random.default_rng(2).standard_normal((6, 3, 9)) + 0.4 * np.arange(3)[:, None]
DESIGNS[2, 1, 5:] = np.nan


def scipys(x: np.ndarray, y: np.ndarray, margin: float) -> tuple[float, float, float]:
    """p and the 90 % interval."""
    x, y = x[np.isfinite(x)], y[np.isfinite(y)]
    low = stats.ttest_ind(x + margin, y, alternative="greater").pvalue
    high = stats.ttest_ind(x - margin, y, alternative="less").pvalue
    interval = stats.ttest_ind(x, y).confidence_interval(0.9)
    return max(low, high), interval.low, interval.high


def test_p_and_interval_are_scipys() -> None:
    found = tost(DESIGNS, 0.8)
    for i, design in enumerate(DESIGNS):
        for j, (a, b) in enumerate(zip(*pair_numbers(len(design)), strict=True)):
            peer = scipys(design[a], design[b], 0.8)
            np.testing.assert_allclose([found.p[i, j], found.low[i, j], found.high[i, j]], peer, rtol=1e-11)


@pytest.mark.parametrize("shift", [-0.3, 0.0, 0.3])
def test_t_is_that_of_the_side_that_is_harder_to_reject(shift: float) -> None:
    """At a difference of 0 both sides are equally hard, and the upper one is told."""
    x = np.array([1.0, 2.0, 4.0, 5.0])
    found = tost(np.stack([x + shift, x[::-1]])[None], 0.8)
    margin = 0.8 if shift < 0 else -0.8
    peer = stats.ttest_ind(x + shift + margin, x[::-1], equal_var=True).statistic
    assert found.t[0, 0] == pytest.approx(peer, rel=1e-12)


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 3), st.floats(0.01, 0.4))
@settings(max_examples=40, deadline=None)
def test_equivalent_exactly_where_the_interval_is_inside(seed: int, margin: float, alpha: float) -> None:
    values = np.random.default_rng(seed).standard_normal((4, 2, 8))
    found = tost(values, margin, alpha=alpha)
    np.testing.assert_array_equal(found.p < alpha, (found.low > -margin) & (found.high < margin))


def test_margin_in_sds_is_that_many_pooled_sds() -> None:
    found, (x, y) = tost(DESIGNS, 0.8, "sd"), DESIGNS[0, :2]
    np.testing.assert_allclose(found.margin, 0.8 * found.sd, rtol=1e-15)
    assert found.sd[0, 0] == pytest.approx(np.sqrt((x.var(ddof=1) + y.var(ddof=1)) / 2))
    assert tost(DESIGNS[0], float(found.margin[0, 1])).p[0, 1] == found.p[0, 1]
    assert tost([[1.0, np.nan, 2.0], [1.0, 2.0, 3.0]], 1.0).n[0, 0] == 5


def test_power_is_how_often_it_happens() -> None:
    values = np.random.default_rng(5).standard_normal((20_000, 2, 10))
    assert np.mean(tost(values, 1.36).p < 0.05) == pytest.approx(power_tost(1.36, 10, 10), abs=0.01)
    assert power_tost(0.0, 10, 10) == 0.0


@pytest.mark.parametrize(("margin", "alpha"), [(0.0, 0.05), (np.nan, 0.05), (1.0, 0.5)])
def test_impossible_settings_are_refused(margin: float, alpha: float) -> None:
    with pytest.raises(SettingError, match="equivalence"):
        tost(DESIGNS, margin, alpha=alpha)
