"""Small tools on arrays, against the plain way."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.arrays import aligned, median, quantiles, runs_of


@given(st.lists(st.booleans(), max_size=30))
def test_runs_are_those_of_groupby(mask):
    expected, at = [], 0
    for value, run in itertools.groupby(mask):
        size = len(list(run))
        expected += [(at, at + size)] if value else []
        at += size
    assert list(zip(*runs_of(np.array(mask, dtype=np.bool_)), strict=True)) == expected


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=30))
def test_median_is_that_of_numpy(values):
    assert median(np.array(values)) == np.median(values)


@pytest.mark.parametrize("n", [1, 2, 3, 10, 999, 1000, 1001, 20_002])
def test_quantiles_and_median_are_those_of_numpy(n):
    values = np.random.default_rng(n).standard_normal(n)
    shares = (0.0, 0.001, 0.05, 0.5, 0.8, 0.9995, 1.0)
    assert quantiles(np.sort(values), *shares) == pytest.approx(np.quantile(values, shares), rel=1e-14, abs=1e-15)
    assert median(values) == np.median(values)


@pytest.mark.parametrize("rows", [1, 2, 7])
def test_an_aligned_table_begins_with_a_line_of_the_cache(rows):
    table = aligned(rows, 5)
    assert table.shape == (rows, 5)
    assert table.dtype == np.float64
    assert table.ctypes.data % 64 == 0
