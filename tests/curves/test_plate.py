"""Plate indentation: the moving average and the loading phase before Hooke's law."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.curves.plate import fit_plate
from emg2vsa.errors import SettingError


def press(kappa: float, noise_n: float, seed: int, hysteresis: float = 0.8) -> tuple[np.ndarray, np.ndarray]:
    """Plate down 0.5 mm above the specimen to 2 mm into it and up again; unloading is softer."""
    down = np.linspace(-0.5, 2.0, 250)
    load = kappa * np.maximum(down, 0)
    indentation, force = np.r_[down, down[::-1]], np.r_[load, hysteresis * load[::-1]]
    return indentation, force + noise_n * np.random.default_rng(seed).standard_normal(force.size)


@pytest.mark.parametrize("kappa", [7.63, 3.35, 1.11])
def test_stiffness_of_the_loading_phase_is_found(kappa):
    fit = fit_plate([press(kappa, 0.05, seed) for seed in range(10)])
    np.testing.assert_allclose(fit.kappa, kappa, rtol=0.02)
    np.testing.assert_allclose(fit.contact, 0, atol=0.05)
    assert np.all(fit.adj_r2 > 0.98)


def test_smoothing_lags_neither_axis_and_raises_r2():
    noisy = press(3.35, 0.4, 1)
    plain, smooth = fit_plate([noisy], window=1), fit_plate([noisy], window=5)
    assert smooth.adj_r2[0] > plain.adj_r2[0] + 0.01
    assert smooth.contact[0] == pytest.approx(0, abs=0.1)


def test_trials_of_different_length_and_with_gaps():
    long, short = press(5.32, 0.02, 3), tuple(values[::5].copy() for values in press(5.32, 0.02, 4))
    short[1][10:13] = np.nan
    np.testing.assert_allclose(fit_plate([long, short]).kappa, 5.32, rtol=0.02)


def test_a_trial_without_points_is_undefined_and_stops_no_other():
    fit = fit_plate([(np.empty(0), np.empty(0)), press(1.11, 0.01, 5)])
    assert np.isnan(fit.kappa[0])
    assert fit.kappa[1] == pytest.approx(1.11, rel=0.02)


def test_a_window_below_one_is_refused():
    with pytest.raises(SettingError, match="1 sample or more"):
        fit_plate([press(1, 0, 0)], window=0)
