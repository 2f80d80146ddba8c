"""How large an effect is: shares of variance after an F test, standardised differences of two groups; intervals."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats
from emg2vsa.stats.noncentral import noncentral_f, noncentral_t

_BISECTIONS = 100


def eta2(f: ArrayLike, df1: ArrayLike, df2: ArrayLike) -> Floats:
    """SS_between / SS_total; the (partial) eta squared of any F. Biased upwards."""
    explained = _floats(f) * _floats(df1)
    return _share(explained, explained + _floats(df2))


def omega2(f: ArrayLike, df1: ArrayLike, df2: ArrayLike) -> Floats:
    """Hays' (1963) estimate of the population's share, one-way: df1 (F - 1) / (df1 (F - 1) + N). May be negative."""
    gain = _floats(df1) * (_floats(f) - 1)
    return _share(gain, gain + _floats(df1) + _floats(df2) + 1)


def epsilon2(f: ArrayLike, df1: ArrayLike, df2: ArrayLike) -> Floats:
    """Kelley's (1935): df1 (F - 1) / (df1 F + df2). Not the epsilon squared of ranks."""
    f, df1, df2 = _floats(f), _floats(df1), _floats(df2)
    return _share(df1 * (f - 1), df1 * f + df2)


def cohens_f(share: ArrayLike) -> Floats:
    """f = sqrt(share / (1 - share)) of an eta squared (Cohen 1988)."""
    share = _floats(share)
    with np.errstate(divide="ignore"):
        return np.asarray(np.sqrt(share / (1 - share)))


def eta2_interval(f: ArrayLike, df1: ArrayLike, df2: ArrayLike, confidence: float = 0.95) -> tuple[Floats, Floats]:
    """Two-sided interval of eta squared by the noncentral F (Steiger 2004); lambda / (lambda + N), N = df1 + df2+1."""
    f, df1, df2 = np.broadcast_arrays(_floats(f), _floats(df1), _floats(df2))
    tail = (1 - confidence) / 2
    total = df1 + df2 + 1

    def share(probability: float) -> Floats:
        at = _noncentrality(lambda nc: noncentral_f(df1, df2, nc, f), probability, f)
        return np.where(np.isinf(f), 1.0, at / (at + total))

    return share(1 - tail), share(tail)


def hedges_g(t: ArrayLike, n1: ArrayLike, n2: ArrayLike, confidence: float = 0.95) -> tuple[Floats, Floats, Floats]:
    """g and its interval from Student's t of two groups: d = t sqrt(1/n1 + 1/n2) with Hedges' (1981) exact correction.

    The interval comes from the noncentral t, corrected by the same factor.
    """
    t, n1, n2 = np.broadcast_arrays(_floats(t), _floats(n1), _floats(n2))
    df = n1 + n2 - 2
    correction = np.exp(special.gammaln(df / 2) - special.gammaln((df - 1) / 2)) / np.sqrt(df / 2)
    scale = correction * np.sqrt(1 / n1 + 1 / n2)
    tail = (1 - confidence) / 2
    size = np.abs(t)
    high = _noncentrality(lambda nc: noncentral_t(df, nc, size), tail, size)
    low = _signed_noncentrality(df, size, 1 - tail)
    low, high = np.where(t < 0, -high, low), np.where(t < 0, -low, high)
    return np.asarray(t * scale), np.asarray(low * scale), np.asarray(high * scale)


def _signed_noncentrality(df: Floats, t: Floats, probability: float) -> Floats:
    """Noncentrality of either sign at which t >= 0 has the distribution function ``probability``."""
    positive = special.stdtr(df, t) > probability
    over, under = np.where(positive, t, np.nan), np.where(positive, np.nan, t)
    above = _noncentrality(lambda nc: noncentral_t(df, nc, over), probability, over)
    below = _noncentrality(lambda nc: 1 - noncentral_t(df, -nc, under), 1 - probability, under)
    return np.asarray(np.where(positive, above, -below))


def _noncentrality(distribution: Callable[[Floats], Any], probability: float, like: Floats) -> Floats:
    """nc >= 0 with ``distribution(nc)``, which falls in nc, = ``probability``; 0 where it starts below it."""
    undefined = ~np.isfinite(like)

    def too_small(nc: Floats) -> np.ndarray:
        return np.asarray(distribution(nc) > probability) & ~undefined

    high = np.fmax(1.0, np.where(undefined, 1.0, like))
    while np.any(short := too_small(high)):
        high = np.where(short, 2 * high, high)
    low = np.zeros_like(high)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        small = too_small(middle)
        low, high = np.where(small, middle, low), np.where(small, high, middle)
    return np.asarray(np.where(undefined, np.nan, (low + high) / 2))


def _share(part: Floats, whole: Floats) -> Floats:
    """part / whole, 1 where an infinite F makes both infinite."""
    infinite = np.isinf(part)
    return np.asarray(np.where(infinite, 1.0, np.where(infinite, 0.0, part) / np.where(infinite, 1.0, whole)))


def _floats(values: ArrayLike) -> Floats:
    return np.asarray(values, dtype=np.float64)
