"""How long residuals remember, and how many independent observations they are worth."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats, exponent_of


def autocorrelation(residuals: Floats) -> Floats:
    """Autocorrelation (k, p) at lags 0 to p - 1 of rows (k, p), padded with NaN at the end.

    Biased estimate (sums over all n values), so that no lag is wild. NaN for rows that are constant or have fewer than
    three values.
    """
    k, p = residuals.shape
    if k == 0 or p < 3:
        return np.full((k, p), np.nan)
    valid = np.isfinite(residuals)
    n = np.count_nonzero(valid, axis=1)
    filled = np.where(valid, residuals, 0.0)
    scaled = np.ldexp(filled, -exponent_of(filled))
    mean = np.sum(scaled, axis=1) / np.maximum(n, 1)
    centred = np.where(valid, scaled - mean[:, None], 0.0)
    size = 1 << (2 * p - 1).bit_length()  # room for all lags; powers of two are the fastest
    spectrum = np.fft.rfft(centred, size, axis=1)
    covariance = np.fft.irfft(spectrum.real**2 + spectrum.imag**2, size, axis=1)[:, :p]
    undefined = (n < 3) | ~np.any(centred != 0, axis=1)
    return np.asarray(covariance / np.where(undefined, np.nan, covariance[:, 0])[:, None])


def memory(correlation: Floats) -> Floats:
    """The part of an autocorrelation (k, p) before the first lag that is not positive; 0 from there on.

    What follows is mostly noise (Geyer 1992). Rows of NaN: no memory, 1 at lag 0.
    """
    lasting = np.logical_and.accumulate(correlation > 0, axis=1)
    kept = np.where(lasting, correlation, 0.0)
    kept[:, :1] = 1.0
    return kept


def effective_number(correlation: Floats, n: Floats) -> Floats:
    """Independent observations (k,) that n (k,) values of this autocorrelation (k, p) are worth, 1 to n.

    n / (1 + 2 sum (1 - j / n) r_j) over the ``memory``; NaN where the autocorrelation is.
    """
    if correlation.shape[1] < 2:
        return np.full(len(correlation), np.nan)
    lags = np.arange(1, correlation.shape[1])
    length = np.maximum(n, 1)[:, None]
    worth = 1 + 2 * np.sum((1 - lags / length) * memory(correlation)[:, 1:], axis=1)
    return np.where(np.isnan(correlation[:, 1]), np.nan, np.clip(n / worth, 1, length[:, 0]))
