"""Means over force bins: the points of a fit whose errors are close to independent; and what their dependence adds.

A smoothed envelope remembers tens of milliseconds; a bin of 0.3 N lasts about a hundred. The bins are then neither
independent nor of variance 1 / weight, and standard errors that think so are 5 to 20 % too small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import SettingError
from emg2vsa.settings import MOST_BINS

Number = TypeVar("Number", np.float64, np.int64)


def pad_rows(values: NDArray[Number], offsets: Ints, filler: float = np.nan) -> NDArray[Number]:
    """Rows ``values[offsets[i]:offsets[i + 1]]`` as (k, longest), ``filler`` beyond the end of each."""
    lengths = np.diff(offsets)
    inside = np.arange(np.max(lengths, initial=0)) < lengths[:, None]
    padded = np.full(inside.shape, filler, dtype=values.dtype)
    padded[inside] = values
    return padded


@dataclass(frozen=True)
class ForceBins:
    """force_n, v, samples : (k, B) force, activity and number of samples of every bin; NaN and 0 where empty.

    column : (k, longest) the bin of every sample of every trial, -1 outside the edges and beyond the trial's end.
    """

    force_n: Floats
    v: Floats
    samples: Ints
    column: Ints


def bin_edges(lowest_n: float, highest_n: float, bin_n: float) -> Floats:
    """Edges (B + 1,), N, from ``lowest_n`` in steps of ``bin_n``; a last, shorter bin is kept (0.5, 0.8, ... 6.8, 7;
    paper IV.B).

    SettingError : the lower force does not come first.
    """
    if not highest_n > lowest_n:
        raise SettingError(
            "window.force_n",
            wanted="a lower and a higher force",
            found=f"{lowest_n}, {highest_n} N",
            do="Write the lower force first.",
        )
    full = int(np.floor((highest_n - lowest_n) / bin_n * (1 + 1e-12)))
    edges = np.round(lowest_n + bin_n * np.arange(full + 1), 9)
    return edges if highest_n - edges[-1] < 1e-9 else np.append(edges, highest_n)


def fit_edges(lowest_n: float, highest_n: float, bin_n: float) -> Floats:
    """``bin_edges`` (B + 1,), N, of the bins of a fit. SettingError where there would be more than ``MOST_BINS``."""
    if (bins := (highest_n - lowest_n) / bin_n) > MOST_BINS + 1e-6:
        raise SettingError(
            "fit.bin_n",
            wanted=f"at most {MOST_BINS} bins from {lowest_n:g} to {highest_n:g} N",
            found=f"{math.ceil(bins)} bins of {bin_n:g} N",
            do="Widen the bins: no press has samples for so many.",
        )
    return bin_edges(lowest_n, highest_n, bin_n)


def bin_means(force_n: Floats, v: Floats, offsets: Ints, edges_n: Floats) -> ForceBins:
    """Bin the samples (N,) of k trials, cut by ``offsets`` (k + 1,); samples outside the edges are left out.

    The force of a bin is the geometric mean of its samples' forces, so that a law linear in ln F passes through the
    bin means exactly (the arithmetic mean would bias b by some tenths of a percent).
    Bins of force are those of paper IV.B.
    """
    n_bins = edges_n.size - 1
    column = np.searchsorted(edges_n, force_n, side="right") - 1
    column[force_n == edges_n[-1]] = n_bins - 1
    inside = (column >= 0) & (column < n_bins) & np.isfinite(force_n) & np.isfinite(v)
    column[~inside] = -1
    row = np.repeat(np.arange(offsets.size - 1), np.diff(offsets))
    cell = (row * n_bins + column)[inside]
    shape = (offsets.size - 1, n_bins)
    samples = np.bincount(cell, minlength=shape[0] * n_bins)
    with np.errstate(invalid="ignore", divide="ignore"):
        log_force = np.bincount(cell, np.log(force_n[inside]), minlength=samples.size) / samples
        level = np.bincount(cell, v[inside], minlength=samples.size) / samples
    return ForceBins(
        np.exp(log_force).reshape(shape), level.reshape(shape), samples.reshape(shape), pad_rows(column, offsets, -1)
    )


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


def error_factors(x: Floats, weights: Floats, covariance: Floats) -> tuple[Floats, Floats, Floats]:
    """Factors (k,), (k,) by which the standard errors of intercept and slope must grow, given the points' true
    covariance; and the degrees of freedom (k,) that are left to the variance of the residuals (Satterthwaite 1946),
    1 at least.

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
        share = (residual @ covariance) @ residual.transpose(0, 2, 1) * weights[:, None, :]
        expected = np.einsum("kbb->k", share)
        points = np.count_nonzero(used, axis=1) - 2
        spread = points / expected
        dof = expected**2 / np.einsum("kbc,kcb->k", share, share)
        return (
            _factor(intercept, covariance, spread / (1 / total + centre**2 / sxx)[:, 0]),
            _factor(slope, covariance, spread * sxx[:, 0]),
            np.where(np.isfinite(dof), np.clip(dof, 1, np.maximum(points, 1)), points),
        )


def _factor(coefficients: Floats, covariance: Floats, unit: Floats) -> Floats:
    squared = np.einsum("kb,kbc,kc->k", coefficients, covariance, coefficients) * unit
    return np.sqrt(np.where(np.isfinite(squared) & (squared > 0), squared, 1.0))
