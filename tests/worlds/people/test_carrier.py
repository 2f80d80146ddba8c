from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from emg2vsa.worlds.people.carrier import around, below, emg_carrier, gaussian_noise, muscle_spectrum

FS_HZ, N = 1000.0, 400_000


def test_carrier_has_mean_rectified_value_of_one() -> None:
    carrier = emg_carrier(np.random.default_rng(1), N, FS_HZ)
    # |x| of a Gaussian has SD 0.756 of its mean; about a third of the samples count as independent
    assert np.mean(np.abs(carrier)) == pytest.approx(1.0, abs=4 * 0.756 / np.sqrt(N / 3))
    assert np.mean(carrier) == pytest.approx(0.0, abs=1e-3)


def test_carrier_is_gaussian() -> None:
    carrier = emg_carrier(np.random.default_rng(2), N, FS_HZ)
    kurtosis = np.mean(carrier**4) / np.mean(carrier**2) ** 2
    assert kurtosis == pytest.approx(3.0, abs=0.05)


@pytest.mark.parametrize("fs_hz", [1000.0, 1925.926, 2000.0])
def test_spectrum_of_the_carrier_is_the_muscle_spectrum(fs_hz: float) -> None:
    carrier = emg_carrier(np.random.default_rng(3), N, fs_hz)
    frequency_hz, density = signal.welch(carrier, fs_hz, nperseg=512, detrend=False)
    inside = (frequency_hz > 15) & (frequency_hz < 400)
    expected = muscle_spectrum(frequency_hz)
    ratio = density[inside] / expected[inside]
    assert np.std(ratio / np.mean(ratio)) < 0.06  # 1560 half-overlapping segments: 3 % and the window's leakage


def test_muscle_spectrum_peaks_and_dies_where_muscles_do() -> None:
    frequency_hz = np.arange(0.0, 1000.0)
    power = muscle_spectrum(frequency_hz)
    assert power[0] == 0.0
    assert 60 < frequency_hz[np.argmax(power)] < 90
    assert power[800] < 0.002 * power.max()
    cumulative = np.cumsum(power) / power.sum()
    assert 90 < frequency_hz[np.searchsorted(cumulative, 0.5)] < 130


@pytest.mark.parametrize("n", [1, 63, 1000, 1001, 74_000])
@pytest.mark.parametrize("spectrum", [below(1.0), around(9.0, 1.5), muscle_spectrum])
def test_noise_has_unit_variance_over_its_draws(n: int, spectrum: object) -> None:
    rng = np.random.default_rng(4)
    draws = np.array([gaussian_noise(rng, n, FS_HZ, spectrum)[n // 2] for _ in range(400)])  # type: ignore[arg-type]
    assert np.mean(draws**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / 400))


def test_ends_of_a_drift_do_not_meet() -> None:
    rng = np.random.default_rng(5)
    ends = np.array([gaussian_noise(rng, 1000, FS_HZ, below(5.0))[[0, -1]] for _ in range(200)])
    assert np.std(ends[:, 0] - ends[:, 1]) > 0.5
