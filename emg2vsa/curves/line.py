"""Weighted straight lines y = intercept + slope x, many at once: least squares in closed form, and Huber's robust line;
and the rows of points, x and y with weights, that such fits take.

Each row is shifted by one of its own points (exact) and then centred (two passes), so that neither a large offset nor a
tiny or huge scale costs digits: the best and the fastest of the ways compared in docs/benchmarks/fits.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of, uniform, unmasked
from emg2vsa.errors import DataError

SAFE = 1e-200  # sums of squares outside 1e-200 to 1e200 are taken again, scaled
TUNING = 1.345
"""95 % of least squares' efficiency under normal errors (Huber 1981)."""
_MAD_OF_NORMAL = 0.6744897501960817
_ROUNDS = 100
_SETTLED = 1e-10
_IN_UNIT_OF_Y = ("intercept", "slope", "intercept_se", "slope_se")


class Line(NamedTuple):
    """k lines; every field (k,), NaN where undefined (too few points, one abscissa only)."""

    intercept: Floats
    slope: Floats
    intercept_se: Floats
    slope_se: Floats
    r2: Floats
    adj_r2: Floats
    n: NDArray[np.int64]
    dof: NDArray[np.int64]

    def at(self, x: Floats) -> Floats:
        """Fitted y (k, p) at x (p,) or (k, p)."""
        return self.intercept[:, None] + self.slope[:, None] * x


def fit_line(x: Floats, y: Floats, weights: Floats | None = None) -> Line:
    """Least squares of y on x, row by row.

    x, y : (k, p), finite, p >= 1. weights : (k, p), >= 0; zero leaves a point out. None: all points, alike.
    Only ratios of weights matter (the largest of a row should be near 1): the variance of a point is taken as
    s^2 / weight with s^2 from the residuals.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        line, syy = _fit(x, y, weights)
        if np.all((syy > SAFE) & (syy < 1 / SAFE)):
            return line
        unit = exponent_of(y)
        scaled, _ = _fit(x, np.ldexp(y, -unit), weights)
        return scaled._replace(**{f: np.ldexp(getattr(scaled, f), unit[:, 0]) for f in _IN_UNIT_OF_Y})


def join(lines: Sequence[Line]) -> Line:
    """Lines one after the other; at least one ``Line``."""
    if len(lines) == 1:
        return lines[0]
    return Line(*map(np.concatenate, zip(*lines, strict=True)))


def _fit(x: Floats, y: Floats, weights: Floats | None) -> tuple[Line, Floats]:
    """The lines, and the sums of squares of y (k,)."""
    n = np.full(len(y), y.shape[1]) if weights is None else np.count_nonzero(weights, axis=1)
    total = n.astype(np.float64) if weights is None else np.sum(weights, axis=1)
    first = None if weights is None else np.argmax(weights > 0, axis=1)
    x_centre, dx = _centred(x, weights, total, first)
    y_centre, dy = _centred(y, weights, total, first)
    weighted_dx = dx if weights is None else weights * dx
    sxx, syy = _dot(weighted_dx, dx), _sum_of_squares(dy, weights)
    slope = _dot(weighted_dx, dy) / np.where(sxx > 0, sxx, np.nan)
    dx *= slope[:, None]
    dy -= dx
    sse = _sum_of_squares(dy, weights)
    dof = np.maximum(n - 2, 0)
    error = np.sqrt(np.where(dof > 0, sse / dof, np.nan))
    unexplained = sse / syy
    line = Line(
        intercept=y_centre - slope * x_centre,
        slope=slope,
        intercept_se=error * np.sqrt(1 / total + x_centre * x_centre / sxx),
        slope_se=error / np.sqrt(sxx),
        r2=1 - unexplained,
        adj_r2=np.where(dof > 0, 1 - unexplained * (n - 1) / dof, np.nan),
        n=n,
        dof=dof,
    )
    return line, syy


def line_of_sums(p: int, x_mean: Floats, y_mean: Floats, sxx: Floats, slope: Floats, syy: Floats, sse: Floats) -> Line:
    """Lines through p > 2 points a row that count alike and differ in x, by means (d,), sums about them (d,), slopes
    (d,) and sums of residuals (d,). Rows on common x may have one mean and one sum about it."""
    slope_se, unexplained = np.sqrt(sse / ((p - 2) * sxx)), sse / syy
    return Line(
        intercept=y_mean - slope * x_mean,
        slope=slope,
        intercept_se=slope_se * np.sqrt(sxx / p + x_mean * x_mean),
        slope_se=slope_se,
        r2=1 - unexplained,
        adj_r2=1 - unexplained * ((p - 1) / (p - 2)),
        n=uniform(slope.shape, p),
        dof=uniform(slope.shape, p - 2),
    )


def _centred(values: Floats, weights: Floats | None, total: Floats, first: Ints | None) -> tuple[Floats, Floats]:
    """Mean (k,), and values minus mean (k, p), both through differences from the row's ``first`` used value."""
    origin = values[:, 0] if first is None else values[np.arange(len(values)), first]
    shifted = values - origin[:, None]
    mean = (np.sum(shifted, axis=1) if weights is None else _dot(weights, shifted)) / total
    shifted -= mean[:, None]
    return origin + mean, shifted


