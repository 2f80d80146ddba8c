"""How large an effect is: shares of variance after an F test, standardised differences of two groups; intervals.

The intervals rest on distribution functions of the noncentral t and F that hold however far they are from 0. SciPy's
series take as many terms as the noncentrality is large, and end in NaN beyond 1e5 (t) or 1e9 (F). Out there the
numerator of t is a normal variable far from 0, that of F as good as one, and the smooth rest is averaged over it.
The ends are sought by SciPy's Chandrupatla, all designs at once: its own inverses keep three digits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy import special
from scipy.optimize import elementwise

from emg2vsa.arrays import Floats

_FAR_T = 1e3
_FAR_F = 1e7
_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(24)
_WEIGHTS /= _WEIGHTS.sum()

_FROM_SERIES = 100.0
_GAMMA_RATIO = (1.0, -1 / 8, 1 / 128, 5 / 1024, -21 / 32768, -399 / 262144, 869 / 4194304, 39325 / 33554432)
"Coefficients of Gamma(x + 1/2) / Gamma(x) / sqrt(x), by powers of 1/x."


def noncentral_t(df: Floats, nc: Floats, t: Floats) -> Floats:
    """P(T <= t) for t >= 0; nc of either sign; arrays (n,) or of one shape. NaN where an argument is."""
    far = nc > _FAR_T
    near = np.asarray(special.nctdtr(df, np.where(far, 0.0, nc), t), dtype=np.float64)
    if not far.any():
        return near
    numerator = np.where(far, nc, _FAR_T)[..., None] + _NODES
    return np.where(far, _denominator_above(df, t[..., None], numerator, 2), near)


def noncentral_f(df1: Floats, df2: Floats, nc: Floats, f: Floats) -> Floats:
    """P(F <= f) for f >= 0 and nc >= 0; arrays (n,) or of one shape. NaN where an argument is.

    Far from 0 the numerator's third moment is left out: 1e-10 at most.
    """
    far = nc > _FAR_F
    near = np.asarray(special.ncfdtr(df1, df2, np.where(far, 0.0, nc), f), dtype=np.float64)
    if not far.any():
        return near
    at = np.where(far, nc, _FAR_F)
    numerator = (at + df1)[..., None] + np.sqrt(2 * df1 + 4 * at)[..., None] * _NODES
    return np.where(far, _denominator_above(df2, (df1 * f)[..., None], numerator, 1), near)


def _denominator_above(df: Floats, limit: Floats, numerator: Floats, power: int) -> Floats:
    """P(chi2 / df >= (numerator / limit)**power), averaged over the last axis."""
    with np.errstate(divide="ignore", over="ignore"):
        least = df[..., None] * (numerator / limit) ** power
    above: Floats = special.chdtrc(df[..., None], least) @ _WEIGHTS
    return above


def omega2(f: ArrayLike, df1: ArrayLike, n: ArrayLike) -> Floats:
    """Share of the population's variance after an F test on n values: df1 (F - 1) / (df1 (F - 1) + n), not below 0.

    Hays (1963) for one factor, partial with several (Olejnik and Algina 2003).
    """
    gain = np.where(np.isnan(_floats(f)), np.nan, _floats(df1) * np.fmax(_floats(f) - 1, 0.0))
    return _share(gain, gain + _floats(n))


def share_interval(
    f: ArrayLike, df1: ArrayLike, df2: ArrayLike, n: ArrayLike, confidence: float = 0.95
) -> tuple[Floats, Floats]:
    """Two-sided interval of the population's share by the noncentral F (Steiger 2004): lambda / (lambda + n).

    It holds what `omega2` estimates. The sample's eta squared is biased upwards, and may lie outside. (R's effectsize
    divides by lambda + df2 instead.)
    """
    f, df1, df2, n = np.broadcast_arrays(_floats(f), _floats(df1), _floats(df2), _floats(n))
    tail = (1 - confidence) / 2

    def share(probability: float) -> Floats:
        at = _noncentrality(lambda nc, a, b, x: noncentral_f(a, b, nc, x), probability, df1, df2, f)
        return np.where(np.isinf(f), 1.0, at / (at + n))

    return share(1 - tail), share(tail)


def hedges_g(t: ArrayLike, n1: ArrayLike, n2: ArrayLike, confidence: float = 0.95) -> tuple[Floats, Floats, Floats]:
    """g and its interval from Student's t of two groups: d = t sqrt(1/n1 + 1/n2) with Hedges' (1981) exact correction.

    The interval comes from the noncentral t, corrected by the same factor.
    """
    t, n1, n2 = np.broadcast_arrays(_floats(t), _floats(n1), _floats(n2))
    return _corrected(t, n1 + n2 - 2, np.sqrt(1 / n1 + 1 / n2), confidence)


def paired_g(t: ArrayLike, n: ArrayLike, confidence: float = 0.95) -> tuple[Floats, Floats, Floats]:
    """g_z and its interval from the paired t of n people: t / sqrt(n), in SDs of the differences (Lakens 2013).

    NaN for two people: Hedges' correction takes two degrees of freedom.
    """
    t, n = np.broadcast_arrays(_floats(t), _floats(n))
    return _corrected(t, n - 1, 1 / np.sqrt(n), confidence)


def _hedges_correction(df: Floats) -> Floats:
    """Gamma(df/2) / Gamma((df - 1)/2) / sqrt(df/2); NaN for one degree of freedom, where the mean of t does not exist.

    Logarithms of gamma grow, and their difference loses a digit with every tenfold df: from 200 on the ratio's
    asymptotic series (Abramowitz and Stegun 1964, 6.1.47) has them all.
    """
    x = (df - 1) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(
            x < _FROM_SERIES,
            np.exp(special.gammaln(x + 0.5) - special.gammaln(x)),
            np.sqrt(x) * np.polynomial.polynomial.polyval(1 / x, _GAMMA_RATIO),
        )
        return np.where(df > 1, ratio / np.sqrt(df / 2), np.nan)


def _corrected(t: Floats, df: Floats, per_t: Floats, confidence: float) -> tuple[Floats, Floats, Floats]:
    """t times ``per_t`` and Hedges' correction for ``df``; the ends of its noncentrality likewise."""
    correction = _hedges_correction(df)
    scale = correction * per_t
    tail = (1 - confidence) / 2
    size = np.abs(t)
    positive = special.stdtr(df, size) > 1 - tail  # else the lower end lies below 0
    low, high = (
        _noncentrality(lambda nc, k, x: noncentral_t(k, nc, x), tail_of, df, at)
        for tail_of, at in ((1 - tail, np.where(positive, size, np.nan)), (tail, size))
    )
    below = _noncentrality(lambda nc, k, x: 1 - noncentral_t(k, -nc, x), tail, df, np.where(positive, np.nan, size))
    low = np.where(positive, low, -below)
    low, high = np.where(t < 0, -high, low), np.where(t < 0, -low, high)
    return np.asarray(t * scale), np.asarray(low * scale), np.asarray(high * scale)


