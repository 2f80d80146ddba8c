"""What claims on people estimate besides steps: their mean, how they spread, and the shape of their clusters."""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.claims.claim import UNKNOWN, Ends, Found, student

_FEWEST_FOR_SHAPE = 4
ROUNDING = 1e-12
"""Share of a value below which a difference is rounding."""


def people_f(mean: Floats, count: Ints, squares: float, cells: int = 0) -> Found:
    """SD of the means (P,) of people over that of presses. count : (P,) presses. squares : of presses about the mean of
    their cell, of which there are ``cells``, one a person unless given.

    The interval is exact for people with as many presses each; else that of Thomas and Hultquist (1978), with the
    harmonic mean of the counts and unweighted means. UNKNOWN below two people, or without two presses of anybody.
    """
    mean, count = mean[count > 0], count[count > 0]
    df1, df2 = count.size - 1.0, float(count.sum() - (cells or count.size))
    if df1 < 1 or df2 < 1 or not squares > 0:
        return UNKNOWN
    presses = count.size / float(np.sum(1 / count))
    f_ratio = presses * float(np.var(mean, ddof=1)) / (squares / df2)

    def size_at(quantile: float) -> float:
        limit = float(special.fdtri(df1, df2, quantile))
        return float(np.sqrt(max(f_ratio / limit - 1, 0.0) / presses)) if limit > 0 else np.inf

    def interval(confidence: float) -> Ends:
        return size_at(0.5 + 0.5 * confidence), size_at(0.5 - 0.5 * confidence)

    return Found(float(np.sqrt(max(f_ratio - 1, 0.0) / presses)), interval)


def by_recordings(found: Found, level: Floats, steps: Floats, of_presses: float) -> Found:
    """``found`` with the low end that recordings allow: presses of one recording are alike for reasons of their own.

    level : (P,) of people, means of their ``steps`` (P, S) from the mean of each specimen. of_presses : their variance.
    People differ where their levels do so more than the recordings of one person, by Fisher's F.
    """
    people, specimens = steps.shape
    if people < 2 or specimens < 2 or not np.isfinite(steps).all():
        return found
    df1, df2 = people - 1.0, (people - 1.0) * (specimens - 1)
    of_steps = float(np.sum((steps - level[:, None]) ** 2)) / df2
    f_ratio = specimens * float(np.var(level, ddof=1)) / of_steps if of_steps > 0 else np.inf

    def interval(confidence: float) -> Ends:
        low, high = found.interval(confidence)
        beyond = max(f_ratio / float(special.fdtri(df1, df2, 0.5 + 0.5 * confidence)) - 1, 0.0)
        return min(low, float(np.sqrt(beyond * of_steps / specimens / of_presses))), high

    return Found(found.estimate, interval)


def shape_of(values: Floats) -> tuple[Floats, Floats]:
    """Skewness and excess kurtosis of clusters (..., R), free of bias for Gaussian ones; NaN below four values (G1 and
    G2 of Joanes and Gill 1998)."""
    there = np.isfinite(values)
    n = np.count_nonzero(there, axis=-1).astype(np.float64)
    n[n < _FEWEST_FOR_SHAPE] = np.nan
    rest = np.where(there, values - mean_of(values)[..., None], 0.0)
    largest = np.max(np.abs(values), axis=-1, where=there, initial=0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        rest = rest / largest[..., None]
        rest = np.where(np.abs(rest) > ROUNDING, rest, 0.0)
        m2, m3, m4 = (np.sum(rest**power, axis=-1) / n for power in (2, 3, 4))
        skewness = np.sqrt(n * (n - 1)) / (n - 2) * m3 / m2**1.5
        kurtosis = (n - 1) / ((n - 2) * (n - 3)) * ((n + 1) * (m4 / m2**2 - 3) + 6)
    return skewness, kurtosis


def mean_of_people(values: Floats) -> Found:
    """Of one value a person (P,), by Student's t (1908); people without one do not count. UNKNOWN below two."""
    own = values[np.isfinite(values)]
    if own.size < 2:
        return UNKNOWN
    return student(float(np.mean(own)), float(np.std(own, ddof=1) / np.sqrt(own.size)), own.size - 1.0)
