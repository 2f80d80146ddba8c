"""Force bins over ragged trials."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.curves.force_bins import bin_edges, bin_means, fit_edges, pad_rows
from emg2vsa.errors import SettingError


def test_papers_bins_end_with_a_shorter_one() -> None:
    edges = bin_edges(0.5, 7.0, 0.3)
    assert edges.size == 23
    np.testing.assert_allclose(np.diff(edges)[:-1], 0.3, rtol=1e-12)
    np.testing.assert_allclose(edges[[0, 1, -2, -1]], [0.5, 0.8, 6.8, 7.0], rtol=1e-15)


@pytest.mark.parametrize(
    ("low", "high", "width", "bins"), [(0.5, 7.1, 0.3, 22), (0.5, 0.6, 0.3, 1), (1.0, 2.0, 0.1, 10)]
)
def test_number_of_bins(low: float, high: float, width: float, bins: int) -> None:
    edges = bin_edges(low, high, width)
    assert edges.size == bins + 1
    assert edges[0] == low
    assert edges[-1] == high
    assert (np.diff(edges) > 0).all()


def test_swapped_window_is_refused() -> None:
    with pytest.raises(SettingError, match=r"window\.force_n"):
        bin_edges(7.0, 0.5, 0.3)


def test_bins_too_narrow_for_the_memory_are_refused() -> None:
    assert fit_edges(0.5, 7.0, 0.0065).size == 1001
    assert fit_edges(0.1, 0.4, 0.0003).size == 1001  # 0.4 - 0.1 is a little more than 1000 x 0.0003
    with pytest.raises(SettingError, match=r"at most 1000 bins from 0\.5 to 7 N, but found 1084 bins of 0\.006 N"):
        fit_edges(0.5, 7.0, 0.006)


def test_means_of_two_trials() -> None:
    force = np.array([1.0, 1.5, 2.0, 3.0, 0.9, 3.1, 1.0, np.nan, 2.5])
    v = np.array([1.0, 3.0, 5.0, 7.0, 99.0, 99.0, 2.0, 99.0, np.nan])
    bins = bin_means(force, v, np.array([0, 6, 9]), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(bins.v, [[2.0, 6.0], [2.0, np.nan]])
    np.testing.assert_allclose(bins.force_n, [[np.sqrt(1.5), np.sqrt(6.0)], [1.0, np.nan]])
    np.testing.assert_array_equal(bins.samples, [[2, 2], [1, 0]])


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_logarithmic_law_passes_through_the_bin_means(seed: int) -> None:
    force = np.random.default_rng(seed).uniform(0.5, 7.0, 300)
    bins = bin_means(force, 3 + 2 * np.log(force), np.array([0, 100, 300]), bin_edges(0.5, 7.0, 0.3))
    np.testing.assert_allclose(bins.v, 3 + 2 * np.log(bins.force_n), rtol=1e-13)


def test_no_trial_and_a_trial_without_samples() -> None:
    edges = np.array([1.0, 2.0, 3.0])
    assert bin_means(np.empty(0), np.empty(0), np.array([0]), edges).v.shape == (0, 2)
    assert np.isnan(bin_means(np.empty(0), np.empty(0), np.array([0, 0]), edges).v).all()


def test_rows_are_padded_with_nan() -> None:
    padded = pad_rows(np.array([1.0, 2.0, 3.0]), np.array([0, 1, 1, 3]))
    np.testing.assert_array_equal(padded, [[1.0, np.nan], [np.nan, np.nan], [2.0, 3.0]])
    assert pad_rows(np.empty(0), np.array([0])).shape == (0, 0)
