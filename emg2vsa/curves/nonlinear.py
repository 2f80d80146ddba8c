"""General nonlinear least squares, for laws that have no fit of their own.

Trust region with exact Jacobians by the complex step (Squire and Trapp 1998), then Gauss-Newton steps on a scaled QR
until nothing is gained: the certified values of all 27 NIST sets from both starts, where finite differences and default
tolerances fail on six (statistics notes 3c).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from emg2vsa.arrays import Floats
from emg2vsa.curves.qr import solve
from emg2vsa.errors import DataError

Model = Callable[[Floats, NDArray[Any]], NDArray[Any]]
"""y (n,) of x and the parameters (p,), which come as complex numbers too: analytic functions only, no abs or max."""

_IMAGINARY_STEP = 1e-30
_TOLERANCE = 1e-15
_MAX_EVALUATIONS = 20_000
_POLISHING_STEPS = 50
_HUGE = 1e150  # its square is finite
_EPS = float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class NonlinearFit:
    """parameters, se : (p,); covariance (p, p). rss : residual sum of squares; s : residual SD; NaN where undefined."""

    parameters: Floats
    se: Floats
    covariance: Floats
    rss: float
    s: float
    n: int
    dof: int
    notes: tuple[str, ...]


def fit_nonlinear(model: Model, x: ArrayLike, y: ArrayLike, start: ArrayLike) -> NonlinearFit:
    """Least squares of y (n,) on ``model(x, parameters)`` from ``start`` (p,); x : anything the model takes.

    DataError where y or start is not finite, there are fewer points than parameters, or the model is not finite at the
    start. A search that ends nowhere gives NaN and a note; a parameter that the data do not determine, NaN errors.
    """
    x, y, start = (np.asarray(values, dtype=np.float64) for values in (x, y, start))
    residual, jacobian = _functions(model, x, y)
    _check(y, start, residual)
    with np.errstate(all="ignore"):  # trial steps may leave the model's domain; they are refused
        found = optimize.least_squares(
            _finite(residual),
            start,
            jac=_finite(jacobian),
            method="trf",
            x_scale="jac",
            ftol=_TOLERANCE,
            xtol=_TOLERANCE,
            gtol=_TOLERANCE,
            max_nfev=_MAX_EVALUATIONS,
        )
        parameters = _polished(found.x, residual, jacobian, 16 * _EPS * float(np.sqrt(y @ y)))
        return _with_errors(parameters, residual(parameters), jacobian(parameters), bool(found.status > 0))


def _functions(model: Model, x: Floats, y: Floats) -> tuple[Callable[[Floats], Floats], Callable[[Floats], Floats]]:
    def residual(b: Floats) -> Floats:
        return np.asarray(model(x, b) - y, dtype=np.float64)

    def jacobian(b: Floats) -> Floats:
        columns = []
        for j, size in enumerate(np.maximum(np.abs(b), np.finfo(np.float64).tiny)):
            moved = b.astype(np.complex128)
            moved[j] += 1j * _IMAGINARY_STEP * size
            columns.append(np.broadcast_to(np.imag(model(x, moved)) / (_IMAGINARY_STEP * size), y.shape))
        return np.stack(columns, axis=1)

    return residual, jacobian


def _finite(function: Callable[[Floats], Floats]) -> Callable[[Floats], Floats]:
    return lambda b: np.nan_to_num(function(b), nan=_HUGE, posinf=_HUGE, neginf=-_HUGE)


def _check(y: Floats, start: Floats, residual: Callable[[Floats], Floats]) -> None:
    where = "nonlinear fit"
    if y.ndim != 1 or start.ndim != 1 or not (np.all(np.isfinite(y)) and np.all(np.isfinite(start))):
        raise DataError(where, wanted="finite y (n,) and start (p,)", found="other values", do="Leave gaps out.")
    if not 0 < start.size <= y.size:
        found = f"{y.size} points, {start.size} parameters"
        raise DataError(where, wanted="at least as many points as parameters", found=found, do="Measure more.")
    with np.errstate(all="ignore"):
        if not np.all(np.isfinite(residual(start))):
            raise DataError(where, wanted="a finite curve at the start", found="none", do="Choose another start.")


def _polished(
    b: Floats, residual: Callable[[Floats], Floats], jacobian: Callable[[Floats], Floats], rounding: float
) -> Floats:
    """Gauss-Newton from where the trust region stopped, while steps shrink and the sum of squares does not grow.

    rounding : of the norm of the residuals; the sum of squares is not known better than that.
    """
    r = residual(b)
    rss, last = float(r @ r), np.inf
    for _ in range(_POLISHING_STEPS):
        step = -solve(jacobian(b)[None], r[None]).coefficients[0]
        length = float(np.max(np.abs(step) / np.maximum(np.abs(b), np.finfo(np.float64).tiny)))
        if not np.isfinite(length) or length >= last:
            break
        there = residual(b + step)
        if not there @ there <= rss + rounding * np.sqrt(rss):
            break
        b, r, rss, last = b + step, there, float(there @ there), length
        if length < _EPS:
            break
    return b


def _with_errors(b: Floats, r: Floats, j: Floats, ended: bool) -> NonlinearFit:
    n, p = j.shape
    dof, rss = n - p, float(r @ r)
    notes: tuple[str, ...] = () if dof else ("as many parameters as points: no errors",)
    if not (ended and np.isfinite(rss)):
        b, rss, notes = np.full(p, np.nan), np.nan, ("undefined: the search for the least squares does not end",)
    s = float(np.sqrt(rss / dof)) if dof else np.nan
    solution = solve(j[None], r[None])
    if not np.all(solution.pivots[0] > 4 * _EPS):
        s, notes = np.nan, (*notes, "the data do not determine all parameters: no errors")
    root = solution.root[0] * s
    return NonlinearFit(
        parameters=b,
        se=np.sqrt(np.sum(root**2, axis=1)),
        covariance=root @ root.T,
        rss=rss,
        s=s,
        n=n,
        dof=dof,
        notes=notes,
    )
