from __future__ import annotations

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.report.session_plots import PlotArea, thinned, ticks

AREA = PlotArea((0.0, 10.0), (-1.0, 1.0), width=1000, height=400)


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e4))
def test_ticks_are_round_few_and_inside(low, span):
    found = ticks(low, low + span, most=6)
    assert 1 <= len(found) <= 7
    assert min(found) >= low - 1e-6 * span
    assert max(found) <= low + span + 1e-6 * span
    if len(found) > 1:
        assert np.allclose(np.diff(found), found[1] - found[0])


def test_a_line_is_drawn_where_its_points_are():
    x, y = np.array([0.0, 2.5, np.nan, 5.0, 10.0]), np.array([-1.0, 0.3, 0.0, -0.4, 1.0])
    numbers = np.array(re.findall(r"-?\d+", AREA.line(x, y)), dtype=int).reshape(-1, 2)
    known = np.isfinite(x)
    assert np.array_equal(np.cumsum(numbers, axis=0), np.column_stack([AREA.x(x[known]), AREA.y(y[known])]))


def test_larger_is_higher_and_ends_meet_the_frame():
    assert AREA.y(1.0) == AREA.top
    assert AREA.y(-1.0) == AREA.height - AREA.bottom
    assert AREA.x(0.0) == AREA.left
    assert AREA.x(10.0) == AREA.width - AREA.right


def test_a_line_of_nothing_is_nothing():
    assert AREA.line(np.array([np.nan]), np.array([1.0])) == ""
    assert AREA.dots(np.empty(0), np.empty(0)) == ""


@given(st.integers(1, 5000), st.integers(0, 2**32 - 1))
def test_thinning_keeps_order_and_extremes(n, seed):
    y = np.random.default_rng(seed).standard_normal(n)
    x = np.arange(n, dtype=float)
    few_x, few_y = thinned(x, y, 300)
    assert few_x.size <= 300
    assert np.all(np.diff(few_x) >= 0)
    assert np.array_equal(y[few_x.astype(int)], few_y)
    assert few_y.max() == y.max()
    assert few_y.min() == y.min()
