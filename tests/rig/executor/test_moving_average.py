"""What a moving average of the force truly is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import freqz, group_delay

from emg2vsa.rig.executor.motion import MovingAverage


def test_it_is_the_mean_of_the_last_samples():
    average = MovingAverage(3, 200)
    assert [average.update(value) for value in (3, 5, 10, 0, 2)] == [3, 4, 6, 5, 4]


def test_no_rounding_stays_behind_and_no_nan():
    average = MovingAverage(2, 200)
    for value in (1e16, math.nan, 1.0):
        average.update(value)
    assert average.update(3.0) == 2.0


def test_the_papers_filter_is_18_hz_and_10_ms():
    average = MovingAverage(5, 200)
    assert average.cutoff_hz == pytest.approx(18.0, abs=0.2)
    assert average.delay_s == pytest.approx(0.010)
    assert average.description == "mean of 5 samples at 200 Hz: -3 dB at 18 Hz, delay 10 ms"


def test_5_hz_needs_18_samples():
    assert MovingAverage(18, 200).cutoff_hz == pytest.approx(5, abs=0.1)


@pytest.mark.parametrize("n", [2, 3, 5, 18, 100])
def test_cut_off_and_delay_against_scipy(n):
    average = MovingAverage(n, 200)
    taps = np.ones(n) / n
    _, response = freqz(taps, worN=[average.cutoff_hz], fs=200)
    assert abs(response[0]) == pytest.approx(math.sqrt(0.5), rel=1e-9)
    _, delay = group_delay((taps, [1.0]), w=[average.cutoff_hz / 2], fs=200)
    assert average.delay_s * 200 == pytest.approx(delay[0])


def test_one_sample_is_no_filter():
    average = MovingAverage(1, 200)
    assert (average.cutoff_hz, average.delay_s) == (math.inf, 0)
    assert average.description.startswith("no filter")
