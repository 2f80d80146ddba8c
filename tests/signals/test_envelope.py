"""Envelopes inside windows are those of the whole record.

The RMS envelope against theory and against numbers that MATLAB documents; nothing here reads the code's own taps.

Indices of co-contraction against their definitions.
"""

from __future__ import annotations

import math
import re

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from emg2vsa.errors import SettingError
from emg2vsa.settings import CocontractionSettings, FilterSettings
from emg2vsa.signals.cocontraction import cocontraction_index
from emg2vsa.signals.envelope import decimation, envelopes_at, smoother
from emg2vsa.signals.filters import IirFilter, band_pass

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


NO_FILTER = IirFilter("none", np.array([[1.0, 0, 0, 1, 0, 0]]), True, False, 0.0, 0, 0, ())
"""So that the envelope alone is seen."""

SAMPLES = pytest.mark.parametrize(
    ("fs_hz", "window_s", "n"),
    [(1000.0, 0.1, 101), (1000.0, 0.05, 51), (1000.0, 0.051, 51), (2048.0, 0.1, 205), (1925.926, 0.125, 241)],
)
"""A window has the odd number of samples at or next above fs_hz * window_s: so its middle is a sample."""


def rms(samples: np.ndarray, at: np.ndarray, *, window_s: float, fs_hz: float = 1000.0, phase: str = "zero-phase"):
    """Envelope of ``samples`` at the sample numbers ``at``."""
    kernel = smoother(FilterSettings(envelope="rms", rms_window_s=window_s, phase=phase), fs_hz, 1)
    return envelopes_at((samples,), at, np.ones(at.size, np.int64), 1, NO_FILTER, kernel)[0]


@SAMPLES
@pytest.mark.parametrize("phase", ["zero-phase", "compensated", "causal"])
def test_one_impulse_is_spread_over_the_window_and_keeps_its_power(fs_hz, window_s, n, phase):
    samples = np.zeros(2001)
    samples[1000] = 7.0
    found = rms(samples, np.arange(2001), window_s=window_s, fs_hz=fs_hz, phase=phase)
    first = 1000 if phase == "causal" else 1000 - n // 2
    expected = np.zeros(2001)
    expected[first : first + n] = 7 / math.sqrt(n)
    if phase == "compensated":  # causal filtering, whose known delay is taken from the time axis instead
        expected = np.roll(expected, 1000 - first)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert np.count_nonzero(found) == n


@SAMPLES
def test_the_edge_that_is_printed_is_that_of_a_rectangular_window(fs_hz, window_s, n):
    """Response of n equal taps: sin(pi f n / fs) / (n sin(pi f / fs)) (Dirichlet's kernel)."""

    def response(f):
        return mpmath.sin(mpmath.pi * f * n / fs_hz) / (n * mpmath.sin(mpmath.pi * f / fs_hz))

    with mpmath.workdps(30):
        edge_hz = mpmath.findroot(lambda f: response(f) - mpmath.sqrt(0.5), (0.4 * fs_hz / n, 0.5 * fs_hz / n))
    note = smoother(FilterSettings(envelope="rms", rms_window_s=window_s), fs_hz, 1).notes[0]
    assert f"moving window, {n} taps" in note
    printed = re.search(r"true -3 dB at ([\d.]+) Hz", note)
    assert float(printed[1]) == pytest.approx(float(edge_hz), rel=3e-4)


@pytest.mark.parametrize("phase", ["compensated", "causal"])
def test_the_delay_is_half_the_window(phase):
    kernel = smoother(FilterSettings(envelope="rms", rms_window_s=0.1, phase=phase), 1000.0, 1)
    assert kernel.delay_s == pytest.approx(0.050)


@pytest.mark.parametrize("frequency_hz", [0.7, 50.0, 123.4, 499.0])
def test_a_sinusoid_has_the_rms_of_its_window(frequency_hz):
    """Mean of sin^2(w k + p) over n samples about k: (1 - cos(2 w k + 2 p) sin(n w) / (n sin w)) / 2."""
    k, w, p, n = np.arange(3000), 2 * np.pi * frequency_hz / 1000, 0.3, 101
    inner = np.arange(n, 3000 - n)
    mean_square = (1 - np.cos(2 * w * inner + 2 * p) * np.sin(n * w) / (n * np.sin(w))) / 2
    found = rms(4 * np.sin(w * k + p), inner, window_s=0.1)
    np.testing.assert_allclose(found, 4 * np.sqrt(mean_square), rtol=1e-11)


