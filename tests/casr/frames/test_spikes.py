"""Readings that cannot be, and the steep forces that can."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from casr.frames import note_on_spikes, spikes

TIME_S = np.arange(0, 4, 0.005)


def log(rate_n_s: float, noise_n: float, seed: int, peak_n: float = 7.0) -> np.ndarray:
    """Rest, rise, a sharp peak, fall and rest."""
    rise = rate_n_s * np.clip(TIME_S - 1.5, 0, None)
    force = np.minimum(rise, np.clip(2 * peak_n - rise, 0, None))
    return force + np.random.default_rng(seed).normal(0, noise_n, TIME_S.size)


@given(st.floats(-1, 2.3), st.floats(-4, -0.7), st.integers(0, 10_000))
def test_no_rise_or_peak_is_a_spike(log_rate, log_noise, seed):
    assert not spikes(log(10**log_rate, 10**log_noise, seed)).any()


@given(st.floats(-1, 1.5), st.integers(5, 790), st.integers(1, 2), st.floats(9, 20), st.integers(0, 10_000))
def test_one_or_two_wild_rows_are_found_and_no_other(log_rate, at, width, height_n, seed):
    force = log(10**log_rate, 0.01, seed)
    force[at : at + width] = height_n
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), np.arange(at, at + width))


@pytest.mark.parametrize(
    "force_n",
    [
        [0, 0, 0, 0, 3, 7, 3, 0, 0, 0],
        [0, 0, 0, 0, 0, 8, 8, 8, 8, 8],
        [0, 0.01, -0.01, 0, 0.2, 0.4, 0.6, 2, 4, 7, 5, 1, 0.2, 0],
        [0, 0, 0, 0, 9, 9, 9, 0, 0, 0],
        [0, 9, 0],
        [],
    ],
    ids=["tap", "step", "press", "three", "short", "empty"],
)
def test_what_a_press_may_do_in_a_few_frames(force_n):
    assert not spikes(force_n).any()


def test_missing_readings_are_passed_over():
    force = [0, 0, np.nan, 0.01, 12, np.nan, 0, 0, 0.01, 0, 0.01, 0]
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), [4])
    found = spikes(force)
    assert note_on_spikes(found, np.array(force), "of 12 rows") == (
        "1 of 12 rows is a spike (up to 12 N) and left out",
    )
    assert note_on_spikes(found & False, np.array(force), "of 12 rows") == ()


def test_a_real_grip_keeps_all_but_one_glitch(shared_data: Callable[[str], Path]):
    """5 s at 1000 Hz of 0 to 98 units; row 2539 falls by 2.7 for a millisecond amid steps of 0.06."""
    force = np.loadtxt(shared_data("emg/emg_force/novainstrumentation_force.txt"))[1]
    np.testing.assert_array_equal(np.flatnonzero(spikes(force)), [2539])
    for every in (5, 20, 50):
        assert not spikes(force[::every]).any(), "steep as it is at a frame's rate"
