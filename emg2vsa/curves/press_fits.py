"""The logarithmic fits of a recording's presses: on force bins and on the samples, and the one to report.

Beside them stands how long the residuals remember, and how many independent observations they are worth.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.curves.force_bins import ForceBins, bin_covariance, bin_means, error_factors, pad_rows
from emg2vsa.curves.logarithmic import LogFit, fit_log, fit_log_by_level, fit_log_weighted, level_weights, widen
from emg2vsa.settings import FitSettings

PARAMETERS = 2
"Parameters of a line."
FEWEST_DOF = 2
"A press is never left with a single degree of freedom: an interval of 12.7 standard errors says nothing."
MOST_SHARE, ROUNDS = 0.7, 6
"""Largest share of the noise that a line is held to have taken, and how often that share is found anew from its own
result.
"""

FEWEST_SAMPLES = 10
"A press with fewer shows no curve."
BEND_CHANCE = 0.001
"Chance that a term is told that the common curve does not have."

CELLS_AT_ONCE = 2**22
"Most numbers of covariances of bins at once: 32 MB an array."


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

    Errors on bins allow for the correlation of the samples, and their interval for the degrees of freedom that slow
    noise leaves: no more than the effective number of samples has (``shared_number``). Where the presses share a curve
    other than the line, b is the slope of its best line over the window, and the errors are those of that slope: noise
    is what lies about the curve (``common_bend``). Errors on samples (the paper's fit) do none of this, and are several
    times too small: ``n_effective`` says why.
    """
    bins = bin_means(force_n, v, offsets, edges_n)
    force, samples = pad_rows(force_n, offsets), pad_rows(v, offsets)
    on_bins, on_samples = fit_log(bins.force_n, bins.v), fit_log(force, samples)
    level = on_samples.at(force)
    n = np.count_nonzero(np.isfinite(samples), axis=1).astype(np.float64)
    correlation = autocorrelation((samples - level) * np.sqrt(level_weights(level)))
    if fit.points == "samples":
        reported, _ = _fit(force, samples, np.ones(samples.shape), fit)
    else:
        line, weights = _fit(bins.force_n, bins.v, bins.samples.astype(np.float64), fit)
        reported = _with_errors(line, bins, weights, level, correlation, n, fit)
        bend = common_bend(force, samples, level, edges_n)
        if np.any(bend):
            level = fit_log(force, samples - bend).at(force) + bend
            inside = np.arange(bend.shape[1]) < np.diff(offsets)[:, None]
            without = bin_means(force_n, v - bend[inside], offsets, edges_n).v
            about = fit_log_weighted(bins.force_n, without, weights, fit.robust, fit.confidence)
            of_curve = autocorrelation((samples - level) * np.sqrt(level_weights(level)))
            reported = _narrowed(reported, _with_errors(about, bins, weights, level, of_curve, n, fit), fit.confidence)
    return PressFits(
        reported=reported,
        on_bins=on_bins,
        on_samples=on_samples,
        bins=bins,
        lag1=correlation[:, 1] if correlation.shape[1] > 1 else np.full(n.size, np.nan),
        n_effective=effective_number(correlation, n),
    )


def _with_errors(
    line: LogFit, bins: ForceBins, weights: Floats, level: Floats, correlation: Floats, n: Floats, fit: FitSettings
) -> LogFit:
    """The line with the errors that noise of this autocorrelation (k, p) about the level (k, p) gives it."""
    independent = shared_number(effective_number(without_line(correlation, n), n), n)
    noise = 1 / np.sqrt(level_weights(level))
    a_factor, b_factor, dof = _factors(bins, weights, noise, memory(correlation))
    # where the effective number is not known (NaN), it sets no limit
    dof = np.fmin(dof, np.maximum(independent - PARAMETERS, FEWEST_DOF))
    return widen(line, a_factor, b_factor, dof, fit.confidence)


def _narrowed(line: LogFit, curve: LogFit, confidence: float) -> LogFit:
    """The line with the errors about the common curve: at least those that the scatter of b from press to press shows,
    which also holds what is slower than a press, and at most its own."""
    known = np.isfinite(line.b)
    scatter = np.array([np.std(each[known], ddof=1) for each in (line.a, line.b)])
    a_se, b_se = (
        np.fmin(own, np.fmax(about, least))
        for own, about, least in zip((line.a_se, line.b_se), (curve.a_se, curve.b_se), scatter, strict=True)
    )
    least = float(special.stdtrit(np.count_nonzero(known) - 1, 0.5 + 0.5 * confidence) * scatter[1])
    reach = np.fmin(line.b_hi - line.b, np.fmax(curve.b_hi - curve.b, least))
    return replace(line, a_se=a_se, b_se=b_se, b_lo=line.b - reach, b_hi=line.b + reach)


