"""General nonlinear least squares, for laws that have no fit of their own.

Trust region with exact Jacobians by the complex step (Squire and Trapp 1998), then Gauss-Newton steps on a scaled QR
until nothing is gained: the certified values of all 27 NIST sets from both starts, where finite differences and default
tolerances fail on six (docs/benchmarks/fits.md).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize

from casr.counts import count
from emg2vsa.arrays import Floats
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
    count("fits")
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

    Steps that turn about the end shrink by pairs: one is allowed to be longer than the last, not than the last two.
    rounding : of the norm of the residuals; the sum of squares is not known better than that.
    """
    r = residual(b)
    rss, lengths = float(r @ r), tuple[float, ...]()
    for _ in range(_POLISHING_STEPS):
        step = -solve(jacobian(b)[None], r[None]).coefficients[0]
        length = float(np.max(np.abs(step) / np.maximum(np.abs(b), np.finfo(np.float64).tiny)))
        if not np.isfinite(length) or length >= max(lengths, default=np.inf):
            break
        there = residual(b + step)
        if not there @ there <= rss + rounding * np.sqrt(rss):
            break
        b, r, rss, lengths = b + step, there, float(there @ there), (*lengths[-1:], length)
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


@dataclass(frozen=True)
class Solution:
    """coefficients : (d, p). rss : (d,) residual sum of squares. root : (d, p, p), root times its transpose is the
    inverse of X'X. pivots : (d, p) diagonal of R for columns of length near 1: rounding where X has not full rank.
    """

    coefficients: NDArray[Any]
    rss: NDArray[Any]
    root: NDArray[Any]
    pivots: NDArray[Any]


def solve(x: NDArray[Any], y: NDArray[Any]) -> Solution:
    """Least squares of y (d, n) on the columns of x (d, n, p), n >= p >= 1, both of one floating type.

    Householder QR with scaled columns, in the precision of its input. Scaling makes columns of very different units
    harmless. LAPACK has no extended precision; this has, where ``numpy.longdouble`` is wider than a double.
    """
    p = x.shape[2]
    # powers of two: scaling must not round the columns
    exponent = np.frexp(np.max(np.abs(x), axis=1, initial=0))[1] + np.frexp(np.sqrt(x.shape[1]))[1]
    work = np.concatenate([np.ldexp(x, -exponent[:, None, :]), y[:, :, None]], axis=2)
    for j in range(p):
        _reflect(work, j)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        root = np.ldexp(_inverse_upper(work[:, :p, :p]), -exponent[:, :, None])
        coefficients = np.sum(root * work[:, None, :p, p], axis=2)
    return Solution(
        coefficients=coefficients,
        rss=np.sum(work[:, p:, p] ** 2, axis=1),
        root=root,
        pivots=np.abs(np.diagonal(work[:, :p, :p], axis1=1, axis2=2)),
    )


def _reflect(work: NDArray[Any], j: int) -> None:
    """Make column j zero below the diagonal, in place."""
    v = work[:, j:, j].copy()
    length = np.sqrt(np.sum(v * v, axis=1))
    v[:, 0] += np.where(v[:, 0] < 0, -length, length)
    norm = np.sum(v * v, axis=1)
    factor = 2 * np.sum(v[:, :, None] * work[:, j:, j:], axis=1) / np.where(norm > 0, norm, 1)[:, None]
    work[:, j:, j:] -= v[:, :, None] * factor[:, None, :]


def _inverse_upper(r: NDArray[Any]) -> NDArray[Any]:
    """Inverse of upper triangular matrices (d, p, p), by rows from the last; not finite at a zero on the diagonal."""
    p = r.shape[1]
    inverse = np.zeros_like(r)
    for i in reversed(range(p)):
        inverse[:, i] = -np.sum(r[:, i, i + 1 :, None] * inverse[:, i + 1 :], axis=1)
        inverse[:, i, i] += 1
        inverse[:, i] /= r[:, i, i, None]
    return inverse
