"""Weighted straight lines y = intercept + slope x, many at once, in closed form.

Each row is shifted by one of its own points (exact) and then centred (two passes), so that neither a large offset nor a
tiny or huge scale costs digits: the best and the fastest of the ways compared in docs/benchmarks/fits.md.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, exponent_of

_SAFE = 1e-200  # sums of squares outside 1e-200 to 1e200 are taken again, scaled
_IN_UNIT_OF_Y = ("intercept", "slope", "intercept_se", "slope_se")


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
        if np.all((syy > _SAFE) & (syy < 1 / _SAFE)):
            return line
        unit = exponent_of(y)
        scaled, _ = _fit(x, np.ldexp(y, -unit), weights)
        return dataclasses.replace(scaled, **{f: np.ldexp(getattr(scaled, f), unit[:, 0]) for f in _IN_UNIT_OF_Y})


def join(lines: Sequence[Line]) -> Line:
    """Lines one after the other; at least one ``Line``."""
    if len(lines) == 1:
        return lines[0]
    return Line(*(np.concatenate([getattr(line, f.name) for line in lines]) for f in dataclasses.fields(Line)))


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
