"""The logarithmic fits of a recording's presses: on force bins and on the samples, and the one to report."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.autocorrelation import autocorrelation, effective_number, memory
from emg2vsa.curves.bin_errors import bin_covariance, error_factors
from emg2vsa.curves.force_bins import ForceBins, bin_means
from emg2vsa.curves.logarithmic import LogFit, fit_log, fit_log_by_level, level_weights, widen
from emg2vsa.curves.ragged import pad_rows
from emg2vsa.settings import FitSettings


@dataclass(frozen=True)
class PressFits:
    """reported : the fit that was asked for. on_bins, on_samples : ordinary least squares of each stage, always.

    lag1, n_effective : (k,) of the samples' residuals over their level.
    """

    reported: LogFit
    on_bins: LogFit
    on_samples: LogFit
    bins: ForceBins
    lag1: Floats
    n_effective: Floats


def fit_presses(force_n: Floats, v: Floats, offsets: Ints, edges_n: Floats, fit: FitSettings) -> PressFits:
    """Fit k presses cut from the samples force_n, v (N,), evenly sampled in time, by ``offsets`` (k + 1,).

    Errors on bins allow for the correlation of the samples; errors on samples (the paper's fit) do not, and are several
    times too small: ``n_effective`` says why.
    """
    bins = bin_means(force_n, v, offsets, edges_n)
    force, samples = pad_rows(force_n, offsets), pad_rows(v, offsets)
    on_bins, on_samples = fit_log(bins.force_n, bins.v), fit_log(force, samples)
    level = on_samples.at(force)
    noise = 1 / np.sqrt(level_weights(level))
    correlation = autocorrelation((samples - level) / noise)
    if fit.points == "samples":
        reported, _ = _fit(force, samples, np.ones(samples.shape), fit)
    else:
        reported, weights = _fit(bins.force_n, bins.v, bins.samples.astype(np.float64), fit)
        covariance = bin_covariance(bins, noise, memory(correlation))
        reported = widen(reported, *error_factors(np.log(bins.force_n), weights, covariance))
    n = np.count_nonzero(np.isfinite(samples), axis=1).astype(np.float64)
    return PressFits(
        reported=reported,
        on_bins=on_bins,
        on_samples=on_samples,
        bins=bins,
        lag1=correlation[:, 1] if correlation.shape[1] > 1 else np.full(n.size, np.nan),
        n_effective=effective_number(correlation, n),
    )


def _fit(force_n: Floats, v: Floats, counts: Floats, fit: FitSettings) -> tuple[LogFit, Floats]:
    """The reported fit and its weights (k, B); ordinary least squares weighs every point that is there alike."""
    if fit.weights == "inverse-variance":
        return fit_log_by_level(force_n, v, counts, fit.robust, fit.confidence)
    return fit_log(force_n, v, None, fit.robust, fit.confidence), (counts > 0).astype(np.float64)
