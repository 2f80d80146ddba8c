"""The RMS envelope against theory and against numbers that MATLAB documents; nothing here reads the code's own taps."""

from __future__ import annotations

import math
import re

import mpmath
import numpy as np
import pytest

from emg2vsa.settings import FilterSettings
from emg2vsa.signals.envelope import envelopes_at, smoother
from emg2vsa.signals.filters import IirFilter

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
