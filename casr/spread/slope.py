"""Slope of area over force: least squares over the force axis, robust, with an interval for correlated errors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.spread.correlated_errors import standard_error

Vector = NDArray[np.float64]

HUBER_LIMIT = 3.0  # scaled median residuals; on noise-free A ~ F^(1/2) or F^(2/3) nothing reaches it
INTERVAL_POINTS = 10


def force_slope(area: Vector, force_n: Vector) -> tuple[float, float | None]:
    """Slope of A over F and its standard error, None below ten points.

    A(F) is concave, so there is no true line: the slope is that of the least-squares line through the curve A(F) over
    the force axis, each frame weighing the stretch of force it stands for. That makes it a property of the curve,
    whatever the frame rate and however the force rose in time; counting frames alike, the same curve gives slopes
    9 % apart for F ~ t and F ~ t^2. Areas far off the line are drawn to Huber's limit.

    Parameters
    ----------
    area, force_n : (n,) with n >= 2, force strictly rising.
    """
    area = area - area[0]  # exact for near areas, so that a large one costs no digits
    slope_of, mean_of = _line_weights(force_n)
    middle = (force_n[0] + force_n[-1]) / 2
    drawn = area
    for _ in range(50):
        slope = float(slope_of @ drawn)
        line = mean_of @ drawn + slope * (force_n - middle)
        limit = HUBER_LIMIT * 1.4826 * float(np.median(np.abs(area - line)))
        if limit == 0:
            break
        before, drawn = drawn, np.clip(area, line - limit, line + limit)
        if np.abs(drawn - before).max() < 1e-9 * limit:
            break
    if area.size < INTERVAL_POINTS:
        return slope, None
    return slope, standard_error(drawn, _bent(force_n), slope_of)[0]


def _line_weights(force_n: Vector) -> tuple[Vector, Vector]:
    """(n,) weights that give slope and mean of the least-squares line through the piecewise linear curve A(F)."""
    width = np.diff(force_n)
    x = force_n - (force_n[0] + force_n[-1]) / 2
    slope_of, mean_of = np.zeros_like(x), np.zeros_like(x)
    slope_of[:-1] += width * (2 * x[:-1] + x[1:]) / 6
    slope_of[1:] += width * (x[:-1] + 2 * x[1:]) / 6
    mean_of[:-1] += width / 2
    mean_of[1:] += width / 2
    length = width.sum()
    return slope_of * (12 / length**3), mean_of / length


def _bent(force_n: Vector) -> NDArray[np.float64]:
    """(n, 4) columns of a smooth curve, so that the bend of A(F) does not count as noise."""
    unit = (force_n - force_n[0]) / (force_n[-1] - force_n[0])
    bend = np.log(unit + 0.1)
    return np.column_stack([np.ones_like(unit), unit, bend, bend**2])