def _sum_of_squares(values: Floats, weights: Floats | None) -> Floats:
    """Sum (k,) of (weighted) squares along each row."""
    return _dot(values if weights is None else weights * values, values)


def _dot(left: Floats, right: Floats) -> Floats:
    # beyond 10 000 points BLAS may share a row among threads, whose number would show in the last bit
    dot = np.vecdot(left, right) if left.shape[1] <= 10_000 else np.einsum("kp,kp->k", left, right)
    return np.asarray(dot)


def fit_line_huber(x: Floats, y: Floats, weights: Floats) -> Line:
    """Iteratively reweighted least squares, scale from the median absolute residual. x, y, weights : (d, n), as in
    ``fit_line``.

    Standard errors are Huber's H1 (Huber and Ronchetti 2009, 7.6), as in R's MASS::rlm and statsmodels' RLM; R^2 is
    that of the final weighted fit.
    """
    used = weights > 0
    root = np.sqrt(weights)
    line = fit_line(x, y, weights)
    huber = np.ones_like(y)
    scaled = np.zeros_like(y)
    for _ in range(_ROUNDS):
        scaled = _scaled_residuals(line, x, y, root, used)
        with np.errstate(divide="ignore"):
            renewed = np.minimum(1.0, TUNING / np.abs(scaled))
        change = np.max(np.abs(renewed - huber), initial=0.0)
        huber = renewed
        line = fit_line(x, y, weights * huber)
        if change < _SETTLED:
            break
    return _with_h1_errors(line, x, y, root, used)


def _scaled_residuals(line: Line, x: Floats, y: Floats, root: Floats, used: np.ndarray) -> Floats:
    residual = _residuals(line, x, y, root)
    return residual / _scale(residual, y, used)


def _residuals(line: Line, x: Floats, y: Floats, root: Floats) -> Floats:
    intercept, slope = np.nan_to_num(line.intercept), np.nan_to_num(line.slope)
    return root * (y - (intercept[:, None] + slope[:, None] * x))


