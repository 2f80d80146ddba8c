"""The search behind the exponential fit: least squares of y on p exp(q z) over q alone, p always at its best.

Golub and Pereyra (1973). Newton's method with the exact second derivative, from a log-linear start; Gauss-Newton where
the sum of squares is not convex, and half the step where it would grow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats

_MAX_ITERATIONS = 60
_LONGEST_STEP = 2.0  # of q where |z| <= 1: factors of e^2 at the ends of the data
_LAST_STEP = 1e-10  # Newton squares it: what is left is below rounding
_LEAST_CONVEX = 1e-3
_SPIKE = 1e-12  # of the curve's square, what points other than the heaviest carry
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Projected:
    """The curve with the best level for a given q, and the way to a better q; (d,).

    centre : the z at which level and q are uncorrelated. level : of the curve there. sse : sum of squares left. step :
    to a better q. level_information, slope_information : what the variances of ln level and of q are s^2 over.
    """

    level: Floats
    centre: Floats
    sse: Floats
    step: Floats
    level_information: Floats
    slope_information: Floats


def projected(q: Floats, z: Floats, y: Floats, w: Floats) -> Projected:
    """z, y, w : (d, n) finite, |z| <= 1; q : (d,)."""
    u = q[:, None] * z
    u -= np.abs(q)[:, None]  # no larger than 1
    np.exp(u, out=u)
    wu = w * u
    uu = _dot(wu, u)
    p = _dot(wu, y) / uu
    work = wu * u  # one array for all products: new ones would cost more than the arithmetic
    centre = _dot(work, z) / uu
    arm = z - centre[:, None]
    lever = np.multiply(wu, arm, out=wu)
    gauss_newton = p * _dot(lever, np.multiply(arm, u, out=work))
    residual = np.subtract(y, np.multiply(p[:, None], u, out=u), out=u)
    newton = gauss_newton - _dot(lever, np.multiply(arm, residual, out=work))
    curvature = np.where(newton / gauss_newton > _LEAST_CONVEX, newton, gauss_newton)
    return Projected(
        level=p * np.exp(q * centre - np.abs(q)),
        centre=centre,
        sse=_dot(np.multiply(w, residual, out=work), residual),
        step=_dot(lever, residual) / curvature,
        level_information=p * p * uu,
        slope_information=p * gauss_newton,
    )


def search(z: Floats, y: Floats, w: Floats, start: Floats) -> Floats:
    """q (d,) of least squares from ``start``, NaN where there is no start or the search does not end; |z| <= 1."""
    q = np.full_like(start, np.nan)
    active = np.flatnonzero(np.isfinite(start))
    z, y, w, here = z[active], y[active], w[active], start[active]
    size = _dot(w * y, y)
    now = projected(here, z, y, w)
    best, step = now.sse, np.clip(now.step, -_LONGEST_STEP, _LONGEST_STEP)
    for _ in range(_MAX_ITERATIONS):
        last = np.abs(step) <= _LAST_STEP * np.maximum(1.0, np.abs(here))
        if np.any(last):
            q[active[last]] = (here + step)[last]
            active, z, y, w = active[~last], z[~last], y[~last], w[~last]
            here, best, step, size = here[~last], best[~last], step[~last], size[~last]
        if active.size == 0:
            break
        there = projected(here + step, z, y, w)
        better = there.sse <= best + _rounding(best, size)
        here = np.where(better, here + step, here)
        best = np.where(better, there.sse, best)
        step = np.where(better, np.clip(there.step, -_LONGEST_STEP, _LONGEST_STEP), step / 2)
    return q


def has_minimum(q: Floats, z: Floats, y: Floats, w: Floats, curve: Projected) -> NDArray[np.bool_]:
    """Whether (d,) the sum of squares at ``curve`` grows beyond its q: it does not where the curve has become a spike
    through one point, which a steeper spike fits as well.
    """
    fixed = np.isfinite(q)
    spikes = np.flatnonzero(fixed & (curve.slope_information < _SPIKE * curve.level_information))
    if spikes.size:
        q, z, y, w, sse = q[spikes], z[spikes], y[spikes], w[spikes], curve.sse[spikes]
        steeper = projected(q + np.sign(q), z, y, w).sse
        fixed[spikes] = steeper > sse + _rounding(sse, _dot(w * y, y))
    return fixed


def _rounding(sse: Floats, size: Floats) -> Floats:
    """Of a sum of squared residuals of values whose squares sum to ``size``."""
    return 16 * _EPS * (np.sqrt(sse * size) + _EPS * size)


def log_linear_start(z: Floats, y: Floats, w: Floats) -> Floats:
    """Slope (d,) of ln |y| on z over the points of the prevailing sign, weighted by y^2: the answer but for noise.

    NaN where those points do not lie at two z at least.
    """
    sign = np.where(_dot(w * y, np.abs(y)) < 0, -1.0, 1.0)
    towards = sign[:, None] * y
    used = (towards > 0) & (w > 0)
    weight = np.where(used, w * towards**2, 0.0)
    weight /= np.max(weight, axis=1, keepdims=True, initial=0.0)
    log_y = np.log(np.where(used, towards, 1.0))
    total = np.sum(weight, axis=1)
    arm = z - (_dot(weight, z) / total)[:, None]
    lever = np.multiply(weight, arm, out=weight)
    spread = _dot(lever, arm)
    return np.asarray(_dot(lever, log_y) / np.where(spread > (4 * _EPS) ** 2 * total, spread, np.nan))


def _dot(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.vecdot(left, right))
