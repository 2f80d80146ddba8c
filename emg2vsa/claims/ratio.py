"""A ratio of two means over the same people (Fieller 1954), and how drift enters an interval."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import UNKNOWN, Ends, Found, student
from emg2vsa.statistics.drift import Drift, Slope

_ROUNDING = 1e-24


def ratio(top: Floats, bottom: Floats, more: Slope | None = None) -> Found:
    """Mean of ``top`` (n,) over mean of ``bottom`` (n,), of n units; UNKNOWN below two, or where nothing scatters.

    more : an error of the mean of ``top`` besides its scatter, whose value counts for nothing. The interval is that of
    all ratios r which Student's t of top - r bottom does not reject; endless where the mean of ``bottom`` may be 0.
    """
    n = top.size
    if n < 2:
        return UNKNOWN
    mean, other = float(np.mean(top)), float(np.mean(bottom))
    covariance = np.cov(top, bottom) / n
    v_top, v_both, v_bottom = (float(covariance[at]) for at in ((0, 0), (0, 1), (1, 1)))
    df, extra = n - 1.0, more.error**2 if more else 0.0
    if more and extra > 0:
        df = (v_top + extra) ** 2 / (v_top**2 / df + extra**2 / more.df)
        v_top += extra
    estimate = mean / other if other else np.nan
    of_rest = v_top - 2 * estimate * v_both + estimate**2 * v_bottom
    if not of_rest > _ROUNDING * (estimate * other) ** 2:
        return UNKNOWN

    def interval(confidence: float) -> Ends:
        t2 = float(special.stdtrit(df, 0.5 + 0.5 * confidence)) ** 2
        a, b, c = other**2 - t2 * v_bottom, mean * other - t2 * v_both, mean**2 - t2 * v_top
        if not a > 0:
            return -np.inf, np.inf
        reach = float(np.sqrt(max(b**2 - a * c, 0.0)))
        return (b - reach) / a, (b + reach) / a

    return Found(estimate, interval)


def biased(found: Found, most: Callable[[float], float]) -> Found:
    """With a bias whose size is below ``most`` at every confidence; alpha is shared by both (Bonferroni)."""

    def interval(confidence: float) -> Ends:
        shared = (1 + confidence) / 2
        low, high = found.interval(shared)
        return low - most(shared), high + most(shared)

    return Found(found.estimate, interval)


def free_of_drift(estimate: float, error: float, df: float, exposure: float, drift: Drift) -> Found:
    """A difference of two groups whose recordings lie ``exposure`` places apart on average, by Student's t.

    Where the order tells what drift does, it is taken out, with its error; else it may be as large as the trend within
    recordings allows, in either direction. Nobody knows the exposure where the order is unknown: a whole session.
    """
    if drift.order == "differs":
        moved = drift.by_order.times(exposure)
        total = error**2 + moved.error**2
        df = total**2 / (error**4 / df + moved.error**4 / moved.df) if total > 0 else df
        return student(estimate - moved.value, float(np.sqrt(total)), df)
    return biased(student(estimate, error, df), most_by_drift(drift, exposure))


def most_by_drift(drift: Drift, exposure: float) -> Callable[[float], float]:
    """How large a difference can be by drift alone, at every confidence."""
    places = abs(exposure) if drift.order == "same" else drift.places - 1.0
    return lambda confidence: drift.within.times(places).most(confidence) if places else 0.0
