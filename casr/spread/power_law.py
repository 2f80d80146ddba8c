"""Area as a power of force, and its mean growth between two forces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from casr.median import median
from casr.spread.correlated_errors import standard_error

Vector = NDArray[np.float64]

HUBER_LIMIT = 3.0  # scaled median residuals
INTERVAL_POINTS = 5


@dataclass(frozen=True)
class PowerLaw:
    """A = coefficient F^exponent, in the unit of the areas with F in N."""

    coefficient: float
    exponent: float

    @overload
    def area(self, force_n: float) -> float: ...
    @overload
    def area(self, force_n: Vector) -> Vector: ...
    def area(self, force_n: float | Vector) -> float | Vector:
        """Area at forces above 0."""
        return self.coefficient * force_n**self.exponent

    def mean_rate(self, low_n: float, high_n: float) -> float:
        """(A(high) - A(low)) / (high - low)."""
        return (self.area(high_n) - self.area(low_n)) / (high_n - low_n)


@dataclass(frozen=True)
class PowerLawFit:
    """A power law through areas and forces; ``standard_error`` tells how good its mean rate is."""

    law: PowerLaw
    log_area: Vector
    log_force: Vector
    weights: Vector

    def standard_error(self, low_n: float, high_n: float) -> tuple[float, float] | None:
        """Standard error of ``law.mean_rate`` for the errors of single areas, and its degrees of freedom.

        None below five points.
        """
        if self.log_area.size < INTERVAL_POINTS:
            return None
        x, mean, slope_of = _line(self.log_force, self.weights)
        ends = np.log([low_n, high_n]) - mean
        area = self.law.area(np.array([low_n, high_n]))
        of_level, of_exponent = np.diff(area)[0], np.diff(area * ends)[0]
        by_area = (of_level * self.weights + of_exponent * slope_of) / (high_n - low_n)
        return standard_error(self.log_area, np.column_stack([np.ones_like(x), x]), by_area)


def fit_power_law(area: Vector, force_n: Vector) -> PowerLawFit:
    """Least squares of ln A on ln F.

    The contact of a dome grows as a power of the force: F^(2/3) for Hertz, and an exponent from 0 to 2/3 for a soft
    finger (Xydas and Kao 1999, Int. J. Robotics Research 18, 941). A frame weighs its force, which lies between what
    equal errors of area in percent ask for (1) and equal errors of force in newtons (F^2). Areas far off are drawn to
    Huber's limit.

    Parameters
    ----------
    area, force_n : (n,) above 0 with n >= 2, forces not all alike.
    """
    log_area, log_force, weights = np.log(area), np.log(force_n), force_n / force_n.sum()
    x, mean, slope_of = _line(log_force, weights)
    drawn = log_area
    for _ in range(50):
        level, exponent = float(weights @ drawn), float(slope_of @ drawn)
        line = level + exponent * x
        limit = HUBER_LIMIT * 1.4826 * float(median(np.abs(log_area - line)))
        before, drawn = drawn, np.clip(log_area, line - limit, line + limit)
        if np.abs(drawn - before).max() <= 1e-9 * limit:
            break
    law = PowerLaw(float(np.exp(level - exponent * mean)), exponent)
    return PowerLawFit(law, drawn, log_force, weights)


def _line(log_force: Vector, weights: Vector) -> tuple[Vector, float, Vector]:
    """Forces from their mean, that mean, and the (n,) weights that give the slope of a line through n points."""
    mean = float(weights @ log_force)
    x = log_force - mean
    return x, mean, weights * x / (weights @ x**2)
