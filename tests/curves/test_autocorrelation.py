"""Effective number of observations of correlated residuals."""

from __future__ import annotations

import numpy as np
from scipy import signal

from emg2vsa.curves.press_fits import autocorrelation, effective_number, memory


def residual_memory(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    correlation = autocorrelation(rows)
    lag1 = correlation[:, 1] if rows.shape[1] > 1 else np.full(len(rows), np.nan)
    return lag1, effective_number(correlation, np.isfinite(rows).sum(axis=1).astype(np.float64))


def test_white_noise_is_worth_its_length() -> None:
    lag1, n_effective = residual_memory(np.random.default_rng(0).standard_normal((300, 200)))
    assert abs(np.mean(lag1)) < 0.02
    assert 160 < np.median(n_effective) <= 200


def test_first_order_process() -> None:
    noise = np.random.default_rng(1).standard_normal((200, 4500))
    lag1, n_effective = residual_memory(signal.lfilter([1], [1, -0.8], noise, axis=1)[:, 500:])
    assert abs(np.mean(lag1) - 0.8) < 0.01
    np.testing.assert_allclose(np.mean(n_effective), 4000 * 0.2 / 1.8, rtol=0.1)


def test_padding_and_scale_do_not_matter() -> None:
    rows = np.cumsum(np.random.default_rng(2).standard_normal((3, 50)), axis=1)
    padded = np.pad(rows, ((0, 0), (0, 37)), constant_values=np.nan)
    for other in (padded, padded * 1e300, rows * 1e300, rows * 1e-300, rows + 100):
        np.testing.assert_allclose(residual_memory(other), residual_memory(rows), rtol=1e-9)


def test_alternating_rows_are_worth_no_more_than_their_length() -> None:
    lag1, n_effective = residual_memory(np.tile([1.0, -1.0], (1, 20)))
    assert lag1[0] < -0.9
    assert n_effective[0] == 40


def test_undefined() -> None:
    for rows in (np.zeros((2, 9)), np.full((2, 9), np.nan), np.ones((2, 2)), np.empty((2, 0)), np.empty((0, 9))):
        lag1, n_effective = residual_memory(rows)
        assert lag1.shape == n_effective.shape == (len(rows),)
        assert np.isnan(lag1).all()
        assert np.isnan(n_effective).all()


def test_memory_ends_with_the_first_lag_that_is_not_positive() -> None:
    kept = memory(np.array([[1.0, 0.5, -0.1, 0.3], [np.nan] * 4, [1.0, 0.0, 0.2, 0.1]]))
    np.testing.assert_array_equal(kept, [[1, 0.5, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]])
