"""Carrier, noise and drift of sensors; and how active the muscles are at a force."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from emg2vsa.errors import SettingError
from emg2vsa.worlds.people.person import check_coefficients, cocontraction_v, logarithm_end
from emg2vsa.worlds.people.signals import (
    Electrode,
    Faults,
    ForceSensor,
    around,
    below,
    emg_carrier,
    gaussian_noise,
    muscle_spectrum,
)

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


@pytest.mark.parametrize("n", [1, 63, 1000, 1001, 20_000])
@pytest.mark.parametrize("spectrum", [below(1.0), around(9.0, 1.5), muscle_spectrum])
def test_noise_has_unit_variance_over_its_draws(n: int, spectrum: object) -> None:
    rng = np.random.default_rng(4)
    draws = np.array([gaussian_noise(rng, n, FS_HZ, spectrum)[n // 2] for _ in range(400)])  # type: ignore[arg-type]
    assert np.mean(draws**2) == pytest.approx(1.0, abs=4 * np.sqrt(2 / 400))


def test_ends_of_a_drift_do_not_meet() -> None:
    rng = np.random.default_rng(5)
    ends = np.array([gaussian_noise(rng, 1000, FS_HZ, below(5.0))[[0, -1]] for _ in range(200)])
    assert np.std(ends[:, 0] - ends[:, 1]) > 0.5


def test_a_stream_goes_on_from_page_to_page() -> None:
    """The same for any blocks; its second page is as its first but for the draws."""

    def taken(sizes: list[int]) -> tuple[np.ndarray, np.ndarray]:
        electrode = Electrode(np.random.default_rng(6), FS_HZ, Faults(1e-6, 2e-6, 50.0), page=4000)
        sensor = ForceSensor(np.random.default_rng(7), FS_HZ, noise_n=0.02, offset_n=0.3, page=4000)
        emg = np.concatenate([electrode.take(np.full(size, 30e-6))[0] for size in sizes])
        return emg, np.concatenate([sensor.take(np.ones(size)) for size in sizes])

    (emg_v, force_n), (again_v, again_n) = taken([12_000]), taken([1, 3999, 4001, 3999])
    np.testing.assert_array_equal(emg_v, again_v)
    np.testing.assert_array_equal(force_n, again_n)
    for page in emg_v.reshape(3, 4000):
        assert np.mean(np.abs(page)) == pytest.approx(30e-6, rel=0.08)
    assert not np.array_equal(emg_v[:4000], emg_v[4000:8000])
    assert np.mean(force_n) == pytest.approx(1.3, abs=0.01)
    tone = np.exp(-2j * np.pi * 50.0 * np.arange(12_000) / FS_HZ)
    quiet = Electrode(np.random.default_rng(6), FS_HZ, Faults(0.0, 2e-6, 50.0), page=4000)
    hum_v = quiet.take(np.zeros(12_000))[0]
    assert np.sqrt(2) * abs(np.mean(hum_v * tone)) == pytest.approx(2e-6, rel=0.02)


A_V, B_V = 30e-6, 15e-6


def test_equation_6_holds_above_the_joint() -> None:
    force_n = np.linspace(0.3, 9, 500)
    v = cocontraction_v(force_n, A_V, B_V, 0.5)
    np.testing.assert_allclose(v, A_V + B_V * np.log(force_n), rtol=1e-14)


def test_rest_tone_at_zero_force() -> None:
    _, join_v = logarithm_end(A_V, B_V, 0.5)
    assert cocontraction_v(np.zeros(1), A_V, B_V, 0.5)[0] == pytest.approx(0.2 * join_v)


@given(a_v=st.floats(20e-6, 100e-6), b_v=st.floats(1e-6, 14e-6), lower_n=st.floats(0.4, 2.0))
def test_joint_has_no_step_and_no_corner(a_v: float, b_v: float, lower_n: float) -> None:
    join_n, join_v = logarithm_end(a_v, b_v, lower_n)
    step_n = 1e-6 * join_n
    below, at, above = cocontraction_v(join_n + np.array([-step_n, 0, step_n]), a_v, b_v, lower_n)
    assert at == pytest.approx(join_v, rel=1e-12)
    assert (at - below) / step_n == pytest.approx((above - at) / step_n, rel=1e-3)


def test_activity_rises_from_rest_to_peak() -> None:
    v = cocontraction_v(np.linspace(0, 9, 2000), A_V, B_V, 0.5)
    assert np.all(np.diff(v) > 0)


@pytest.mark.parametrize(("a_v", "b_v"), [(30e-6, 0.0), (30e-6, -1e-6), (10e-6, 15e-6)])
def test_impossible_coefficients_are_refused(a_v: float, b_v: float) -> None:
    with pytest.raises(SettingError, match="specimen S1"):
        check_coefficients("specimen S1", a_v, b_v, 0.5)


def test_another_rest_tone_joins_without_a_step_and_levels_may_differ_by_sample() -> None:
    join_n, _ = logarithm_end(A_V, B_V, 0.5)
    force_n = np.array([0.0, join_n * (1 - 1e-9), join_n, 3.0])
    level_v = cocontraction_v(force_n, A_V * np.ones(4), B_V * np.array([1.0, 1.0, 1.0, 2.0]), 0.5, rest_v=1e-6)
    assert level_v == pytest.approx([1e-6, *[A_V + B_V * np.log(join_n)] * 2, A_V + 2 * B_V * np.log(3)], rel=1e-6)
