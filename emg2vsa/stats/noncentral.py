"""Distribution functions of the noncentral t and F that hold however far they are from 0.

SciPy's series take as many terms as the noncentrality is large, and end in NaN beyond 1e5 (t) or 1e9 (F). Out there
the numerator of t is a normal variable far from 0, that of F as good as one, and the smooth rest is averaged over it.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats

_FAR_T = 1e3
_FAR_F = 1e7
_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(24)
_WEIGHTS /= _WEIGHTS.sum()


def noncentral_t(df: Floats, nc: Floats, t: Floats) -> Floats:
    """P(T <= t) for t >= 0; nc of either sign. NaN where an argument is."""
    far = nc > _FAR_T
    near = np.asarray(special.nctdtr(df, np.where(far, 0.0, nc), t), dtype=np.float64)
    if not far.any():
        return near
    numerator = np.where(far, nc, _FAR_T)[..., None] + _NODES
    return np.where(far, _denominator_above(df, t[..., None], numerator, 2), near)


def noncentral_f(df1: Floats, df2: Floats, nc: Floats, f: Floats) -> Floats:
    """P(F <= f) for f >= 0 and nc >= 0. NaN where an argument is.

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
