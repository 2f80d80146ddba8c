"""Small tools on arrays, against the plain way."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.arrays import median, runs_of


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
