"""The exponential law y = p exp(q x), fitted to many designs in one call by variable projection.

p is eliminated (Golub and Pereyra 1973): for each q the best p is a quotient of sums, and q alone is found by Newton's
method from a log-linear start. Fewer things can go wrong than with two parameters, and 13 digits are right
(statistics notes 3c; general fitters give 7 to 8).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.weighted_rows import WeightedRows, weighted_rows

PROBLEMS = (
    "",
    "undefined: fewer than two points of one sign at different x",
    "undefined: no least-squares exponential, the search for it does not end",
    "undefined: a value that is not positive has no logarithm",
)
_MAX_ITERATIONS = 60
_LONGEST_STEP = 2.0  # of q times half the range of x: factors of e^2 at the ends of the data
_LAST_STEP = 1e-10  # Newton squares it: what is left is below rounding
_EPS = float(np.finfo(np.float64).eps)


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
    rows = weighted_rows(x, y, weights, where="exponential fit")
    unit_x, unit_y = exponent_of(rows.x - rows.x_centre[:, None])[:, 0], exponent_of(rows.y)[:, 0]
    z = np.ldexp(rows.x - rows.x_centre[:, None], -unit_x[:, None])
    y_scaled = np.ldexp(rows.y, -unit_y[:, None])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        start = _log_linear_start(z, y_scaled, rows.w)
        q, ended = _search(z, y_scaled, rows.w, start)
        curve = _Projected.at(q, z, y_scaled, rows.w)
        s = np.sqrt(curve.sse / np.where(rows.dof > 0, rows.dof, np.nan))
        return _assembled(
            "nonlinear least squares (variable projection)",
            rows,
            x0=rows.x_centre + np.ldexp(curve.centre, unit_x),
            y0=np.ldexp(curve.level, unit_y),
            q=np.ldexp(q, -unit_x),
            s=np.ldexp(s, unit_y),
            level_se=s / np.sqrt(curve.level_information),
            q_se=np.ldexp(s / np.sqrt(curve.slope_information), -unit_x),
            problem=np.where(np.isnan(start), 1, np.where(ended & np.isfinite(q), 0, 2)),
        )


def fit_exponential_log(x: ArrayLike, y: ArrayLike, weights: ArrayLike | None = None) -> ExponentialFit:
    """Least squares of ln y, a straight line: relative errors count alike. Arguments as in ``fit_exponential``.

    A row in which any value that counts is zero or negative is undefined.
    """
    rows = weighted_rows(x, y, weights, where="exponential fit")
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


@dataclass(frozen=True)
class _Projected:
    """The sum of squares over q alone, p at its best: value, derivatives and what the errors rest on; (d,)."""

    level: Floats
    centre: Floats
    sse: Floats
    step: Floats
    level_information: Floats
    slope_information: Floats

    @classmethod
    def at(cls, q: Floats, z: Floats, y: Floats, w: Floats) -> _Projected:
        exponent = q[:, None] * z
        top = np.max(exponent, axis=1, keepdims=True)
        u = np.exp(exponent - top)  # no larger than 1
        wu = w * u
        uu = _dot(wu, u)
        p = _dot(wu, y) / uu
        centre = _dot(wu * u, z) / uu
        arm = z - centre[:, None]  # about it, level and slope are orthogonal
        residual = y - p[:, None] * u
        wua = wu * arm
        gradient = _dot(wua, residual)
        gauss_newton = p * _dot(wua, arm * u)
        newton = gauss_newton - _dot(wua, arm * residual)
        curvature = np.where(newton / gauss_newton > 1e-3, newton, gauss_newton)
        return cls(
            level=p * np.exp(q * centre - top[:, 0]),
            centre=centre,
            sse=_dot(w * residual, residual),
            step=gradient / curvature,
            level_information=p * p * uu,
            slope_information=p * gauss_newton,
        )


def _search(z: Floats, y: Floats, w: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """q (d,) of least squares, and whether the search ended; steps that do not lessen the sum of squares are halved."""
    q, ended = start.copy(), np.isnan(start)
    active = np.flatnonzero(~ended)
    z, y, w, here = z[active], y[active], w[active], start[active]
    size = _dot(w * y, y)
    now = _Projected.at(here, z, y, w)
    best, step = now.sse, np.clip(now.step, -_LONGEST_STEP, _LONGEST_STEP)
    for _ in range(_MAX_ITERATIONS):
        last = np.abs(step) <= _LAST_STEP * np.maximum(1.0, np.abs(here))
        q[active] = np.where(last, here + step, here)
        ended[active] = last
        if np.any(last):
            active, here, best, step, size = (values[~last] for values in (active, here, best, step, size))
            z, y, w = z[~last], y[~last], w[~last]
        if active.size == 0:
            break
        there = _Projected.at(here + step, z, y, w)
        better = there.sse <= best + 16 * _EPS * (np.sqrt(best * size) + _EPS * size)  # to the rounding of residuals
        here = np.where(better, here + step, here)
        best = np.where(better, there.sse, best)
        step = np.where(better, np.clip(there.step, -_LONGEST_STEP, _LONGEST_STEP), step / 2)
    q[~ended] = np.nan
    return q, ended


def _log_linear_start(z: Floats, y: Floats, w: Floats) -> Floats:
    """Slope of ln |y| on z over the points of the sign that prevails, weighted by y^2: near the answer at small noise."""
    sign = np.where(_dot(w * y, np.abs(y)) < 0, -1.0, 1.0)
    towards = sign[:, None] * y
    used = (towards > 0) & (w > 0)
    weight = np.where(used, w * towards**2, 0.0)
    log_y = np.log(np.where(used, towards, 1.0))
    return fit_line(z, log_y, weight / np.max(weight, axis=1, keepdims=True, initial=0.0)).slope


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


def _columns(x: ArrayLike) -> Floats:
    return np.atleast_2d(np.asarray(x, dtype=np.float64))


def _dot(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.vecdot(left, right))
