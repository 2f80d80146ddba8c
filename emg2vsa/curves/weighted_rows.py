"""Points of many designs side by side, x and y with weights, made ready for arithmetic; and what a curve explains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.errors import DataError


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
    y_rows = np.atleast_2d(np.asarray(y, dtype=np.float64))
    x_rows = np.asarray(x, dtype=np.float64)
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
