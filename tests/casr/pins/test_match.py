from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.pins import match_pins, pin_pitch_px
from emg2vsa.worlds.tactile import TACTIP_127

PINS = TACTIP_127.pins_px((149.5, 149.5))


@given(st.integers(0, 2**32 - 1))
def test_order_of_the_rows_does_not_matter(seed):
    order = np.random.default_rng(seed).permutation(len(PINS))
    before, after = match_pins(PINS, PINS[order] + 0.3, max_distance_px=10)
    assert np.array_equal(order[after], before)
    assert len(before) == len(PINS)


@given(st.floats(-9, 9), st.floats(-9, 9))
def test_shifts_below_half_a_pitch_match_every_pin(dx, dy):
    if np.hypot(dx, dy) > 9.9:
        return
    before, after = match_pins(PINS, PINS + np.array([dx, dy]), max_distance_px=10)
    assert np.array_equal(before, after)
    assert len(before) == len(PINS)


@given(st.integers(0, 2**32 - 1), st.integers(0, 30), st.integers(0, 30))
def test_one_to_one_within_reach(seed, n, m):
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0, 50, (n, 2)), rng.uniform(0, 50, (m, 2))
    i, j = match_pins(a, b, max_distance_px=8)
    assert len(set(i)) == len(i) == len(set(j)) == len(j)
    assert (np.hypot(*(a[i] - b[j]).T) <= 8).all()
    back_j, back_i = match_pins(b, a, max_distance_px=8)
    assert set(zip(i, j, strict=True)) == set(zip(back_i, back_j, strict=True))


def test_of_two_that_claim_one_the_nearer_gets_it():
    i, j = match_pins(np.array([[0.0, 0], [3, 0]]), np.array([[2.0, 0]]), max_distance_px=5)
    assert (list(i), list(j)) == ([1], [0])


def test_reach_may_differ_from_pin_to_pin_and_lost_pins_match_nothing():
    before = np.array([[0.0, 0], [50, 0], [np.nan, np.nan]])
    i, _ = match_pins(before, np.array([[4.0, 0], [54, 0]]), max_distance_px=np.array([3.0, 5.0, 99.0]))
    assert list(i) == [1]


def test_pitch_is_the_spacing_of_the_lattice():
    assert pin_pitch_px(PINS) == pytest.approx(20)
    assert np.isnan(pin_pitch_px(PINS[:1]))
