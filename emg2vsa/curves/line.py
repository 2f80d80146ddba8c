"""Weighted straight lines y = intercept + slope x, many at once, in closed form.

Each row is shifted by one of its own points (exact) and then centred (two passes), so that neither a large offset nor a
tiny or huge scale costs digits; statistics notes 3b: the best and the fastest of the ways compared.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, exponent_of

_SAFE = 1e-200  # sums of squares outside 1e-200 to 1e200 are taken again, scaled


@dataclass(frozen=True)
class Line:
    """k lines; every field (k,), NaN where undefined (too few points, one abscissa only)."""

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
    Only ratios of weights matter (the largest of a row should be near 1): the variance of a point is taken as
    s^2 / weight with s^2 from the residuals.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        plain = _fit(x, y, weights)
        if np.all((plain.syy > _SAFE) & (plain.syy < 1 / _SAFE)):
            return plain.line
        return _scaled(_fit(x, y, weights))


def join(lines: Sequence[Line]) -> Line:
    """Lines one after the other; at least one ``Line``."""
    return Line(*(np.concatenate([getattr(line, f.name) for line in lines]) for f in dataclasses.fields(Line)))


def _fit(x: Floats, y: Floats, weights: Floats | None, unit: NDArray[np.int32] | None) -> Line | None:
    """``fit_line`` with y scaled by 2^-unit, unit (k,); None where unscaled squares would leave the range of float64."""
    k, n_points = y.shape
    n = np.full(k, n_points) if weights is None else np.count_nonzero(weights, axis=1)
    total = n if weights is None else np.sum(weights, axis=1)
    x_centre, dx = _centred(x, weights, total)
    y_centre, dy = _centred(y if unit is None else np.ldexp(y, -unit[:, None]), weights, total)
    syy = _sum_of(dy, dy, weights)
    if unit is None and not np.all((syy > _SAFE) & (syy < 1 / _SAFE)):
        return None
    sxx = _sum_of(dx, dx, weights)
    slope = _sum_of(dx, dy, weights) / np.where(sxx > 0, sxx, np.nan)
    dx *= slope[:, None]
    dy -= dx
    sse = _sum_of(dy, dy, weights)
    dof = np.maximum(n - 2, 0)
    error = np.sqrt(np.where(dof > 0, sse / dof, np.nan))
    unexplained = sse / syy
    in_unit_of_y = (
        y_centre - slope * x_centre,
        slope,
        error * np.sqrt(1 / total + x_centre * x_centre / sxx),
        error / np.sqrt(sxx),
    )
    return Line(
        *(in_unit_of_y if unit is None else (np.ldexp(values, unit) for values in in_unit_of_y)),
        r2=1 - unexplained,
        adj_r2=np.where(dof > 0, 1 - unexplained * (n - 1) / dof, np.nan),
        n=n,
        dof=dof,
    )


def _centred(values: Floats, weights: Floats | None, total: Floats) -> tuple[Floats, Floats]:
    """Mean (k,), and values minus mean (k, p), both through differences from the row's first used value."""
    if values.shape[1] == 0:
        return np.full(len(values), np.nan), values
    if weights is None:
        origin = values[:, 0]
    else:
        origin = values[np.arange(len(values)), np.argmax(weights > 0, axis=1)]
    shifted = values - origin[:, None]
    mean = (np.sum(shifted, axis=1) if weights is None else np.einsum("kp,kp->k", weights, shifted)) / total
    shifted -= mean[:, None]
    return origin + mean, shifted


def _sum_of(left: Floats, right: Floats, weights: Floats | None) -> Floats:
    """Sum of products along each row; einsum, not BLAS, so that the last bit does not depend on threads."""
    if weights is None:
        return np.einsum("kp,kp->k", left, right)
    return np.einsum("kp,kp,kp->k", weights, left, right)
