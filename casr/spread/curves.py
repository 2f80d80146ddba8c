"""Area over force as a power law and as a line: robust fits of a rate and its standard error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from casr.median import median
from casr.spread.intervals import standard_error

Vector = NDArray[np.float64]

HUBER_LIMIT = 3.0  # scaled median residuals
POWER_LAW_POINTS = 5


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
        if self.log_area.size < POWER_LAW_POINTS:
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


SLOPE_POINTS = 10


def force_slope(area: Vector, force_n: Vector) -> tuple[float, float | None]:
    """Slope of A over F and its standard error, None below ten points.

    A(F) is concave, so there is no true line: the slope is that of the least-squares line through the curve A(F) over
    the force axis, each frame weighing the stretch of force it stands for. That makes it a property of the curve,
    whatever the frame rate and however the force rose in time; counting frames alike, the same curve gives slopes
    9 % apart for F ~ t and F ~ t^2. Areas far off the line are drawn to Huber's limit.

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
    if area.size < SLOPE_POINTS:
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
