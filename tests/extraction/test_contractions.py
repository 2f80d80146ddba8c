"""Levels of maximum contractions: what was put in is found, and too short a recording is refused."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import SignalError
from emg2vsa.extraction.contractions import contraction_levels_v
from emg2vsa.settings import FilterSettings


def contraction(channel, level_v, seconds=6.0, held_s=2.0, seed=0):
    n = round(seconds * 1000)
    held = np.abs(np.arange(n) / 1000 - seconds / 2) < held_s / 2
    return channel(np.where(held, level_v, 2e-6) * np.random.default_rng(seed).standard_normal(n))


def test_the_largest_held_level_of_all_recordings(channel):
    parts = [
        {"EDC": contraction(channel, 4e-4), "FDS": contraction(channel, 1e-4, seed=1)},
        {"EDC": contraction(channel, 2e-4, seed=2), "FDS": contraction(channel, 3e-4, seed=3)},
    ]
    levels = contraction_levels_v(parts, FilterSettings(band_hz=(10.0, 499.0)))
    # mean rectified value of white noise through most of the band, the largest of a few half seconds
    assert levels["EDC"] == pytest.approx(4e-4 * np.sqrt(2 / np.pi), rel=0.1)
    assert levels["FDS"] == pytest.approx(3e-4 * np.sqrt(2 / np.pi), rel=0.1)


def test_one_peak_is_no_contraction(channel):
    levels = contraction_levels_v([{"EDC": contraction(channel, 4e-4, held_s=0.05)}], FilterSettings())
    assert levels["EDC"] < 0.25 * 4e-4


def test_too_short_a_recording(channel):
    with pytest.raises(SignalError, match="at least"):
        contraction_levels_v([{"EDC": channel(np.ones(20))}], FilterSettings())