def common_bend(force: Floats, v: Floats, level: Floats, edges_n: Floats) -> Floats:
    """What the presses' common curve is beside a line in ln F, (k, p) in the unit of v; 0 where they show none.

    force, v, level : (k, p), NaN where there is none; level is the line's, whose weights are inverse variances. The
    curve is a polynomial of third order, in proportion to the mean level of a press; each of its two terms counts where
    the presses agree on it by Student's t, so that two or three presses hardly ever show one, and one never. It is no
    noise: it adds nothing to the scatter of b from press to press.
    """
    z = 2 * np.log(force / edges_n[0]) / np.log(edges_n[-1] / edges_n[0]) - 1
    known = np.isfinite(z) & np.isfinite(v)
    weights = np.where(known, np.sqrt(level_weights(level)), 0.0)
    z, filled = np.where(known, z, 0.0), np.where(known, v, 0.0)
    terms = np.polynomial.legendre.legvander(z, 3)
    size = filled.sum(axis=1) / np.maximum(np.count_nonzero(known, axis=1), 1)
    enough = (np.count_nonzero(known, axis=1) >= FEWEST_SAMPLES) & (size > 0)
    count = int(np.count_nonzero(enough))
    if count < 2:
        return np.zeros(v.shape)
    columns = (terms * weights[..., None])[enough]
    normal = columns.transpose(0, 2, 1) @ columns
    found = (np.linalg.pinv(normal) @ columns.transpose(0, 2, 1) @ (filled * weights)[enough, :, None])[..., 0]
    of_size = found / size[enough, None]
    mean, se = of_size.mean(axis=0), of_size.std(axis=0, ddof=1) / count**0.5
    clear = np.abs(mean) > special.stdtrit(count - 1, 1 - BEND_CHANCE / 2) * se
    return np.asarray(size[:, None] * (terms[..., 2:] @ np.where(clear, mean, 0.0)[2:]))


def _factors(bins: ForceBins, weights: Floats, noise: Floats, memory: Floats) -> tuple[Floats, Floats, Floats]:
    """``error_factors`` (k,) each, of some presses at a time: covariances of many narrow bins would fill the memory."""
    at_once = max(1, CELLS_AT_ONCE // (bins.v.shape[1] + 1) ** 2)
    found = []
    for first in range(0, max(len(weights), 1), at_once):
        part = slice(first, first + at_once)
        own = ForceBins(bins.force_n[part], bins.v[part], bins.samples[part], bins.column[part])
        covariance = bin_covariance(own, noise[part], memory[part])
        found.append(error_factors(np.log(own.force_n), weights[part], covariance))
    a_factor, b_factor, dof = (np.concatenate(each) for each in zip(*found, strict=True))
    return a_factor, b_factor, dof


def _fit(force_n: Floats, v: Floats, counts: Floats, fit: FitSettings) -> tuple[LogFit, Floats]:
    """The reported fit and its weights (k, B); ordinary least squares weighs every point that is there alike."""
    if fit.weights == "inverse-variance":
        return fit_log_by_level(force_n, v, counts, fit.robust, fit.confidence)
    return fit_log(force_n, v, fit.robust, fit.confidence), (counts > 0).astype(np.float64)


def autocorrelation(residuals: Floats) -> Floats:
    """Autocorrelation (k, p) at lags 0 to p - 1 of rows (k, p), padded with NaN at the end.

    Biased estimate (sums over all n values; Box and Jenkins 1976), so that no lag is wild. NaN for rows that are
    constant or have fewer than three values.
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


def shared_number(independent: Floats, n: Floats) -> Floats:
    """Effective numbers (k,) of presses of n (k,) values that all share: the geometric mean of what a value is worth.

    That of one press alone is too noisy: now and then it leaves a single degree of freedom, and t of 12.7.
    """
    known = np.isfinite(independent)
    worth = float(np.exp(np.mean(np.log(n[known] / independent[known])))) if known.any() else np.nan
    return np.where(known, np.clip(n / worth, 1, np.maximum(n, 1)), np.nan)


def without_line(correlation: Floats, n: Floats) -> Floats:
    """Autocorrelation (k, p) of the noise, from that of n (k,) residuals of a line fitted to it.

    A line follows slow noise, and what it takes is missing from the residuals at every lag: its two parameters' share
    of the effective number of values, which follows from the result. An upper
    bound rather than an estimate: it limits degrees of freedom, and no standard error rests on it.
    """
    share, discounts = np.zeros((len(correlation), 1)), _discounts(correlation, n)
    for _ in range(ROUNDS):
        worth = n / _effective(correlation * (1 - share) + share, n, discounts)
        found = np.minimum(PARAMETERS * worth / np.maximum(n, 1), MOST_SHARE)
        share = np.where(np.isnan(found), 0.0, found)[:, None]
    return correlation * (1 - share) + share


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
    The formula is that of Bayley and Hammersley (1946).
    """
    return _effective(correlation, n, _discounts(correlation, n))


def _discounts(correlation: Floats, n: Floats) -> Floats:
    """1 - j / n (k, p - 1) of the lags j from 1 on."""
    return np.asarray(1 - np.arange(1, correlation.shape[1]) / np.maximum(n, 1)[:, None])


def _effective(correlation: Floats, n: Floats, discounts: Floats) -> Floats:
    """``effective_number`` (k,), by the ``_discounts``."""
    if correlation.shape[1] < 2:
        return np.full(len(correlation), np.nan)
    worth = 1 + 2 * np.sum(discounts * memory(correlation)[:, 1:], axis=1)
    return np.where(np.isnan(correlation[:, 1]), np.nan, np.clip(n / worth, 1, np.maximum(n, 1)))
