"""A ratio of two means over the same people (Fieller 1954)."""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.claims.claim import UNKNOWN, Ends, Found
from emg2vsa.statistics.drift import Slope

_ROUNDING = 1e-24


def ratio(top: Floats, bottom: Floats, more: Slope | None = None) -> Found:
    """Mean of ``top`` (n,) over mean of ``bottom`` (n,), of n units; UNKNOWN below two, or where nothing scatters.

    more : an error of the mean of ``top`` besides its scatter, whose value counts for nothing. The interval is that of
    all ratios r which Student's t of top - r bottom does not reject; endless where the mean of ``bottom`` may be 0.
    By Fieller (1954).
    """
    n, scale = top.size, float(np.max(np.abs(bottom), initial=0.0))
    if n < 2 or not 0 < scale < np.inf:
        return UNKNOWN
    top, bottom, more = top / scale, bottom / scale, more.times(1 / scale) if more else None
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
