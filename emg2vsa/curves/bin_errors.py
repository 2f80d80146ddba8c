"""Errors of a fit on bin means whose samples are correlated, within a bin and across its edges.

A smoothed envelope remembers tens of milliseconds; a bin of 0.3 N lasts about a hundred. The bins are then neither
independent nor of variance 1 / weight, and standard errors that think so are 5 to 20 % too small.
"""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import ForceBins


def bin_covariance(bins: ForceBins, noise: Floats, memory: Floats) -> Floats:
    """Covariance (k, B, B) of the bin means, up to a factor per trial.

    noise : (k, p) relative SD of each sample. memory : (k, p) autocorrelation of the samples' noise by lag, 0 beyond.
    """
    k, n_bins = bins.v.shape
    column = np.where(bins.column < 0, n_bins, bins.column)  # one more bin for what lies outside
    width = n_bins + 1
    row = (np.arange(k)[:, None] * width + column) * width
    samples = np.append(bins.samples, np.ones((k, 1), dtype=np.int64), axis=1)
    share = np.where(bins.column < 0, 0.0, noise / np.take_along_axis(samples, column, axis=1))
    half = np.zeros(k * width * width)
    for lag in range(np.flatnonzero(np.any(memory > 0, axis=0)).max(initial=-1) + 1):
        stop = column.shape[1] - lag
        product = share[:, lag:] * share[:, :stop]
        product *= memory[:, lag : lag + 1]
        cell = row[:, lag:] + column[:, :stop]
        half += np.bincount(cell.ravel(), product.ravel(), minlength=half.size) * (1.0 if lag else 0.5)
    one_side = half.reshape(k, width, width)[:, :n_bins, :n_bins]
    return one_side + one_side.transpose(0, 2, 1)


def error_factors(x: Floats, weights: Floats, covariance: Floats) -> tuple[Floats, Floats]:
    """By how much (k,), (k,) the standard errors of intercept and slope must grow, given the points' true covariance.

    x, weights : (k, B) of the weighted line; weight 0 leaves a point out. covariance : (k, B, B), up to a factor.
    The variance of the residuals is corrected for the covariance too. 1 where it cannot be said, and, up to rounding,
    where the covariance is diag(1 / weights).
    """
    used = weights > 0
    x = np.where(used, x, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        total = np.sum(weights, axis=1, keepdims=True)
        centre = np.sum(weights * x, axis=1, keepdims=True) / total
        dx = np.where(used, x - centre, 0.0)
        sxx = np.sum(weights * dx * dx, axis=1, keepdims=True)
        level, slope = weights / total, weights * dx / sxx  # linear in the points: (k, B) each
        intercept = level - centre * slope
        residual = np.eye(x.shape[1]) - level[:, None, :] - dx[:, :, None] * slope[:, None, :]
        expected = np.sum(weights * np.sum((residual @ covariance) * residual, axis=2), axis=1)
        spread = (np.count_nonzero(used, axis=1) - 2) / expected
        return (
            _factor(intercept, covariance, spread / (1 / total + centre**2 / sxx)[:, 0]),
            _factor(slope, covariance, spread * sxx[:, 0]),
        )


def _factor(coefficients: Floats, covariance: Floats, unit: Floats) -> Floats:
    squared = np.einsum("kb,kbc,kc->k", coefficients, covariance, coefficients) * unit
    return np.sqrt(np.where(np.isfinite(squared) & (squared > 0), squared, 1.0))
