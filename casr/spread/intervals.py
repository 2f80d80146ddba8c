"""Intervals of a spread rate: by the scatter of frames whose errors last, and by every known part of its error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

CONFIDENCE = 0.95
"Confidence of the intervals."


FEW_POINTS = 5
"With fewer areas than this, the errors of a law of three parameters do not tell how far the areas scatter."


def standard_error(
    values: Vector, trend: NDArray[np.float64], weights: Vector, thought_sd: float = 0.0
) -> tuple[float, float]:
    """Standard error of ``weights @ values`` for errors that follow a first-order autoregression, and its freedom.

    The errors are what ``trend``, (n, k) columns, leaves over; the degrees of freedom it takes are given back to both
    the correlation and the variance. The correlation is drawn to 0 as far as so few errors do not tell it.

    thought_sd : of an error, before it is seen; it counts for as many as are missing to ``FEW_POINTS``.
    """
    n = values.size
    trend = np.linalg.qr(trend)[0]
    error = values - trend @ (trend.T @ values)
    power = float(error @ error)
    lost, thought = trend.shape[1], max(FEW_POINTS - n, 0) if thought_sd else 0
    if not thought and power <= (1e-12 * float(np.abs(values).max())) ** 2 * n:
        return 0.0, float(n - lost)
    told = max(n - lost - 1, 0)
    correlation = (n * float(error[1:] @ error[:-1]) / max(power, 1e-300) + lost) * told / (told**2 + n)
    correlation = min(max(correlation, 0.0), 0.95)
    left = max(n - sum(float(column @ _correlated(column, correlation)) for column in trend.T), 1.0)
    freedom = left + thought
    variance = (power + thought * thought_sd**2) / freedom
    return float(np.sqrt(variance * (weights @ _correlated(weights, correlation)))), freedom


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
    terms = ((z**3 + z) / 4, (5 * z**5 + 16 * z**3 + 3 * z) / 96, (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384)
    return z + sum(term / freedom**power for power, term in enumerate(terms, start=1))


@dataclass(frozen=True)
class TotalInterval:
    """95 % interval of a quantity that is above 0, multiplicative: value times exp(+-1.96 s).

    low, high : of it. parts : name to relative standard error; s is the root of the sum of their squares.
    left_out : what is known to be missing.
    """

    low: float
    high: float
    parts: dict[str, float]
    left_out: tuple[str, ...]

    @property
    def relative_sd(self) -> float:
        """Total relative standard error."""
        return float(np.sqrt(sum(part**2 for part in self.parts.values())))


def total_interval(value: float, parts: Mapping[str, float], left_out: tuple[str, ...] = ()) -> TotalInterval | None:
    """None where the value is not above 0 or a part is not known."""
    kept = {name: float(part) for name, part in parts.items()}
    if not value > 0 or not np.isfinite(list(kept.values())).all():
        return None
    with np.errstate(over="ignore"):  # of a part that says nothing: the interval is from 0 to infinity
        reach = float(np.exp(normal_quantile(CONFIDENCE) * np.sqrt(sum(part**2 for part in kept.values()))))
    return TotalInterval(value / reach, value * reach, kept, left_out)
