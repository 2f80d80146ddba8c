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
_LEFT = 1e-14  # of q after a step, by how steps have shrunk; the step of the last curve takes it away
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
    torque = np.multiply(lever, arm, out=arm)
    gauss_newton = p * _dot(torque, u)
    residual = np.subtract(y, np.multiply(p[:, None], u, out=u), out=u)
    newton = gauss_newton - _dot(torque, residual)
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
    """q (d,) of least squares from ``start``, NaN where there is no start or the search does not end; |z| <= 1.

    A q may be off by 1e-14; the step of its curve takes that away.
    """
    q = np.full_like(start, np.nan)
    active = np.flatnonzero(np.isfinite(start))
    if active.size < start.size:
        z, y, w = z[active], y[active], w[active]
    here, before = start[active], np.zeros(active.size)
    size = _dot(w * y, y)
    now = projected(here, z, y, w)
    best, step = now.sse, np.clip(now.step, -_LONGEST_STEP, _LONGEST_STEP)
    for _ in range(_MAX_ITERATIONS):
        length, unit = np.abs(step), np.maximum(1.0, np.abs(here))
        last = (length <= _LAST_STEP * unit) | ((length / before) ** 2 * length <= _LEFT * unit)
        if np.any(last):
            q[active[last]] = (here + step)[last]
            left = np.flatnonzero(~last)
            active, z, y, w = active[left], z[left], y[left], w[left]
            here, best, step, size, length = here[left], best[left], step[left], size[left], length[left]
        if active.size == 0:
            break
        there = projected(here + step, z, y, w)
        better = there.sse <= best + _rounding(best, size)
        here = np.where(better, here + step, here)
        best = np.where(better, there.sse, best)
        step = np.where(better, np.clip(there.step, -_LONGEST_STEP, _LONGEST_STEP), step / 2)
        before = length
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

    The largest |y| of a row is 1/2 to 1. NaN where those points do not lie at two z at least.
    """
    size = np.abs(y)
    weight = w * y
    weight *= size
    weight *= np.where(np.sum(weight, axis=1) < 0, -1.0, 1.0)[:, None]
    np.maximum(weight, 0.0, out=weight)
    log_y = np.log(np.where(weight > 0, size, 1.0))
    total = np.sum(weight, axis=1)
    arm = z - (_dot(weight, z) / total)[:, None]
    lever = np.multiply(weight, arm, out=weight)
    spread = _dot(lever, arm)
    return np.asarray(_dot(lever, log_y) / np.where(spread > (4 * _EPS) ** 2 * total, spread, np.nan))


def _dot(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.vecdot(left, right))