def test_whole_periods_have_the_amplitude_over_root_two():
    k = np.arange(4000)
    found = rms(3 * np.sin(2 * np.pi * 5 / 101 * k), np.arange(200, 3800), window_s=0.1)
    np.testing.assert_allclose(found, 3 / math.sqrt(2), rtol=1e-12)


@pytest.mark.parametrize(("window_s", "n"), [(0.005, 5), (0.1, 101)])
def test_white_noise_has_the_mean_and_variance_of_chi(window_s, n):
    """sqrt(n) RMS / sigma of n independent normal samples follows the chi distribution with n degrees of freedom."""
    windows, sigma = 8000, 2.5
    noise = sigma * np.random.default_rng(11).standard_normal(windows * n)
    found = rms(noise, n // 2 + n * np.arange(windows), window_s=window_s)
    mean = sigma * math.sqrt(2 / n) * math.exp(math.lgamma((n + 1) / 2) - math.lgamma(n / 2))
    variance = sigma**2 - mean**2
    assert np.mean(found) == pytest.approx(mean, abs=4 * math.sqrt(variance / windows))
    assert np.var(found) == pytest.approx(variance, rel=4 * math.sqrt(2 / windows))
    assert np.mean(found**2) == pytest.approx(sigma**2, rel=4 * math.sqrt(2 / (windows * n)))


def test_matlabs_documented_moving_mean_of_three():
    """``movmean(A, 3)`` of MATLAB's documentation, whose windows shrink at the ends; squares are A + 3."""
    a = np.array([4.0, 8, 6, -1, -2, -3, -1, 3, 4, 5])
    documented = np.array([6.0, 6, 13 / 3, 1, -2, -2, -1 / 3, 2, 4, 4.5])
    found = rms(np.sqrt(a + 3), np.arange(10), window_s=0.003)
    np.testing.assert_allclose(found**2, documented + 3, rtol=1e-12)


MUSCLES = ("EDC", "FDS")
LEVELS = np.array([[1.0, 4.0, 0.0, 0.0], [3.0, 2.0, 5.0, 0.0]])


@pytest.mark.parametrize(
    ("index", "expected", "unit"),
    [
        ("sum", [4, 6, 5, 0], "V"),
        ("minimum", [1, 2, 0, 0], "V"),
        ("rudolph", [4 / 3, 3, 0, 0], "V"),
        ("falconer-winter", [0.5, 2 / 3, 0, 0], "1"),
    ],
)
def test_definitions(index, expected, unit):
    activity, found_unit, _ = cocontraction_index(LEVELS, MUSCLES, CocontractionSettings(index=index))
    assert activity == pytest.approx(expected)
    assert found_unit == unit


@pytest.mark.parametrize("index", ["sum", "minimum", "rudolph", "falconer-winter"])
def test_order_of_muscles_does_not_matter(index):
    settings = CocontractionSettings(index=index)
    one, other = (cocontraction_index(levels, MUSCLES, settings)[0] for levels in (LEVELS, LEVELS[::-1]))
    assert np.array_equal(one, other)


def test_normalised_to_mvc_or_to_the_session():
    mvc = CocontractionSettings(normalise="mvc", mvc_v={"EDC": 2.0, "FDS": 10.0})
    activity, unit, notes = cocontraction_index(LEVELS, MUSCLES, mvc)
    assert activity == pytest.approx([0.8, 2.2, 0.5, 0.0])
    assert unit == "1"
    assert "MVC" in notes[0]
    session = CocontractionSettings(normalise="session-max")
    activity, unit, notes = cocontraction_index(LEVELS, MUSCLES, session, {"EDC": 4.0, "FDS": 20.0})
    assert activity == pytest.approx([0.4, 1.1, 0.25, 0.0])
    assert unit == "1"
    assert "session" in notes[0]
    activity, unit, _ = cocontraction_index(LEVELS, MUSCLES, session)
    assert unit == "V"
    assert np.array_equal(activity, LEVELS.sum(axis=0))


def test_what_cannot_be_is_refused():
    with pytest.raises(SettingError, match="FDS"):
        cocontraction_index(LEVELS, MUSCLES, CocontractionSettings(normalise="mvc", mvc_v={"EDC": 1.0}))
    for index in ("rudolph", "falconer-winter", "minimum"):
        with pytest.raises(SettingError, match=index):
            cocontraction_index(LEVELS[:1], MUSCLES[:1], CocontractionSettings(index=index))


def test_one_muscle_sums_to_itself():
    assert np.array_equal(cocontraction_index(LEVELS[:1], MUSCLES[:1], CocontractionSettings())[0], LEVELS[0])
