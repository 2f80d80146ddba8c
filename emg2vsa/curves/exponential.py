"""The exponential law y = p exp(q x), fitted to many designs in one call.

By variable projection: for each q the best p is a quotient of sums, and q alone is searched for. Fewer things can go
wrong than with two parameters, and 13 digits are right where general fitters give 7 to 8 (docs/benchmarks/fits.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from casr.counts import count
from emg2vsa.arrays import Floats, exponent_of
from emg2vsa.curves.line import fit_line
from emg2vsa.curves.variable_projection import has_minimum, log_linear_start, projected, search
from emg2vsa.curves.weighted_rows import WeightedRows, check_rows, weighted_rows

_WHERE = "exponential fit"
_POINTS_AT_ONCE = 12_000  # temporaries below 128 kB: the C library maps and clears larger ones anew each time


@dataclass(frozen=True)
class ExponentialFit:
    """d fits of y = y0 exp(q (x - x0)); every field (d,), NaN where undefined.

    x0, y0 : the point of the curve at which level and q are uncorrelated, in the units of x and y. q : 1 / unit of x.
    """

    x0: Floats
    y0: Floats
    q: Floats


def fit_exponential(x: ArrayLike, y: ArrayLike) -> ExponentialFit:
    """Least squares of y itself.

    x : (n,) common to all, or (d, n). y : (n,) or (d, n), of either sign. NaN in x or y leaves a point out. Undefined
    below two points of one sign at different x, and where no exponential is nearest, so that the search for it does not
    end. DataError where the shapes do not fit.
    """
    x, y = np.asarray(x, dtype=np.float64), np.atleast_2d(np.asarray(y, dtype=np.float64))
    check_rows(x, y, None, _WHERE)
    size = max(1, _POINTS_AT_ONCE // max(1, y.shape[1]))
    cuts = [slice(i, i + size) for i in range(0, max(len(y), 1), size)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        blocks = (weighted_rows(x if x.ndim == 1 else x[cut], y[cut], None, _WHERE) for cut in cuts)
        fits = [_least_squares(rows) for rows in blocks]
    return ExponentialFit(*(np.concatenate(parts) for parts in zip(*fits, strict=True)))


def _least_squares(rows: WeightedRows) -> tuple[Floats, Floats, Floats]:
    """x0, y0 and q of one block of rows, in units that make every |z| and |y| at most 1."""
    z = rows.x - rows.x_centre[:, None]
    unit_x, unit_y = exponent_of(z), exponent_of(rows.y)
    z, y = np.ldexp(z, -unit_x), np.ldexp(rows.y, -unit_y)
    unit_x, unit_y = unit_x[:, 0], unit_y[:, 0]
    count("fits", len(y))
    q = search(z, y, rows.w, log_linear_start(z, y, rows.w))
    curve = projected(q, z, y, rows.w)
    q = np.where(has_minimum(q, z, y, rows.w, curve), q + curve.step, np.nan)
    x0 = rows.x_centre + np.ldexp(curve.centre + 0 * q, unit_x)
    return x0, np.ldexp(curve.level + 0 * q, unit_y), np.ldexp(q, -unit_x)


def fit_exponential_log(x: ArrayLike, y: ArrayLike) -> ExponentialFit:
    """Least squares of ln y, a straight line: relative errors count alike. Arguments as in ``fit_exponential``.

    A row in which any value that counts is zero or negative is undefined.
    """
    rows = weighted_rows(x, y, None, _WHERE)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        log_y = np.log(np.where(rows.w > 0, rows.y, 1.0))
        negative = np.any(np.isnan(log_y) | np.isinf(log_y), axis=1)
        line = fit_line(rows.x - rows.x_centre[:, None], np.where(negative[:, None], 0.0, log_y), rows.w)
        blank = np.where(negative | np.isnan(line.slope), np.nan, 0.0)
        return ExponentialFit(rows.x_centre, np.exp(line.intercept + blank), line.slope + blank)
