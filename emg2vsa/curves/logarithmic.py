"""The logarithmic law of co-contraction, v = a + b ln F (equation 6), fitted to many trials in one call."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from casr.counts import count
from emg2vsa.arrays import Floats, uniform, unmasked
from emg2vsa.curves.line import SAFE, Line, check_rows, fit_line, fit_line_huber, join, line_of_sums

LEVEL_FLOOR = 0.1
"""Smallest fitted level that sets a weight, as a share of the trial's largest: no weight exceeds 100 times another."""

NARROW = 1e-3
"""A fit whose forces differ by a smaller share of themselves says how many digits are left."""

_SUMMED_AT_ONCE, _FITTED_AT_ONCE = 24_000, 8_000  # points: two tables, or a dozen, together in a cache of a megabyte
_MIDDLE = 1.0  # ln F of presses, which lie between .5 and 7 N, less this is about zero
_NEAR = 3.0  # sum of squares of that over the one about its mean, above which their difference would lose digits
_FAR = 1e8  # square of a mean over the sum of squares about it, above which centring by the rounded mean loses digits
_CLOSE = 0.1  # residual squares below this share of those of v are summed one by one: a difference would lose digits


@dataclass(frozen=True)
class LogFit:
    """k fits of v = a + b ln F; every field (k,). Natural logarithm, F in newtons, a and b in the unit of v.

    a_se, b_se : standard errors. b_lo, b_hi : Student-t interval of b. n : points used.
    Undefined numbers are NaN: everything below two points, errors and adjusted R^2 at two, R^2 of a constant v.
    """

    a: Floats
    b: Floats
    a_se: Floats
    b_se: Floats
    b_lo: Floats
    b_hi: Floats
    r2: Floats
    adj_r2: Floats
    n: NDArray[np.int64]

    def at(self, force_n: ArrayLike) -> Floats:
        """Fitted v (k, p) at forces (p,) or (k, p), newtons."""
        return self.a[:, None] + self.b[:, None] * np.log(np.atleast_2d(np.asarray(force_n, dtype=np.float64)))


def fit_log(force_n: ArrayLike, v: ArrayLike, robust: bool = False, confidence: float = 0.95) -> LogFit:
    """Fit v = a + b ln F to each row.

    force_n : (p,) for a common grid, or (k, p), newtons. v : (p,) or (k, p).
    Rows of different length are padded: a point counts only where F > 0 and F and v are finite
    and not masked.
    robust : Huber weights. DataError where the shapes do not fit.
    """
    v = np.asarray(unmasked(v), dtype=np.float64)
    v = v if v.ndim == 2 else np.atleast_2d(v)
    force = np.asarray(unmasked(force_n), dtype=np.float64)
    check_rows(force, v, None, "logarithmic fit, force_n and v")
    return _log_fit(_in_blocks(force, v, robust=True) if robust else _lines(force, v), confidence)


def _lines(force: Floats, v: Floats) -> Line:
    """Lines through (ln F, v): by plain sums where these keep their digits, and with care where they do not."""
    k, p = v.shape
    if not k or not 3 <= p <= 10_000:  # of longer rows BLAS shares one among threads, and its last bit shows it
        return _in_blocks(force, v)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        line, sound = _of_sums(p, *_sums(force, v))
    if np.count_nonzero(sound) == k:
        return line
    rest = np.flatnonzero(~sound)
    careful = _in_blocks(force if force.ndim == 1 else force[rest], v[rest])
    if rest.size == k:
        return careful
    for plain, found in zip(line, careful, strict=True):
        plain[rest] = found
    return line


def _sums(force: Floats, v: Floats) -> tuple[Floats, ...]:
    """Of rows (k,): means of v, sums of v about its mean times x = ln F - 1 and times itself; means of x, sums of x^2.
    Rows on common forces have one mean and one sum of x^2."""
    weights, common, parts = uniform(v.shape[1], 1 / v.shape[1]), force.ndim == 1, []
    x = np.log(force) - _MIDDLE if common else force
    for cut in _blocks(v, _SUMMED_AT_ONCE):
        if not common:
            x = np.log(force[cut], order="C")  # as sums of columns would end in another last bit
            x -= _MIDDLE
        rows = v[cut]
        mean_v = np.vecdot(rows, weights)
        dv = np.subtract(rows, mean_v[:, None], order="C")
        of_rows = mean_v, np.vecdot(x, dv), np.vecdot(dv, dv)
        parts.append(of_rows if common else (*of_rows, np.vecdot(x, weights), np.vecdot(x, x)))
    sums = parts[0] if len(parts) == 1 else tuple(map(np.concatenate, zip(*parts, strict=True)))
    return (*sums, np.vecdot(x, weights), np.vecdot(x, x)) if common else sums


def _of_sums(
    p: int, mean_v: Floats, xv: Floats, vv: Floats, mean_x: Floats, xx: Floats
) -> tuple[Line, NDArray[np.bool_]]:
    """Lines through rows of p points, and which of them kept their digits: none with a point that does not count."""
    sxx = xx - p * mean_x * mean_x
    slope = xv / sxx
    sse = vv - xv * slope
    # sums that are no numbers, or beyond the range of a double, fail here, too
    sound = (xx < _NEAR * sxx) & (mean_v * mean_v < _FAR * vv) & (sse > _CLOSE * vv + SAFE)
    return line_of_sums(p, mean_x + _MIDDLE, mean_v, sxx, slope, vv, sse), sound


