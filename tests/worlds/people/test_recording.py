"""One recording: its signals against its truth, its presses against what was asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as how_often
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import signal

from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.recording import (
    INITIAL_REST_S,
    RecordingStream,
    SyntheticRecording,
    longest_record_s,
    make_presses,
    smooth_step,
)

SETTINGS = SimulationSettings(repetitions=3)
CLEAN = replace(SETTINGS, emg_noise_v=0.0, mains_v=0.0, force_noise_n=0.0, force_offset_n=0.0)
PRESSED = SimulationSettings(repetitions=10)
A_V, B_V, WINDOW_N = 30e-6, 15e-6, (0.5, 7.0)


def record(seed: int, settings: SimulationSettings = SETTINGS, force_delay_s: float = 0.0) -> SyntheticRecording:
    return RecordingStream(
        np.random.SeedSequence(seed), settings, a_v=A_V, b_v=B_V, window_n=WINDOW_N, force_delay_s=force_delay_s
    ).whole()


def rectified(emg_v: NDArray[np.float64]) -> NDArray[np.float64]:
    """Absolute EMG without its baseline drift."""
    drift_free = signal.butter(2, 10, "highpass", fs=1000, output="sos")
    return np.abs(signal.sosfiltfilt(drift_free, emg_v))


def test_rectified_mean_is_the_co_contraction_at_every_force() -> None:
    settings = replace(CLEAN, repetitions=60, repetition_sd=0.0)
    recording = record(1, settings)
    summed = np.sum([rectified(emg) for emg in recording.emg_v.values()], axis=0)
    force_n = recording.truth.presses.force_n
    edges = np.array([0.0, 1e-9, 0.5, 1.0, 2.0, 4.0, 7.0])
    in_bin = np.digitize(force_n, edges)
    for number in range(1, edges.size):
        chosen = in_bin == number
        ratio = summed[chosen] / recording.truth.cocontraction_v[chosen]
        # two muscles 40:60, |x| with SD 0.756 of its mean, about a third of the samples independent; the high-pass
        # before rectification takes some 0.2 % of the amplitude
        error = 0.756 * np.hypot(0.4, 0.6) / np.sqrt(chosen.sum() / 3)
        assert np.mean(ratio) == pytest.approx(1.0, abs=4 * error + 0.003)


def test_truth_is_equation_6_of_each_repetition() -> None:
    recording = record(2)
    truth = recording.truth
    time_s = np.arange(recording.force_n.size) / recording.fs_hz
    for a_v, b_v, onset_s, stop_s in zip(
        truth.a_v, truth.b_v, truth.presses.onset_s, truth.presses.stop_s, strict=True
    ):
        inside = (time_s > onset_s) & (time_s < stop_s)
        expected = a_v + b_v * np.log(truth.presses.force_n[inside])
        np.testing.assert_allclose(truth.cocontraction_v[inside], expected, rtol=1e-12)


def test_repetitions_spread_as_asked() -> None:
    truth = record(3, replace(SETTINGS, repetitions=150, repetition_sd=0.05)).truth
    assert np.std(truth.b_v) / B_V == pytest.approx(0.05, rel=0.25)
    assert np.mean(truth.b_v) / B_V == pytest.approx(1.0, abs=4 * 0.05 / 12)
    np.testing.assert_allclose(truth.a_v / truth.b_v, A_V / B_V)


def test_muscles_share_the_co_contraction() -> None:
    recording = record(4, replace(CLEAN, muscle_share={"EDC": 0.25, "FDS": 0.75}, repetitions=20))
    level = {muscle: np.mean(rectified(emg)) for muscle, emg in recording.emg_v.items()}
    assert level["EDC"] / level["FDS"] == pytest.approx(1 / 3, rel=0.05)
    correlation = np.corrcoef(recording.emg_v["EDC"], recording.emg_v["FDS"])[0, 1]
    assert abs(correlation) < 0.03


def test_force_sensor_has_offset_drift_and_noise() -> None:
    recording = record(5, replace(SETTINGS, force_offset_n=0.35, force_noise_n=0.02, repetitions=10))
    error_n = recording.force_n - recording.truth.presses.force_n
    assert abs(recording.truth.force_offset_n) <= 0.35
    assert np.mean(error_n) == pytest.approx(recording.truth.force_offset_n, abs=0.02)
    assert np.std(np.diff(error_n)) == pytest.approx(0.02 * np.sqrt(2), rel=0.02)
    offsets = np.array([record(seed, replace(SETTINGS, repetitions=1)).truth.force_offset_n for seed in range(40)])
    assert offsets.min() < -0.2
    assert offsets.max() > 0.2
    assert np.max(np.abs(offsets)) <= 0.35


def test_force_sensor_delay_shifts_force_alone() -> None:
    prompt, late = record(6, CLEAN), record(6, CLEAN, force_delay_s=0.05)
    np.testing.assert_array_equal(prompt.emg_v["EDC"], late.emg_v["EDC"])
    np.testing.assert_array_equal(prompt.truth.presses.force_n, late.truth.presses.force_n)
    drift = late.force_n - prompt.truth.presses.force_n
    drift[50:] = late.force_n[50:] - prompt.truth.presses.force_n[:-50]
    assert np.max(np.abs(np.diff(drift))) < 1e-3  # what is left is the slow drift of the sensor


def test_mains_hum_stands_at_its_frequency_and_level() -> None:
    recording = record(7, replace(SETTINGS, mains_v=5e-6, mains_hz=60.0))
    emg = recording.emg_v["FDS"]
    rest = emg[:3000]
    tone = np.exp(-2j * np.pi * 60.0 * np.arange(rest.size) / 1000)
    assert np.sqrt(2) * abs(np.mean(rest * tone)) == pytest.approx(5e-6, rel=0.1)


def test_a_further_muscle_leaves_the_others_as_they_are() -> None:
    two = record(8, replace(SETTINGS, muscle_share={"EDC": 0.4, "FDS": 0.6}))
    three = record(8, replace(SETTINGS, muscle_share={"EDC": 0.4, "FDS": 0.6, "FCR": 0.1}))
    np.testing.assert_array_equal(two.emg_v["FDS"], three.emg_v["FDS"])
    np.testing.assert_array_equal(two.force_n, three.force_n)


@pytest.mark.parametrize("size", [1, 777, 10_000])
def test_a_recording_is_its_collected_stream(size: int) -> None:
    settings = replace(SETTINGS, repetitions=1, fs_hz=200.0)
    given = {"a_v": A_V, "b_v": B_V, "window_n": WINDOW_N, "force_delay_s": 0.05}
    whole = RecordingStream(np.random.SeedSequence(11), settings, **given).whole()
    stream = RecordingStream(np.random.SeedSequence(11), settings, **given)
    blocks = [stream.take(size) for _ in range(-(-stream.samples // size) + 1)]
    np.testing.assert_array_equal(np.concatenate([force_n for _, force_n in blocks]), whole.force_n)
    for muscle, emg_v in whole.emg_v.items():
        np.testing.assert_array_equal(np.concatenate([emg[muscle] for emg, _ in blocks]), emg_v)


def test_crossings_are_where_the_force_says() -> None:
    presses = make_presses(np.random.default_rng(1), PRESSED, WINDOW_N, 10)
    time_s = np.arange(presses.force_n.size) / PRESSED.fs_hz
    for onset_s, stop_s in zip(presses.onset_s, presses.stop_s, strict=True):
        assert np.interp(onset_s, time_s, presses.force_n) == pytest.approx(0.5, abs=1e-9)
        assert np.interp(stop_s, time_s, presses.force_n) == pytest.approx(7.0, abs=1e-9)
        between = presses.force_n[(time_s > onset_s) & (time_s < stop_s)]
        assert between.min() > 0.5
        assert between.max() < 7.0


def test_loading_lasts_as_asked() -> None:
    presses = make_presses(np.random.default_rng(2), PRESSED, WINDOW_N, 200)
    duration_s = presses.stop_s - presses.onset_s
    # tremor moves a crossing by some 10 ms
    assert 1.95 < duration_s.min() < 2.1
    assert 2.9 < duration_s.max() < 3.05
    assert np.mean(duration_s) == pytest.approx(2.5, abs=0.1)


def test_cues_stand_before_the_force_they_cause() -> None:
    presses = make_presses(np.random.default_rng(4), PRESSED, WINDOW_N, 10)
    assert np.all(presses.cue_start_s < presses.onset_s)
    assert np.all(presses.cue_stop_s > presses.stop_s - 0.4)
    at_cue = presses.force_n[np.round(presses.cue_start_s * 1000).astype(int)]
    assert np.all(at_cue == 0)
    assert np.all(presses.force_n[: int(INITIAL_REST_S * 1000)] == 0)
    assert np.all(presses.force_n[-1500:] == 0)
    assert presses.force_n.size % 1000 == 0


def test_some_presses_fall_a_little_and_the_truth_says_how_much() -> None:
    presses = make_presses(np.random.default_rng(5), PRESSED, WINDOW_N, 300)
    assert 0.01 < np.mean(presses.largest_fall_n > 0.05) < 0.08
    assert np.max(presses.largest_fall_n) < 0.6
    onset, stop = np.round(presses.onset_s * 1000).astype(int), np.round(presses.stop_s * 1000).astype(int)
    worst = int(np.argmax(presses.largest_fall_n))
    loading = presses.force_n[onset[worst] : stop[worst]]
    fall_n = np.max(np.maximum.accumulate(loading) - loading)
    assert fall_n == pytest.approx(presses.largest_fall_n[worst], abs=1e-9)


@how_often(max_examples=25, deadline=None)
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


def test_smooth_step_never_falls_and_starts_slowly() -> None:
    x = np.linspace(0, 1, 10_001)
    for taper in (0.1, 0.5, 1.0):
        step = smooth_step(x, taper)
        assert step + step[::-1] == pytest.approx(1.0, abs=1e-12)
        assert (step[0], step[-1]) == pytest.approx((0.0, 1.0), abs=1e-15)
        speed = np.diff(step) / np.diff(x)
        assert speed.min() >= 0
        assert speed[0] < 1e-3
        assert speed.max() == pytest.approx(1 / (1 - taper / 2), rel=1e-3)
