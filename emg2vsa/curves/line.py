"""Weighted straight lines y = intercept + slope x, many at once, in closed form.

Each row is shifted by one of its own points (exact) and then centred (two passes), so that neither a large offset nor a
tiny or huge scale costs digits; statistics notes 3b: the best and the fastest of the ways compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, exponent_of

_ROWS_AT_ONCE = 256  # keeps the few temporaries of a block inside the processor's cache
_SAFE = 1e-200  # sums of squares outside 1e-200 to 1e200 are taken again, scaled
_Fields = tuple[Floats, ...]


@dataclass(frozen=True)
class Line:
    """k lines; every field (k,), NaN where undefined (fewer than two points, one abscissa only, no degree of freedom)."""

    intercept: Floats
    slope: Floats
    intercept_se: Floats
    slope_se: Floats
    r2: Floats
    adj_r2: Floats
    n: NDArray[np.int64]
    dof: NDArray[np.int64]


def fit_line(x: Floats, y: Floats, weights: Floats | None = None) -> Line:
    """Least squares of y on x, row by row.

    x, y : (k, p), finite. weights : (k, p), >= 0; a weight of zero leaves the point out. None: all points, alike.
    Only ratios of weights matter; the variance of a point is estimated as s^2 / weight with s^2 from the residuals.
    """
    if weights is not None:
        weights = weights / np.max(weights, axis=1, keepdims=True, initial=np.finfo(np.float64).tiny)
    starts = range(0, max(len(y), 1), _ROWS_AT_ONCE)
    cuts = [slice(i, i + _ROWS_AT_ONCE) for i in starts]
    blocks = [_fit_block(x[cut], y[cut], None if weights is None else weights[cut]) for cut in cuts]
    *reals, n, dof = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
    return Line(*reals, n=n.astype(np.int64), dof=dof.astype(np.int64))


def _fit_block(x: Floats, y: Floats, weights: Floats | None, unit: NDArray[np.int32] | None = None) -> _Fields:
    """The fields of ``Line`` for a block of rows; ``unit`` (k,): binary exponents by which y is scaled down."""
    n = np.full(len(y), float(y.shape[1])) if weights is None else np.count_nonzero(weights, axis=1).astype(np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        total = n if weights is None else np.sum(weights, axis=1)
        x_centre, dx = _centred(x, weights, total)
        y_centre, dy = _centred(y if unit is None else np.ldexp(y, -unit[:, None]), weights, total)
        syy = _sum_of(dy, dy, weights)
        if unit is None and not np.all((syy > _SAFE) & (syy < 1 / _SAFE)):
            return _fit_block(x, y, weights, exponent_of(y)[:, 0])
        sxx = _sum_of(dx, dx, weights)
        slope = _sum_of(dx, dy, weights) / np.where(sxx > 0, sxx, np.nan)
        dy -= slope[:, None] * dx
        sse = _sum_of(dy, dy, weights)
        dof = np.maximum(n - 2, 0)
        s2 = np.where(dof > 0, sse / dof, np.nan)
        unexplained = sse / syy
        in_units_of_y = (
            y_centre - slope * x_centre,
            slope,
            np.sqrt(s2 * (1 / total + x_centre * x_centre / sxx)),
            np.sqrt(s2 / sxx),
        )
        adj_r2 = np.where(dof > 0, 1 - unexplained * (n - 1) / dof, np.nan)
        scaled_back = (values if unit is None else np.ldexp(values, unit) for values in in_units_of_y)
        return (*scaled_back, 1 - unexplained, adj_r2, n, dof)


def _centred(values: Floats, weights: Floats | None, total: Floats) -> tuple[Floats, Floats]:
    """Mean (k,), and values minus mean (k, p), both through differences from the row's first used value."""
    if values.shape[1] == 0:
        return np.full(len(values), np.nan), values
    first = 0 if weights is None else np.argmax(weights > 0, axis=1)
    origin = values[np.arange(len(values)), first]
    shifted = values - origin[:, None]
    mean = (np.sum(shifted, axis=1) if weights is None else np.einsum("kp,kp->k", weights, shifted)) / total
    shifted -= mean[:, None]
    return origin + mean, shifted


def _sum_of(left: Floats, right: Floats, weights: Floats | None) -> Floats:
    """Sum of products along each row; einsum, not BLAS, so that the last bit does not depend on threads."""
    if weights is None:
        return np.einsum("kp,kp->k", left, right)
    return np.einsum("kp,kp,kp->k", weights, left, right)
