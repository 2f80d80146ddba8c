"""How many independent observations a correlated series is worth."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, exponent_of


def residual_memory(residuals: Floats) -> tuple[Floats, Floats]:
    """Lag-1 autocorrelation and effective number of observations, both (k,), of rows (k, p) padded with NaN at the end.

    n_effective = n / (1 + 2 sum (1 - j / n) r_j), summed up to the first lag whose r_j is not positive, and kept
    within 1 and n. NaN for rows that are constant or have fewer than three values.
    """
    k, p = residuals.shape
    valid = np.isfinite(residuals)
    n = np.count_nonzero(valid, axis=1)
    if k == 0 or p < 3:
        return np.full(k, np.nan), np.full(k, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        filled = np.where(valid, residuals, 0.0)
        scaled = np.ldexp(filled, -exponent_of(filled))
        mean = np.sum(scaled, axis=1) / n
        centred = np.where(valid, scaled - mean[:, None], 0.0)
        spectrum = np.fft.rfft(centred, 2 * p, axis=1)
        covariance = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, 2 * p, axis=1)[:, :p]
        r = covariance / covariance[:, :1]
        positive = np.logical_and.accumulate(r[:, 1:] > 0, axis=1)
        share = 1 - np.arange(1, p) / n[:, None]
        n_effective = n / (1 + 2 * np.sum(share * r[:, 1:], axis=1, where=positive))
    undefined = (n < 3) | ~np.any(centred != 0, axis=1)
    lag1 = np.where(undefined, np.nan, r[:, 1])
    return lag1, np.where(undefined, np.nan, np.clip(n_effective, 1, np.maximum(n, 1)))
