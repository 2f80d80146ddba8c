"""Slope of area over force: least squares over the force axis, robust, with an interval for correlated errors."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

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
    return slope, _standard_error(drawn, force_n, slope_of) if area.size >= INTERVAL_POINTS else None


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


def _standard_error(area: Vector, force_n: Vector, weights: Vector) -> float:
    """Standard error of ``weights @ area`` for errors of area that follow a first-order autoregression.

    The errors are what a smooth curve leaves over, so that the bend of A(F) does not count as noise; the degrees of
    freedom it takes are given back to both the correlation and the variance.
    """
    n = area.size
    unit = (force_n - force_n[0]) / (force_n[-1] - force_n[0])
    bend = np.log(unit + 0.1)
    trend = np.linalg.qr(np.column_stack([np.ones(n), unit, bend, bend**2]))[0]
    error = area - trend @ (trend.T @ area)
    power = float(error @ error)
    if power <= (1e-12 * float(np.abs(area).max())) ** 2 * n:
        return 0.0
    lost = trend.shape[1]
    correlation = (n * float(error[1:] @ error[:-1]) / power + lost) / (n - lost - 1)
    correlation = min(max(correlation, 0.0), 0.95)
    left = n - sum(float(column @ _correlated(column, correlation)) for column in trend.T)
    return float(np.sqrt(power / max(left, 1.0) * (weights @ _correlated(weights, correlation))))


def _correlated(values: Vector, correlation: float) -> Vector:
    """``R @ values`` with R_ij = correlation^|i-j|, cut where it has died out."""
    reach = values.size - 1
    if correlation < 1e-9:
        return values
    reach = min(reach, int(np.log(1e-9) / np.log(correlation)) + 1)
    kernel = correlation ** np.abs(np.arange(-reach, reach + 1))
    return np.asarray(np.convolve(values, kernel)[reach : reach + values.size])


def normal_quantile(confidence: float) -> float:
    """Half width of a central interval in standard errors."""
    return NormalDist().inv_cdf((1 + confidence) / 2)
