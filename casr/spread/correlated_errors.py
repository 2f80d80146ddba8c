"""Standard error of a weighted sum whose terms have errors that last from frame to frame."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


def standard_error(values: Vector, trend: NDArray[np.float64], weights: Vector) -> tuple[float, float]:
    """Standard error of ``weights @ values`` for errors that follow a first-order autoregression, and its freedom.

    The errors are what ``trend``, (n, k) columns, leaves over; the degrees of freedom it takes are given back to both
    the correlation and the variance.
    """
    n = values.size
    trend = np.linalg.qr(trend)[0]
    error = values - trend @ (trend.T @ values)
    power = float(error @ error)
    lost = trend.shape[1]
    if power <= (1e-12 * float(np.abs(values).max())) ** 2 * n:
        return 0.0, float(n - lost)
    correlation = (n * float(error[1:] @ error[:-1]) / power + lost) / (n - lost - 1)
    correlation = min(max(correlation, 0.0), 0.95)
    left = max(n - sum(float(column @ _correlated(column, correlation)) for column in trend.T), 1.0)
    return float(np.sqrt(power / left * (weights @ _correlated(weights, correlation)))), left


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


def student_quantile(confidence: float, freedom: float) -> float:
    """The same where the standard error rests on so many degrees of freedom.

    Expansion in 1/freedom (Abramowitz and Stegun 1964, 26.7.5): 1 % off at three degrees of freedom.
    """
    z = normal_quantile(confidence)
    terms = (
        (z**3 + z) / 4,
        (5 * z**5 + 16 * z**3 + 3 * z) / 96,
        (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384,
    )
    return z + sum(term / freedom**power for power, term in enumerate(terms, start=1))
