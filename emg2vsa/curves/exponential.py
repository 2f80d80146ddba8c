"""The exponential law y = p exp(q x), fitted to many designs in one call.

By variable projection: for each q the best p is a quotient of sums, and q alone is searched for. Fewer things can go
wrong than with two parameters, and 13 digits are right where general fitters give 7 to 8 (statistics notes 3c).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.variable_projection import has_minimum, log_linear_start, projected, search
from emg2vsa.curves.weighted_rows import WeightedRows, check_rows, weighted_rows

PROBLEMS = (
    "",
    "undefined: fewer than two points of one sign at different x",
    "undefined: no exponential is nearest, the search for it does not end",
    "undefined: a value that is not positive has no logarithm",
)
_WHERE = "exponential fit"
_POINTS_AT_ONCE = 16_000  # keeps the temporaries of a block inside the processor's cache


@dataclass(frozen=True)
class ExponentialFit:
    """d fits of y = p exp(q x); every field (d,), NaN where undefined.

    p, p_se, y0 : unit of y. q, q_se : 1 / unit of x. pq_cov : covariance of p and q. s : residual SD, in the unit of y,
    or of ln y for the log-linear fit. r2, adj_r2 : of y itself for both (adjusted by (n - 1) / dof, MATLAB's fit).
    x0, y0 : the point of the curve at which level and q are uncorrelated; level_se : standard error of ln y0.
    n : points used; dof : n - 2. problem : index into ``PROBLEMS``, 0 where the fit is defined.
    """

    method: str
    p: Floats
    q: Floats
    p_se: Floats
    q_se: Floats
    pq_cov: Floats
    s: Floats
    r2: Floats
    adj_r2: Floats
    n: Ints
    dof: Ints
    x0: Floats
    y0: Floats
    level_se: Floats
    problem: Ints

    def at(self, x: ArrayLike) -> Floats:
        """Fitted y (d, m) at x (m,) or (d, m)."""
        with np.errstate(over="ignore"):
            return np.asarray(self.y0[:, None] * np.exp(self.q[:, None] * (_columns(x) - self.x0[:, None])))

    def se_at(self, x: ArrayLike) -> Floats:
        """Standard error (d, m) of the fitted y at x (m,) or (d, m): delta method."""
        distance = _columns(x) - self.x0[:, None]
        return np.asarray(np.abs(self.at(x)) * np.hypot(self.level_se[:, None], distance * self.q_se[:, None]))

    def notes(self, i: int = 0) -> tuple[str, ...]:
        """What must be known to read fit ``i``."""
        if self.problem[i]:
            return (PROBLEMS[self.problem[i]],)
        if self.dof[i] < 1:
            return ("two points determine the curve: no errors",)
        return ()


def fit_exponential(x: ArrayLike, y: ArrayLike, weights: ArrayLike | None = None) -> ExponentialFit:
    """Least squares of y itself.

    x : (n,) common to all, or (d, n). y : (n,) or (d, n), of either sign. weights : as y, >= 0, relative; zero, or NaN
    in x or y, leaves a point out. DataError where the shapes do not fit.
    """
    x, y = np.asarray(x, dtype=np.float64), np.atleast_2d(np.asarray(y, dtype=np.float64))
    w = None if weights is None else np.asarray(weights, dtype=np.float64)
    check_rows(x, y, w, _WHERE)
    size = max(1, _POINTS_AT_ONCE // max(1, y.shape[1]))
    cuts = [slice(i, i + size) for i in range(0, max(len(y), 1), size)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        blocks = (weighted_rows(_cut(x, cut), y[cut], None if w is None else _cut(w, cut), _WHERE) for cut in cuts)
        return _join([_least_squares(rows) for rows in blocks])


def _cut(values: Floats, rows: slice) -> Floats:
    return values if values.ndim == 1 else values[rows]


def _least_squares(rows: WeightedRows) -> ExponentialFit:
    """One block of rows, in units that make every |z| and |y| at most 1."""
    z = rows.x - rows.x_centre[:, None]
    unit_x, unit_y = exponent_of(z), exponent_of(rows.y)
    z, y = np.ldexp(z, -unit_x), np.ldexp(rows.y, -unit_y)
    unit_x, unit_y = unit_x[:, 0], unit_y[:, 0]
    start = log_linear_start(z, y, rows.w)
    q = search(z, y, rows.w, start)
    curve = projected(q, z, y, rows.w)
    q = np.where(has_minimum(q, z, y, rows.w, curve), q, np.nan)
    s = np.sqrt(curve.sse / np.where(rows.dof > 0, rows.dof, np.nan)) + 0 * q
    return _assembled(
        "nonlinear least squares (variable projection)",
        rows,
        x0=rows.x_centre + np.ldexp(curve.centre + 0 * q, unit_x),
        y0=np.ldexp(curve.level + 0 * q, unit_y),
        q=np.ldexp(q, -unit_x),
        s=np.ldexp(s, unit_y),
        level_se=s / np.sqrt(curve.level_information),
        q_se=np.ldexp(s / np.sqrt(curve.slope_information), -unit_x),
        problem=np.where(np.isnan(start), 1, np.where(np.isnan(q), 2, 0)),
    )


def fit_exponential_log(x: ArrayLike, y: ArrayLike, weights: ArrayLike | None = None) -> ExponentialFit:
    """Least squares of ln y, a straight line: relative errors count alike. Arguments as in ``fit_exponential``.

    A row in which any value that counts is zero or negative is undefined.
    """
    rows = weighted_rows(x, y, weights, _WHERE)
    used = rows.w > 0
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        log_y = np.log(np.where(used, rows.y, 1.0))
        negative = np.any(np.isnan(log_y) | np.isinf(log_y), axis=1)
        line = fit_line(rows.x - rows.x_centre[:, None], np.where(negative[:, None], 0.0, log_y), rows.w)
        lost = negative | np.isnan(line.slope)
        blank = np.where(lost, np.nan, 0.0)
        total = np.sum(rows.w, axis=1)
        return _assembled(
            "log-linear least squares",
            rows,
            x0=rows.x_centre,
            y0=np.exp(line.intercept + blank),
            q=line.slope + blank,
            s=line.intercept_se * np.sqrt(total) + blank,
            level_se=line.intercept_se + blank,
            q_se=line.slope_se + blank,
            problem=np.where(negative, 3, np.where(lost, 1, 0)),
        )


def _assembled(
    method: str,
    rows: WeightedRows,
    *,
    x0: Floats,
    y0: Floats,
    q: Floats,
    s: Floats,
    level_se: Floats,
    q_se: Floats,
    problem: NDArray[np.int_],
) -> ExponentialFit:
    """The fit as seen at x = 0, and how much of y it explains."""
    p = y0 * np.exp(-q * x0)
    fitted = y0[:, None] * np.exp(q[:, None] * (rows.x - x0[:, None]))
    r2, adj_r2 = rows.explained_by(fitted)
    return ExponentialFit(
        method=method,
        p=p,
        q=q,
        p_se=np.abs(p) * np.hypot(level_se, x0 * q_se),
        q_se=q_se,
        pq_cov=-p * x0 * q_se**2,
        s=s,
        r2=r2,
        adj_r2=adj_r2,
        n=rows.n,
        dof=rows.dof,
        x0=x0,
        y0=y0,
        level_se=level_se,
        problem=np.asarray(problem, dtype=np.int64),
    )


def _join(fits: list[ExponentialFit]) -> ExponentialFit:
    arrays = [f.name for f in dataclasses.fields(ExponentialFit) if f.name != "method"]
    return ExponentialFit(fits[0].method, *(np.concatenate([getattr(fit, name) for fit in fits]) for name in arrays))


def _columns(x: ArrayLike) -> Floats:
    return np.atleast_2d(np.asarray(x, dtype=np.float64))
