from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.recording import INITIAL_REST_S, longest_record_s, make_presses, smooth_step

WINDOW_N = (0.5, 7.0)
SETTINGS = SimulationSettings(repetitions=10)


def test_crossings_are_where_the_force_says() -> None:
    presses = make_presses(np.random.default_rng(1), SETTINGS, WINDOW_N, 10)
    time_s = np.arange(presses.force_n.size) / SETTINGS.fs_hz
    for onset_s, stop_s in zip(presses.onset_s, presses.stop_s, strict=True):
        assert np.interp(onset_s, time_s, presses.force_n) == pytest.approx(0.5, abs=1e-9)
        assert np.interp(stop_s, time_s, presses.force_n) == pytest.approx(7.0, abs=1e-9)
        between = presses.force_n[(time_s > onset_s) & (time_s < stop_s)]
        assert between.min() > 0.5
        assert between.max() < 7.0


def test_loading_lasts_as_asked() -> None:
    presses = make_presses(np.random.default_rng(2), SETTINGS, WINDOW_N, 200)
    duration_s = presses.stop_s - presses.onset_s
    # tremor moves a crossing by some 10 ms
    assert 1.95 < duration_s.min() < 2.1
    assert 2.9 < duration_s.max() < 3.05
    assert np.mean(duration_s) == pytest.approx(2.5, abs=0.1)


def test_record_rests_first_and_last_and_ends_on_a_whole_second() -> None:
    presses = make_presses(np.random.default_rng(3), SETTINGS, WINDOW_N, 10)
    assert np.all(presses.force_n[: int(INITIAL_REST_S * 1000)] == 0)
    assert np.all(presses.force_n[-1500:] == 0)
    assert presses.force_n.size % 1000 == 0
    assert np.min(presses.force_n) == 0


def test_cues_stand_before_the_force_they_cause() -> None:
    presses = make_presses(np.random.default_rng(4), SETTINGS, WINDOW_N, 10)
    assert np.all(presses.cue_start_s < presses.onset_s)
    assert np.all(presses.cue_stop_s > presses.stop_s - 0.4)
    at_cue = presses.force_n[np.round(presses.cue_start_s * 1000).astype(int)]
    assert np.all(at_cue == 0)


def test_some_presses_fall_a_little_and_the_truth_says_how_much() -> None:
    presses = make_presses(np.random.default_rng(5), SETTINGS, WINDOW_N, 300)
    assert 0.01 < np.mean(presses.largest_fall_n > 0.05) < 0.08
    assert np.max(presses.largest_fall_n) < 0.6
    onset, stop = np.round(presses.onset_s * 1000).astype(int), np.round(presses.stop_s * 1000).astype(int)
    worst = int(np.argmax(presses.largest_fall_n))
    loading = presses.force_n[onset[worst] : stop[worst]]
    fall_n = np.max(np.maximum.accumulate(loading) - loading)
    assert fall_n == pytest.approx(presses.largest_fall_n[worst], abs=1e-9)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    window_n=st.sampled_from([(0.5, 7.0), (0.2, 1.0), (1.0, 40.0), (3.0, 5.0)]),
    fs_hz=st.sampled_from([200.0, 1000.0, 1925.926]),
)
def test_any_window_and_rate_gives_whole_presses(seed: int, window_n: tuple[float, float], fs_hz: float) -> None:
    asked = SimulationSettings(repetitions=3, fs_hz=fs_hz)
    presses = make_presses(np.random.default_rng(seed), asked, window_n, 3)
    assert np.all(presses.peak_force_n > window_n[1])
    assert np.all(presses.onset_s < presses.stop_s)
    assert np.all(presses.onset_s[1:] > presses.stop_s[:-1])
    assert np.all(presses.force_n >= 0)
    assert presses.force_n.size / fs_hz <= longest_record_s(asked, window_n)


@given(x=st.floats(0, 1), taper=st.floats(0.01, 1))
def test_smooth_step_is_symmetric_about_its_middle(x: float, taper: float) -> None:
    low, high = smooth_step(np.array([x, 1 - x]), taper)
    assert low + high == pytest.approx(1.0, abs=1e-12)
    assert smooth_step(np.array([0.0, 1.0]), taper) == pytest.approx([0.0, 1.0], abs=1e-15)


def test_smooth_step_never_falls_and_starts_slowly() -> None:
    x = np.linspace(0, 1, 10_001)
    for taper in (0.1, 0.5, 1.0):
        speed = np.diff(smooth_step(x, taper)) / np.diff(x)
        assert speed.min() >= 0
        assert speed[0] < 1e-3
        assert speed.max() == pytest.approx(1 / (1 - taper / 2), rel=1e-3)
