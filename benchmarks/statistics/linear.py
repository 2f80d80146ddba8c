"""Linear regression on any columns, many designs at once, in extended precision.

Nothing is dropped silently: pseudo-inverses with a cut-off lose all digits on NIST's Filip set (docs/benchmarks).
What the input has lost cannot come back: powers rounded to doubles leave 7.6 digits of Filip, whatever is done next;
``powers`` keeps them (11 digits).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints
from emg2vsa.curves.nonlinear import solve
from emg2vsa.errors import DataError


@dataclass(frozen=True)
class LinearFit:
    """d regressions; (d,) unless said, NaN where X has not full rank or there are too few points.

    coefficients, se : (d, p), the intercept first. covariance : (d, p, p). s : residual SD. r2 : about the mean of y
    with an intercept, about zero without. adj_r2 : adjusted for the coefficients.
    """

    coefficients: Floats
    se: Floats
    covariance: Floats
    s: Floats
    r2: Floats
    adj_r2: Floats
    n: Ints
    dof: Ints

    def notes(self, i: int = 0) -> tuple[str, ...]:
        if np.isnan(self.coefficients[i, 0]):
            few = self.n[i] < self.coefficients.shape[1]
            return (f"undefined: {self.n[i]} points" if few else "undefined: one column is a sum of the others",)
        return ("as many coefficients as points: no errors",) if self.dof[i] < 1 else ()


def powers(x: ArrayLike, degree: int) -> NDArray[Any]:
    """x, x^2, ..., x^degree as columns (..., n, degree) in extended precision; x : (..., n) numbers or decimal text."""
    return np.asarray(x).astype(np.longdouble)[..., None] ** np.arange(1, degree + 1)


def fit_linear(x: ArrayLike, y: ArrayLike, *, intercept: bool = True) -> LinearFit:
    """Least squares of y on the columns of x.

    x : (n, p) common to all, or (d, n, p); y : (n,) or (d, n). Points with NaN anywhere are left out. Extended
    precision of x or y (``numpy.longdouble``) is used. DataError where the shapes do not fit.
    """
    columns, values, rounding = _checked(x, y)
    used = np.isfinite(values) & np.all(np.isfinite(columns), axis=2)
    if intercept:
        columns = np.concatenate([np.ones((*columns.shape[:2], 1), columns.dtype), columns], axis=2)
    p, n = columns.shape[2], np.count_nonzero(used, axis=1)
    # rows of zeros say nothing, and there must be p rows to reflect
    columns = np.pad(np.where(used[:, :, None], columns, 0), ((0, 0), (0, p), (0, 0)))
    values = np.pad(np.where(used, values, 0), ((0, 0), (0, p)))
    unit = np.frexp(np.max(np.abs(values), axis=1, keepdims=True, initial=0))[1]
    values = np.ldexp(values, -unit)
    solution = solve(columns, values)
    blank = np.where((n >= p) & np.all(solution.pivots > 4 * rounding, axis=1), 0.0, np.nan)
    dof = np.maximum(n - p, 0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        variance = solution.rss / np.where(dof > 0, dof, np.nan) + blank
        root = solution.root * np.sqrt(variance)[:, None, None]
        left = solution.rss / _total(values, used, intercept) + blank
        covariance = np.ldexp(np.sum(root[:, :, None] * root[:, None], axis=3), 2 * unit[:, :, None])
        return LinearFit(
            coefficients=_double(np.ldexp(solution.coefficients, unit) + blank[:, None]),
            se=_double(np.ldexp(np.sqrt(np.sum(root**2, axis=2)), unit)),
            covariance=_double(covariance),
            s=_double(np.ldexp(np.sqrt(variance), unit[:, 0])),
            r2=_double(1 - left),
            adj_r2=_double(1 - left * (n - intercept) / np.where(dof > 0, dof, np.nan)),
            n=n,
            dof=dof,
        )


def _checked(x: ArrayLike, y: ArrayLike) -> tuple[NDArray[Any], NDArray[Any], float]:
    """Columns (d, n, p) and values (d, n) in extended precision, and the rounding that the columns came with."""
    columns, values = np.asarray(x), np.atleast_2d(np.asarray(y))
    rounding = float(np.finfo(columns.dtype if columns.dtype == np.longdouble else np.float64).eps)
    if values.ndim != 2 or columns.shape[-2:-1] != values.shape[1:] or columns.ndim not in (2, 3):
        found = f"{columns.shape} and {values.shape}"
        wanted = "x (points, columns) or (designs, points, columns) and y (designs, points)"
        raise DataError("linear regression", wanted=wanted, found=found, do="Pass one row per point.")
    if columns.ndim == 3 and len(columns) != len(values):
        found = f"{len(columns)} and {len(values)}"
        raise DataError("linear regression", wanted="as many designs in x as in y", found=found, do="Pass both.")
    columns = np.broadcast_to(columns, (len(values), *columns.shape[-2:])).astype(np.longdouble)
    return columns, values.astype(np.longdouble), rounding


def _total(values: NDArray[Any], used: NDArray[np.bool_], centred: bool) -> NDArray[Any]:
    """Sum of squares (d,) of the values, about their mean if ``centred``; NaN if zero."""
    values = values[:, : used.shape[1]]
    if centred:
        values = values - np.sum(values, axis=1, keepdims=True) / np.count_nonzero(used, axis=1)[:, None]
    total = np.sum(values**2, axis=1, where=used)
    return np.asarray(np.where(total > 0, total, np.nan))


def _double(values: NDArray[Any]) -> Floats:
    return np.asarray(values, dtype=np.float64)