def _blocks(v: Floats, points: int) -> list[slice]:
    rows = max(1, points // max(1, v.shape[1]))
    return [slice(i, i + rows) for i in range(0, max(len(v), 1), rows)]


def _log_fit(line: Line, confidence: float) -> LogFit:
    count("fits", line.slope.size)
    reach = _t_quantile(line.dof, confidence) * line.slope_se
    return LogFit(
        a=line.intercept,
        b=line.slope,
        a_se=line.intercept_se,
        b_se=line.slope_se,
        b_lo=line.slope - reach,
        b_hi=line.slope + reach,
        r2=line.r2,
        adj_r2=line.adj_r2,
        n=line.n,
    )


def _in_blocks(force: Floats, v: Floats, robust: bool = False) -> Line:
    """The lines through (ln F, v), block by block; points that do not count get weight 0."""
    with np.errstate(divide="ignore", invalid="ignore"):
        parts = [(np.log(force if force.ndim == 1 else force[cut]), v[cut]) for cut in _blocks(v, _FITTED_AT_ONCE)]
    return join([_fit_points(x, y, None, robust) for x, y in parts])


def _fit_points(x: Floats, v: Floats, weights: Floats | None, robust: bool) -> Line:
    if v.shape[1] == 0:
        x = v = np.full((len(v), 1), np.nan)
        weights = None
    valid = np.isfinite(x) & np.isfinite(v)
    if weights is None and not robust and np.all(valid):
        return fit_line(np.broadcast_to(x, v.shape), v)
    w = np.float64(1) if weights is None else weights
    valid &= (w > 0) & np.isfinite(w)
    w = np.where(valid, w, 0.0)
    w /= np.max(w, axis=1, keepdims=True, initial=np.finfo(np.float64).tiny)
    x, v = np.where(valid, x, 0.0), np.where(valid, v, 0.0)
    return fit_line_huber(x, v, w) if robust else fit_line(x, v, w)


def fit_log_by_level(
    force_n: Floats, v: Floats, counts: Floats, robust: bool = False, confidence: float = 0.95
) -> tuple[LogFit, Floats]:
    """Fit with inverse-variance weights, counts over the square of the fitted level; also returns the weights (k, p).

    force_n, v : (k, p), NaN where there is no point; counts : (k, p) samples behind each, 0 there. The level comes from
    a fit by counts alone, and once more from the fit weighted so: after one round b is .15 % too small, after two the
    bias is that of the true weights.
    The law is equation (6) of the paper.
    """
    x, weights = np.log(force_n), counts
    line = _fit_points(x, v, counts, robust)
    for _ in range(2):
        weights = counts * level_weights(line.at(x))
        line = _fit_points(x, v, weights, robust)
    return _log_fit(line, confidence), weights


def fit_log_weighted(
    force_n: Floats, v: Floats, weights: Floats, robust: bool = False, confidence: float = 0.95
) -> LogFit:
    """Fit (equation 6) with the weights (k, p) that are given; force_n, v : (k, p), N and V, NaN where there is no
    point."""
    return _log_fit(_fit_points(np.log(force_n), v, weights, robust), confidence)


def widen(fit: LogFit, a_factor: Floats, b_factor: Floats, dof: Floats, confidence: float) -> LogFit:
    """``fit`` with its standard errors multiplied by factors (k,), and the interval of Student's t at ``dof`` (k,)."""
    reach = _t_quantile(dof, confidence) * fit.b_se * b_factor
    return dataclasses.replace(
        fit,
        a_se=fit.a_se * a_factor,
        b_se=fit.b_se * b_factor,
        b_lo=fit.b - reach,
        b_hi=fit.b + reach,
    )


def level_weights(level: Floats) -> Floats:
    """Inverse-variance weights 1 / v^2 (k, p) from fitted levels, relative to the smallest: an envelope's noise grows
    with its level (SD of b 7.5 % to 6.0 % of b in simulation, benchmarks/slope_of_b.py).

    A fitted level below ``LEVEL_FLOOR`` of the row's largest, or negative, counts as that floor. Rows whose fit is
    undefined or nowhere positive get equal weights.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        top = np.max(level, axis=1, keepdims=True, initial=0.0, where=np.isfinite(level))
        weights = (top / np.maximum(level, LEVEL_FLOOR * top)) ** 2
    return np.where(np.isfinite(weights) & (top > 0), weights, 1.0)


def said_of_forces(force_n: Floats) -> list[str]:
    """For each fit on the forces (k, p), N, NaN where there is none, why its slope is ill-conditioned, or "".

    b rests on differences of ln F: forces within a share e of each other leave 16 + log10(e) digits of a double.
    """
    inside = np.isfinite(force_n) & (np.asarray(force_n) > 0)
    highest = np.max(force_n, axis=1, initial=0.0, where=inside)
    lowest = np.min(force_n, axis=1, initial=np.inf, where=inside)
    narrow = (lowest < highest) & (highest < lowest * (1 + NARROW))
    said = [""] * len(highest)
    for i in np.flatnonzero(narrow).tolist():
        change = highest[i] / lowest[i] - 1
        digits = max(0.0, 16 + np.log10(max(change, 1e-16)))
        said[i] = f"ill-conditioned fit: force changes by {change:.1g} of itself, b keeps {digits:.0f} digits"
    return said


def _t_quantile(dof: NDArray[np.int64] | Floats, confidence: float) -> Floats | float:
    """Student t (k,), or one for all, of a two-sided interval; NaN where dof is 0."""
    first = dof.item(0) if dof.size else 0
    if first > 0 and np.count_nonzero(dof == first) == dof.size:
        return float(special.stdtrit(first, 0.5 + 0.5 * confidence))
    distinct, where = np.unique(dof, return_inverse=True)
    quantile = special.stdtrit(np.where(distinct > 0, distinct, np.nan), 0.5 + 0.5 * confidence)
    return np.asarray(quantile, dtype=np.float64)[where]
