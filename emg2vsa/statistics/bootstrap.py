"""Bias-corrected and accelerated bootstrap of any statistic of groups (Efron 1987), many designs at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import DataError, SettingError
from emg2vsa.statistics.moments import shifted_doubles

Statistic = Callable[[Floats], Floats]
"""Of samples (..., k, n) with NaN where there is no value, returns (...); it must skip the NaN, as np.nanmean does."""
_ROOM = 2**21  # values of resamples in memory at once


@dataclass(frozen=True)
class Bootstrap:
    """Of d designs, (d,) each, NaN where undefined: estimate, its interval low to high at ``confidence``."""

    estimate: Floats
    low: Floats
    high: Floats
    confidence: float


def bca(
    values: ArrayLike,
    statistic: Statistic,
    n_resamples: int = 2000,
    seed: int = 0,
    confidence: float = 0.95,
) -> Bootstrap:
    """Interval of ``statistic`` of ``values`` (d, k groups, n a group), or of one design (k, n); NaN: no value there.

    Values are drawn within their group; resamples for which the statistic is not a finite number are left out. Every
    design is resampled at the same random places, so that its answer depends on ``seed`` and on nothing else in the
    batch. Acceleration from the jackknife, over several groups as in Davison and Hinkley (1997, 5.4). DataError for
    another shape of values or of what the statistic returns.
    """
    samples = _leading(values)
    count = np.count_nonzero(~np.isnan(samples), axis=2)
    estimate = _apply(statistic, samples)
    drawn = resampled(samples, statistic, n_resamples, seed)
    finite = np.isfinite(drawn)
    m = np.count_nonzero(finite, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        below = np.count_nonzero(drawn < estimate[:, None], axis=1) / m
        at = np.count_nonzero(drawn == estimate[:, None], axis=1) / m
        z0 = np.where(np.isfinite(estimate) & np.any(count > 1, axis=1), special.ndtri(below + at / 2), np.nan)
    acceleration = _acceleration(samples, count, statistic)
    ordered = np.sort(np.where(finite, drawn, np.inf), axis=1)
    z = special.ndtri((1 + confidence) / 2)
    low, high = (_quantile(ordered, m, _level(z0, acceleration, side)) for side in (-z, z))
    return Bootstrap(estimate, low, high, confidence)


def resampled(values: ArrayLike, statistic: Statistic, n_resamples: int, seed: int) -> Floats:
    """``statistic`` of ``n_resamples`` resamples of each design, (d, n_resamples); arguments as ``bca``."""
    if n_resamples < 2:
        raise SettingError("bootstrap", wanted="2 resamples or more", found=str(n_resamples), do="Take 2000.")
    samples = _leading(values)
    count = np.maximum(np.count_nonzero(~np.isnan(samples), axis=2), 1)
    rng = np.random.default_rng(seed)
    drawn = np.empty((len(samples), n_resamples))
    step = max(1, _ROOM // max(samples.size, 1))
    beyond = np.arange(samples.shape[2]) >= count[:, None, :, None]
    ragged = bool(np.any(beyond))
    for start in range(0, n_resamples, step):
        places = rng.random((min(step, n_resamples - start), *samples.shape[1:]))
        index = (places * count[:, None, :, None]).astype(np.int64)
        chosen = np.take_along_axis(samples[:, None], index, axis=3)
        drawn[:, start : start + step] = _apply(statistic, np.where(beyond, np.nan, chosen) if ragged else chosen)
    return drawn


def _leading(values: ArrayLike) -> Floats:
    """(d, k, n) with the values of every group before its NaN."""
    doubles, origin = shifted_doubles(values)
    doubles = doubles + origin[:, None, None]
    doubles = np.where(np.isfinite(doubles), doubles, np.nan)
    order = np.argsort(np.isnan(doubles), axis=2, kind="stable")
    return np.take_along_axis(doubles, order, axis=2)


def _apply(statistic: Statistic, samples: Floats) -> Floats:
    answer = np.asarray(statistic(samples), dtype=np.float64)
    if answer.shape != samples.shape[:-2]:
        raise DataError(
            "bootstrap, statistic",
            wanted=f"one number a design, shape {samples.shape[:-2]}",
            found=f"shape {answer.shape}",
            do="Let it work on the last two axes, groups and values.",
        )
    return answer


def _acceleration(samples: Floats, count: Ints, statistic: Statistic) -> Floats:
    """A sixth of the skewness of the influence of each value, from leaving it out; 0 where no value matters."""
    d, k, n = samples.shape
    influence = np.zeros((d, k, n))
    for group in range(k):
        for place in range(n):
            filled = place < count[:, group]
            # a group's only value stays: its influence counts n - 1 = 0 times
            without = samples.copy()
            without[filled & (count[:, group] > 1), group, place] = np.nan
            influence[:, group, place] = np.where(filled, _apply(statistic, without), np.nan)
    there = np.isfinite(influence)
    size = np.max(np.abs(influence), axis=(1, 2), keepdims=True, initial=0.0, where=there)
    influence = np.where(there, influence, 0.0) / np.where(size > 0, size, 1.0)
    mean = np.sum(influence, axis=2, where=there) / np.maximum(np.count_nonzero(there, axis=2), 1)
    u = np.where(there, mean[:, :, None] - influence, 0.0) * ((count - 1) / np.maximum(count, 1))[:, :, None]
    squares = np.sum(u**2, axis=(1, 2))
    return np.asarray(np.sum(u**3, axis=(1, 2)) / (6 * np.where(squares > 0, squares, np.inf) ** 1.5))


def _level(z0: Floats, acceleration: Floats, z: float) -> Floats:
    """Which quantile of the resamples is the end that z stands for; beyond the reach of the formula the outermost."""
    moved = np.where(np.isinf(z0), np.nan, z0 + z)
    stretch = 1 - acceleration * moved
    end = np.where(stretch > 0, z0 + moved / np.where(stretch > 0, stretch, 1.0), np.copysign(np.inf, moved))
    return np.asarray(special.ndtr(np.where(np.isnan(moved), np.nan, end)))


def _quantile(ordered: Floats, m: Ints, probability: Floats) -> Floats:
    """Of the first m of sorted rows, between neighbours linearly; NaN for m = 0 or probability NaN."""
    defined = (m > 0) & ~np.isnan(probability)
    place = np.where(defined, probability, 0.0) * np.maximum(m - 1, 0)
    lower = np.floor(place).astype(np.int64)
    rows = np.arange(len(ordered))
    a, b = ordered[rows, lower], ordered[rows, np.minimum(lower + 1, np.maximum(m - 1, 0))]
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(defined, a + (b - a) * (place - lower), np.nan))
