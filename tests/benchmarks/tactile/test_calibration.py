"""Exponential calibration."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.tactile.calibration import calibrated, unknown_error_percent

KAPPA = np.array([7.63, 5.32, 3.35, 1.11])


@given(p=st.floats(2, 20), q=st.floats(-60, -0.5), scale=st.floats(1e-3, 1e3))
def test_recovers_the_curve_it_was_made_from(p: float, q: float, scale: float) -> None:
    casr = np.log(KAPPA / p) / q
    fit = calibrated(scale * casr, KAPPA)
    assert np.exp(fit.log_p) == pytest.approx(p, rel=1e-8)
    assert scale * fit.q == pytest.approx(q, rel=1e-8)


def test_minimises_the_squares_in_kappa_not_in_its_logarithm() -> None:
    rng = np.random.default_rng(1)
    casr = np.repeat([0.2, 0.5, 1.6], 10)
    kappa = 8 * np.exp(-1.3 * casr) + 0.2 * rng.standard_normal(30)
    fit = calibrated(casr, kappa)
    gradient = [np.sum((kappa - fit.kappa_n_mm(casr)) * fit.kappa_n_mm(casr) * casr**k) for k in (0, 1)]
    assert np.abs(gradient).max() < 1e-5
    line = np.polyfit(casr, np.log(kappa), 1)
    assert abs(line[0] - fit.q) > 1e-3


def test_scores_that_do_not_differ_calibrate_nothing() -> None:
    assert np.isnan(calibrated(np.ones(4), KAPPA).q)


def test_error_on_a_hidden_specimen() -> None:
    casr = np.repeat(np.log(KAPPA / 10) / -1.5, 3).reshape(4, 3)
    assert unknown_error_percent(casr, KAPPA, 5.32) == pytest.approx(0, abs=1e-8)
    casr[1] += np.log(1.1) / -1.5
    assert unknown_error_percent(casr, KAPPA, 5.32) == pytest.approx(10, rel=1e-6)
