"""Force that is no force, that returns to zero by itself, or that was sampled slowly; and force that is sound."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from benchmarks.laboratory import simulate_session
from benchmarks.verdict_thresholds import drawn
from emg2vsa.signals.force_doubts import exchanged, returns_to_zero, sampled_slowly

FS_HZ = 1000.0


def presses(fs_hz=FS_HZ, noise_n=0.01, seed=0, count=8):
    """Newtons: ramps of 2 to 3 s to about 8 N, a quick release, and lulls of 3 s."""
    rng = np.random.default_rng(seed)
    pieces = [np.zeros(round(2 * fs_hz))]
    for _ in range(count):
        up = 8 * np.sin(np.linspace(0, np.pi / 2, round(rng.uniform(2, 3) * fs_hz))) ** 1.5
        pieces += [up, np.linspace(up[-1], 0, round(0.4 * fs_hz)), np.zeros(round(3 * fs_hz))]
    force_n = np.concatenate(pieces)
    return force_n + noise_n * rng.standard_normal(force_n.size)


def high_passed(force_n, hz, order=1):
    return signal.sosfilt(signal.butter(order, hz, "highpass", fs=FS_HZ, output="sos"), force_n)


@pytest.mark.parametrize("noise_n", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("step_n", [0.0, 0.005, 0.05])
@pytest.mark.parametrize("fs_hz", [50.0, 243.0, 1000.0, 2148.0])
def test_sound_force_is_no_doubt(fs_hz, step_n, noise_n):
    force_n = presses(fs_hz, noise_n) + 0.4
    if step_n:
        force_n = np.round(force_n / step_n) * step_n
    emg_v = 3e-5 * np.random.default_rng(1).standard_normal(5000)
    assert returns_to_zero(force_n, fs_hz) == ""
    assert list(sampled_slowly(force_n, fs_hz)) == []
    assert exchanged(force_n, fs_hz, ("EDC",), (emg_v,), FS_HZ) == ""


@pytest.mark.parametrize("change", [
    lambda f, t: f + 3 * t / 50, lambda f, t: f + 0.3 * np.sin(2 * np.pi * t / 20), lambda f, t: -f,
    lambda f, t: signal.sosfilt(signal.butter(2, 3, fs=FS_HZ, output="sos"), f), lambda f, t: np.maximum(f, 0.3),
    lambda f, t: f + 0.4 * (t > t[-1] / 2),
])  # fmt: skip
def test_force_that_drifts_wanders_or_is_filtered_does_not_return_to_zero_by_itself(change):
    force_n = presses()
    assert returns_to_zero(change(force_n, np.arange(force_n.size) / FS_HZ), FS_HZ) == ""


@pytest.mark.parametrize("hz", [0.05, 0.1, 0.3, 1.0])
def test_the_time_constant_of_a_high_pass(hz):
    said = returns_to_zero(high_passed(presses(), hz), FS_HZ)
    assert "is it AC-coupled?" in said
    found_s = float(said.split("within ")[1].split(" s")[0])
    assert found_s == pytest.approx(1 / (2 * np.pi * hz), rel=0.25)


@pytest.mark.parametrize("hz", [4.0, 5.0, 7.3, 12.0, 15.0])
@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("digits", [5, 12])
def test_the_rate_at_which_force_was_sampled(hz, held, digits):
    force_n = presses()
    time_s = np.arange(force_n.size) / FS_HZ
    at_s = np.arange(0, time_s[-1], 1 / hz)
    values = np.interp(at_s, time_s, force_n)
    index = np.minimum((time_s * hz + 1e-9).astype(int), values.size - 1)
    slow_n = values[index] if held else np.interp(time_s, at_s, values)
    (said,) = sampled_slowly(np.round(slow_n, digits), FS_HZ)
    assert said.endswith("and held or interpolated to 1000 Hz")
    assert float(said.split("about ")[1].split(" Hz")[0]) == pytest.approx(hz, rel=0.02)


def test_a_slow_file_of_force():
    assert list(sampled_slowly(presses(10.0), 10.0)) == ["force was sampled at about 10 Hz"]


def test_exchanged_channels():
    force_n = presses()
    emg_v = 3e-5 * np.random.default_rng(1).standard_normal(force_n.size)
    said = exchanged(1e3 * emg_v, FS_HZ, ("EDC", "FDS"), (emg_v, 1e-3 * force_n), FS_HZ)
    assert said == "force looks like EMG, and FDS like force; were the two channels exchanged?"
    assert exchanged(1e3 * emg_v, FS_HZ, ("EDC",), (emg_v,), FS_HZ) == ""
    assert exchanged(np.zeros(5000), FS_HZ, ("EDC",), (1e-3 * force_n,), FS_HZ) == ""


def test_too_short_to_tell():
    short = np.zeros(3)
    assert returns_to_zero(short, FS_HZ) == ""
    assert list(sampled_slowly(short, FS_HZ)) == []
    assert exchanged(short, FS_HZ, ("EDC",), (short,), FS_HZ) == ""


@pytest.mark.parametrize("seed", [231, 456])
def test_a_staircase_is_not_sampled_slowly(seed):
    """Its steps begin and end on a grid of 50 ms; force itself was sampled at 100 and 148 Hz."""
    staircase = drawn(seed)
    force_n = simulate_session(staircase, seed).force_n
    assert staircase.ramp == "stairs"
    assert list(sampled_slowly(force_n, staircase.force_fs_hz)) == []
