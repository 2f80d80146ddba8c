"""Envelopes inside windows are those of the whole record."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from emg2vsa.errors import SettingError
from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import decimation, envelopes_at, smoother
from emg2vsa.signals.filters import band_pass

FS_HZ = 1000.0


def record(n: int = 30_000, seed: int = 0):
    """Bursts of very different size on a large, drifting offset."""
    rng = np.random.default_rng(seed)
    t = np.arange(n)
    return rng.standard_normal(n) * (1 + 50 * (t // 3000 % 2)) + 300 * np.sin(t / 2000) + 1000


TAPS = {"fir": signal.firwin(51, 20.0, window="hamming", fs=FS_HZ), "rms": np.full(101, 1 / 101)}
"""Of the default settings at ``FS_HZ``; test_rms_envelope.py holds the second against theory."""


def reference(samples, filters: FilterSettings):
    """Envelope of the whole record by scipy, at every sample; the taps inside it rescaled to unit sum."""
    band, taps = band_pass(filters, FS_HZ), TAPS[filters.envelope]
    if filters.phase == "zero-phase":
        filtered = signal.sosfiltfilt(band.sos, samples)
    else:
        filtered, _ = signal.sosfilt(band.sos, samples, zi=signal.sosfilt_zi(band.sos) * samples[0])
    rectified = filtered**2 if filters.envelope == "rms" else np.abs(filtered)
    if filters.phase == "zero-phase":
        smooth = np.convolve(rectified, taps, "same") / np.convolve(np.ones(len(samples)), taps, "same")
    else:
        reached = np.cumsum(np.r_[taps, np.zeros(len(samples))])[: len(samples)]
        smooth = np.convolve(rectified, taps)[: len(samples)] / np.maximum(reached, 0.5)
    return np.sqrt(smooth) if filters.envelope == "rms" else smooth


PHASES = ("zero-phase", "compensated", "causal")


def relative_error(channels, first, counts, step, filters):
    got = envelopes_at(channels, first, counts, step, band_pass(filters, FS_HZ), smoother(filters, FS_HZ, step))
    index = np.concatenate([f + step * np.arange(c) for f, c in zip(first, counts, strict=True)])
    expected = np.stack([reference(channel, filters)[index] for channel in channels])
    assert got.shape == expected.shape
    # a causal pass is exactly zero at the first sample, where the reference shows its own rounding
    return np.max(np.abs(got - expected)) / max(np.max(expected), 1e-6 * np.max(np.abs(channels)))


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("kind", ["fir", "rms"])
@pytest.mark.parametrize("band_hz", [(10.0, 450.0), (10.0, 500.0), (20.0, 400.0)])
def test_windows_equal_the_whole_record(phase, kind, band_hz):
    filters = FilterSettings(phase=phase, envelope=kind, band_hz=band_hz)
    first, counts = np.array([3000, 9500, 20_010]), np.array([120, 250, 7])
    channels = (record(), record(seed=1))
    assert relative_error(channels, first, counts, 10, filters) < 1e-10


@pytest.mark.parametrize("phase", PHASES)
def test_the_ends_of_the_record_are_those_of_sosfiltfilt(phase):
    first, counts = np.array([0, 29_500]), np.array([40, 50])
    assert relative_error((record(),), first, counts, 10, FilterSettings(phase=phase)) < 1e-10


@pytest.mark.parametrize("order", [1, 4, 8])
def test_any_order(order):
    filters = FilterSettings(band_order=order)
    assert relative_error((record(),), np.array([12_000]), np.array([100]), 10, filters) < 1e-9


@given(
    phase=st.sampled_from(PHASES),
    step=st.integers(1, 37),
    n=st.integers(60, 6000),
    windows=st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=5),
)
@settings(max_examples=40, deadline=None)
def test_any_windows_of_any_record(phase, step, n, windows):
    highest = (n - 1) // step
    bounds = [sorted((round(a * highest), round(b * highest))) for a, b in windows]
    first = np.array([step * low for low, _ in bounds])
    counts = np.array([high - low + 1 for low, high in bounds])
    assert relative_error((record(n),), first, counts, step, FilterSettings(phase=phase)) < 1e-9


def test_windows_without_samples_give_nothing():
    filters = FilterSettings()
    band, kernel = band_pass(filters, FS_HZ), smoother(filters, FS_HZ, 10)
    none = np.empty(0, np.int64)
    assert envelopes_at((record(),), none, none, 10, band, kernel).shape == (1, 0)
    some = envelopes_at((record(),), np.array([5000, 0]), np.array([3, 0]), 10, band, kernel)
    assert some.shape == (1, 3)


def test_the_true_edge_of_51_taps_at_20_hz_is_16_4_hz():
    kernel = smoother(FilterSettings(), FS_HZ, 10)
    assert "true -3 dB at 16.4" in kernel.notes[0]
    assert np.array_equal(kernel.taps, signal.firwin(51, 20.0, window="hamming", fs=FS_HZ))
    assert kernel.delay_s == 0
    assert smoother(FilterSettings(phase="causal"), FS_HZ, 10).delay_s == 0.025


def test_an_odd_order_or_an_impossible_cutoff_is_refused():
    with pytest.raises(SettingError, match="even"):
        smoother(FilterSettings(fir_order=51), FS_HZ, 10)
    with pytest.raises(SettingError, match="fir_cutoff_hz"):
        smoother(FilterSettings(fir_cutoff_hz=500.0), FS_HZ, 10)


def test_a_kernel_that_lets_aliases_through_is_named():
    assert any("aliasing" in note for note in smoother(FilterSettings(), 2048.0, 20).notes)
    assert not any("aliasing" in note for note in smoother(FilterSettings(), FS_HZ, 10).notes)


@pytest.mark.parametrize(
    ("fs_hz", "asked", "step"), [(1000.0, 100.0, 10), (1925.926, 100.0, 19), (1000.0, "native", 1), (50.0, 100.0, 1)]
)
def test_decimation_is_the_nearest_whole_divisor(fs_hz, asked, step):
    assert decimation(fs_hz, asked) == step
