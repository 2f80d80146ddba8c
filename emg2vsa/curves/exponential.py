"""The exponential law y = p exp(q x), fitted to many designs in one call.

By variable projection (Golub and Pereyra 1973): for each q the best p is a quotient of sums, and q alone is searched
for, by Newton's method with the exact second derivative from a log-linear start; Gauss-Newton where the sum of squares
is not convex, and half the step where it would grow. Fewer things can go wrong than with two parameters, and 13 digits
are right where general fitters give 7 to 8 (docs/benchmarks/fits.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.counts import count
from emg2vsa.arrays import Floats, aligned, exponent_of, unmasked
from emg2vsa.curves.line import WeightedRows, check_rows, fit_line, weighted_rows

_WHERE = "exponential fit"
_POINTS_AT_ONCE = 24_000  # the powers of a block together in a cache of a megabyte
_MAX_ITERATIONS = 60
_LONGEST_STEP = 2.0  # of q where |z| <= 1: factors of e^2 at the ends of the data
_LAST_STEP = 1e-10  # Newton squares it: what is left is below rounding
_LEFT = 1e-14  # of q after a step, by how steps have shrunk; the step of the last curve takes it away
_FEW, _SHORT, _WIDE = 5, 0.5, 0.1  # of plain rows: steps of q, in standard deviations of x, and how wide a curve stays
_CUBED_AWAY = 3e-6
_MANY = 100
_LEAST = 1e-140  # variances of x between this and its inverse have products that keep their digits
_OF_FIT = np.array([[1.0], [2.0], [4.0]])  # derivatives of cumulants of weights exp(2 q z), which has q twice
_LEAST_CONVEX = 1e-3
_SPIKE = 1e-12  # of the curve's square, what points other than the heaviest carry
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class ExponentialFit:
    """d fits of y = y0 exp(q (x - x0)); every field (d,), NaN where undefined.

    x0, y0 : the point of the curve at which level and q are uncorrelated, in the units of x and y. q : 1 / unit of x.
    """

    x0: Floats
    y0: Floats
    q: Floats


def fit_exponential(x: ArrayLike, y: ArrayLike) -> ExponentialFit:
    """Least squares of y itself.

    x : (n,) common to all, or (d, n). y : (n,) or (d, n), of either sign. NaN in x or y leaves a point out. Undefined
    below two points of one sign at different x, and where no exponential is nearest, so that the search for it does not
    end. DataError where the shapes do not fit.
    """
    x, y = np.asarray(unmasked(x), dtype=np.float64), np.asarray(unmasked(y), dtype=np.float64)
    y = y if y.ndim == 2 else np.atleast_2d(y)
    check_rows(x, y, None, _WHERE)
    size = max(1, _POINTS_AT_ONCE // max(1, y.shape[1]))
    cuts = [slice(i, i + size) for i in range(0, max(len(y), 1), size)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        fits = [_of_block(x if x.ndim == 1 else x[cut], y[cut]) for cut in cuts]
    return ExponentialFit(*(fits[0] if len(fits) == 1 else map(np.concatenate, zip(*fits, strict=True))))


def _of_block(x: Floats, y: Floats) -> tuple[Floats, Floats, Floats]:
    # the last digit of plain rows hangs on the rows beside them: those of few curves, which are told, do not
    plain = _of_plain_rows(x, y) if len(y) >= _MANY else None
    return plain or _least_squares(weighted_rows(x, y, None, _WHERE))


def _of_plain_rows(x: Floats, y: Floats) -> tuple[Floats, Floats, Floats] | None:
    """x0, y0 and q of rows of positive y that lie near an exponential, as those of a bootstrap do; None where any row
    needs the search that follows.

    Where p is best for its q, the sum of squares is least where h = T1 / T0 - S1 / S0 is zero, with Tk and Sk the sums
    of z^k y exp(q z) and of z^k exp(2 q z). Both quotients are first cumulants of z, whose further ones are the
    derivatives of h. A step of Halley cubes the error of q, and few are needed.
    """
    if not y.size:
        return None
    # a column is a row of the data: sums of few points each are made side by side
    y = y[0] if y.strides[0] == 0 and x.ndim == 2 else np.ascontiguousarray(y.T)
    x = np.ascontiguousarray(x.T) if x.ndim == 2 else x[:, None]
    w, log_y = y * y, np.log(y)
    total = w.sum(axis=0)
    mean = _sums(w, x) / total
    n, d = x.shape[0], mean.size
    table = aligned(5 * n + 18, d)
    z, powers, rest = table[:n], table[n : 5 * n].reshape(4, n, d), table[5 * n :].reshape(9, 2, d)
    sums, cumulants, spare = rest[:4], rest[4:7], rest[7:]
    np.subtract(x, mean, out=z)
    wz = np.multiply(w if w.ndim == 2 else w[:, None], z, out=powers[0])
    spread = _sums(wz, z)
    q = _sums(wz, log_y if log_y.ndim == 2 else log_y[:, None]) / spread  # wz sums to zero
    reach = np.sqrt(spread / total)
    least = _WIDE * reach * reach
    if not (least.min() > _LEAST and least.max() < 1 / _LEAST):
        return None
    for _ in range(_FEW):
        np.exp(np.multiply(q, z, out=powers[0]), out=powers[0])
        for k in range(3):
            np.multiply(z, powers[k], out=powers[k + 1])
        if y.ndim == 1:
            np.matmul(y, powers, out=sums[:, 0])
        else:
            np.einsum("ij,kij->kj", y, powers, out=sums[:, 0])
        np.einsum("ij,kij->kj", powers[0], powers, out=sums[:, 1])
        of_y, of_fit = _cumulants(sums, cumulants, spare).swapaxes(0, 1)
        derivatives = spare.reshape(4, d)[:3]  # in the table, as what follows writes over them
        h, slope, bend = np.subtract(of_y, np.multiply(_OF_FIT, of_fit, out=derivatives), out=derivatives)
        bend *= h
        bend *= 0.5
        bend -= slope * slope
        h *= slope
        step = h / bend  # Halley's: 2 h h' / (h h'' - 2 h'^2)
        size = (np.abs(step) * reach).max()
        if not size < _SHORT or np.count_nonzero((slope >= 0) | (of_fit[1] < least)):
            return None
        q += step
        if size < _CUBED_AWAY:
            break
    else:
        return None
    (t1, t2, _), (s1, s2, s3) = of_y, of_fit
    twice = 2 * step
    centre = s1 + s2 * twice + s3 * twice * step
    grown = (t1 - 2 * s1) * step + (t2 / 2 - 2 * s2) * step * step  # of ln p, by the last step
    count("fits", len(q))
    return mean + centre, sums[0, 0] / sums[0, 1] * np.exp(grown + q * centre), q


def _cumulants(sums: Floats, found: Floats, spare: Floats) -> Floats:
    """The first three cumulants of z, in ``found`` (3, ...), of sums (4, ...) of weights times 1, z, z^2, z^3.
    ``spare`` (2, ...) is written over."""
    m1, m2, m3 = np.divide(sums[1:], sums[0], out=found)
    square, skew = spare
    np.multiply(m1, m1, out=square)
    np.multiply(m2, 1.5, out=skew)
    skew -= square
    skew *= m1
    skew *= 2
    m3 -= skew
    m2 -= square
    return found


def _sums(left: Floats, right: Floats) -> Floats:
    """Of products (n, d) down the columns; left may be one column (n,)."""
    return np.asarray(np.einsum("ij,ij->j" if left.ndim == 2 else "i,ij->j", left, right))


def _least_squares(rows: WeightedRows) -> tuple[Floats, Floats, Floats]:
    """x0, y0 and q of one block of rows, in units that make every |z| and |y| at most 1."""
    z = rows.x - rows.x_centre[:, None]
    unit_x, unit_y = exponent_of(z), exponent_of(rows.y)
    z, y = np.ldexp(z, -unit_x), np.ldexp(rows.y, -unit_y)
    unit_x, unit_y = unit_x[:, 0], unit_y[:, 0]
    count("fits", len(y))
    q = _search(z, y, rows.w, _log_linear_start(z, y, rows.w))
    curve = _projected(q, z, y, rows.w)
    q = np.where(_has_minimum(q, z, y, rows.w, curve), q + curve.step, np.nan)
    x0 = rows.x_centre + np.ldexp(curve.centre + 0 * q, unit_x)
    return x0, np.ldexp(curve.level + 0 * q, unit_y), np.ldexp(q, -unit_x)


def fit_exponential_log(x: ArrayLike, y: ArrayLike) -> ExponentialFit:
    """Least squares of ln y, a straight line: relative errors count alike. Arguments as in ``fit_exponential``.

    A row in which any value that counts is zero or negative is undefined.
    """
    rows = weighted_rows(x, y, None, _WHERE)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        log_y = np.log(np.where(rows.w > 0, rows.y, 1.0))
        negative = np.any(np.isnan(log_y) | np.isinf(log_y), axis=1)
        line = fit_line(rows.x - rows.x_centre[:, None], np.where(negative[:, None], 0.0, log_y), rows.w)
        blank = np.where(negative | np.isnan(line.slope), np.nan, 0.0)
        return ExponentialFit(rows.x_centre, np.exp(line.intercept + blank), line.slope + blank)


@dataclass(frozen=True)
class _Projected:
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


def _projected(q: Floats, z: Floats, y: Floats, w: Floats) -> _Projected:
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
    return _Projected(
        level=p * np.exp(q * centre - np.abs(q)),
        centre=centre,
        sse=_dot(np.multiply(w, residual, out=work), residual),
        step=_dot(lever, residual) / curvature,
        level_information=p * p * uu,
        slope_information=p * gauss_newton,
    )


def _search(z: Floats, y: Floats, w: Floats, start: Floats) -> Floats:
    """q (d,) of least squares from ``start``, NaN where there is no start or the search does not end; |z| <= 1.

    A q may be off by 1e-14; the step of its curve takes that away.
    """
    q = np.full_like(start, np.nan)
    active = np.flatnonzero(np.isfinite(start))
    if active.size < start.size:
        z, y, w = z[active], y[active], w[active]
    here, before = start[active], np.zeros(active.size)
    size = _dot(w * y, y)
    now = _projected(here, z, y, w)
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
        there = _projected(here + step, z, y, w)
        better = there.sse <= best + _rounding(best, size)
        here = np.where(better, here + step, here)
        best = np.where(better, there.sse, best)
        step = np.where(better, np.clip(there.step, -_LONGEST_STEP, _LONGEST_STEP), step / 2)
        before = length
    return q


def _has_minimum(q: Floats, z: Floats, y: Floats, w: Floats, curve: _Projected) -> NDArray[np.bool_]:
    """Whether (d,) the sum of squares at ``curve`` grows beyond its q: it does not where the curve has become a spike
    through one point, which a steeper spike fits as well.
    """
    fixed = np.isfinite(q)
    spikes = np.flatnonzero(fixed & (curve.slope_information < _SPIKE * curve.level_information))
    if spikes.size:
        q, z, y, w, sse = q[spikes], z[spikes], y[spikes], w[spikes], curve.sse[spikes]
        steeper = _projected(q + np.sign(q), z, y, w).sse
        fixed[spikes] = steeper > sse + _rounding(sse, _dot(w * y, y))
    return fixed


def _rounding(sse: Floats, size: Floats) -> Floats:
    """Of a sum of squared residuals of values whose squares sum to ``size``."""
    return 16 * _EPS * (np.sqrt(sse * size) + _EPS * size)


def _log_linear_start(z: Floats, y: Floats, w: Floats) -> Floats:
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