def _noncentrality(law: Callable[..., Floats], probability: float, *of: Floats) -> Floats:
    """nc >= 0 with ``law(nc, *of)``, which falls in nc, = ``probability``; 0 where it starts below it, NaN where one of
    ``of``, the last of which is about as large as nc, is not finite."""
    of = tuple(np.broadcast_arrays(*of))
    found = np.where(np.all(np.isfinite(of), axis=0), 0.0, np.nan)

    def excess(nc: Floats, *at: Floats) -> Floats:
        return law(nc, *at) - probability

    above = np.array(np.isfinite(found))
    above[above] = excess(np.zeros(np.count_nonzero(above)), *(each[above] for each in of)) > 0
    at = tuple(each[above] for each in of)
    high = np.fmax(1.0, at[-1])
    while np.any(short := excess(high, *at) >= 0):
        high = np.where(short, 2 * high, high)
    if high.size:
        found[above] = elementwise.find_root(excess, (np.zeros(high.shape), high), args=at).x
    return found


def _share(part: Floats, whole: Floats) -> Floats:
    """part / whole, 1 where an infinite F makes both infinite."""
    infinite = np.isinf(part)
    return np.asarray(np.where(infinite, 1.0, np.where(infinite, 0.0, part) / np.where(infinite, 1.0, whole)))


def _floats(values: ArrayLike) -> Floats:
    return np.asarray(values, dtype=np.float64)