def _scale(residual: Floats, y: Floats, used: np.ndarray) -> Floats:
    """Median absolute residual over its value for the standard normal, (k, 1); never below the rounding of y."""
    n = np.count_nonzero(used, axis=1, keepdims=True)
    ordered = np.sort(np.where(used, np.abs(residual), np.inf), axis=1)
    low = np.take_along_axis(ordered, np.maximum((n - 1) // 2, 0), axis=1)
    high = np.take_along_axis(ordered, np.minimum(n // 2, y.shape[1] - 1), axis=1)
    rounding = 4 * np.finfo(np.float64).eps * np.max(np.abs(y), axis=1, keepdims=True, initial=0.0, where=used)
    floor = np.maximum(rounding, np.finfo(np.float64).tiny)
    return np.asarray(np.maximum(np.where(n > 0, 0.5 * low + 0.5 * high, 0.0) / _MAD_OF_NORMAL, floor))


def _with_h1_errors(line: Line, x: Floats, y: Floats, root: Floats, used: np.ndarray) -> Line:
    """``line`` with the H1 standard errors, which rest on the design of the points, not on the final weights."""
    residual = _residuals(line, x, y, root)
    scale = _scale(residual, y, used)
    scaled = residual / scale
    n = line.n.astype(np.float64)
    inside = used & (np.abs(scaled) <= TUNING)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.count_nonzero(inside, axis=1) / n  # mean of psi'
        correction = 1 + 2 / n * (1 - share) / share
        psi2 = np.sum(np.clip(scaled, -TUNING, TUNING) ** 2, axis=1, where=used)
        s = correction * scale[:, 0] * np.sqrt(psi2 / np.where(line.dof > 0, line.dof, np.nan)) / share
        w = root * root
        total = np.sum(w, axis=1)
        centre = np.sum(w * x, axis=1) / total
        sxx = np.sum(w * (x - centre[:, None]) ** 2, axis=1)
        intercept_se = s * np.sqrt(1 / total + centre**2 / sxx) + 0 * line.slope
        slope_se = s / np.sqrt(sxx) + 0 * line.slope
    return line._replace(intercept_se=intercept_se, slope_se=slope_se)


@dataclass(frozen=True)
class WeightedRows:
    """x, y, w : (d, n), finite, w between 0 and 1 and 0 where a point does not count (x = x_centre, y = 0 there).
    x and y may be the caller's own.

    x_centre : (d,) the weighted mean of x, to its rounding. n : (d,) points that count. dof : n - 2, not below 0.
    """

    x: Floats
    y: Floats
    w: Floats
    x_centre: Floats
    n: Ints

    @property
    def dof(self) -> Ints:
        """(d,) degrees of freedom of a line."""
        return np.maximum(self.n - 2, 0)

    def explained_by(self, fitted: Floats) -> tuple[Floats, Floats]:
        """R^2 (d,) = 1 - SSE / SST of ``fitted`` (d, n) about the mean of y, and adjusted for two parameters."""
        unit = exponent_of(self.y)
        y = np.ldexp(self.y, -unit)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            residual = y - np.ldexp(fitted, -unit)
            shifted = y - y[np.arange(len(y)), np.argmax(self.w > 0, axis=1)][:, None]
            shifted -= (np.vecdot(self.w, shifted) / np.sum(self.w, axis=1))[:, None]
            total = np.vecdot(self.w * shifted, shifted)
            left = np.vecdot(self.w * residual, residual) / np.where(total > 0, total, np.nan)
            return 1 - left, 1 - left * (self.n - 1) / np.where(self.dof > 0, self.dof, np.nan)


def weighted_rows(x: ArrayLike, y: ArrayLike, weights: ArrayLike | None, where: str) -> WeightedRows:
    """Broadcast and checked: y (n,) or (d, n); x and weights (n,) or (d, n). DataError for other shapes."""
    y_rows = np.atleast_2d(np.asarray(unmasked(y), dtype=np.float64))
    x_rows = np.asarray(unmasked(x), dtype=np.float64)
    w_rows = None if weights is None else np.asarray(weights, dtype=np.float64)
    check_rows(x_rows, y_rows, w_rows, where)
    if y_rows.shape[1] == 0:
        y_rows, x_rows, w_rows = np.full((len(y_rows), 1), np.nan), np.full(1, np.nan), None
    x_rows = np.broadcast_to(x_rows, y_rows.shape)
    used = np.isfinite(x_rows) & np.isfinite(y_rows)
    if w_rows is None:
        w = used.astype(np.float64)
    else:
        used &= (w_rows > 0) & np.isfinite(w_rows)
        w = np.where(used, w_rows, 0.0)
        w /= np.max(w, axis=1, keepdims=True, initial=np.finfo(np.float64).tiny)
    gaps = not used.all()
    if gaps:
        x_rows, y_rows = np.where(used, x_rows, 0.0), np.where(used, y_rows, 0.0)
    unit = exponent_of(x_rows)
    scaled = np.ldexp(x_rows, -unit)  # the sum of many huge x must not overflow
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = np.nan_to_num(np.ldexp(np.vecdot(w, scaled) / np.sum(w, axis=1), unit[:, 0]))
    if gaps:
        x_rows = np.where(used, x_rows, centre[:, None])
    return WeightedRows(x_rows, y_rows, w, centre, np.count_nonzero(used, axis=1))


def check_rows(x: Floats, y: Floats, weights: Floats | None, where: str) -> None:
    """DataError, at ``where``, unless y is (d, n), and x and weights are (n,) or (d, n)."""
    if y.ndim != 2:
        raise DataError(where, wanted="y of shape (designs, points)", found=str(y.shape), do="Pass one row per design.")
    for name, array in (("x", x), ("weights", weights)):
        if array is not None and array.shape not in (y.shape, y.shape[1:]):
            raise DataError(
                where,
                wanted=f"{name} of shape {y.shape} or {y.shape[1:]}",
                found=str(array.shape),
                do="Pad the rows to one length.",
            )
