"""Area over force as a power law that bends and as a line: robust fits of a rate and its standard error."""

from __future__ import annotations

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.spread.intervals import FEW_POINTS, standard_error

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]

HUBER_LIMIT = 3.0  # scaled median residuals
POWER_LAW_POINTS = 4
CURVATURE, CURVATURE_SD = -0.025, 0.02
"""Curvature of ln A over ln F, and its SD, before a press is seen: -0.066 to +0.001 from 0.5 to 7 N on eight domes of
finite elements, three specimens and two frictions."""
_STRAIGHT = 1e-12  # of the square of ln F: less tells no curvature
AREA_SD = 0.02
"SD of ln A before a press is seen: what fewer than ``FEW_POINTS`` areas are taken to scatter by."


@dataclass(frozen=True)
class PowerLaw:
    """A = coefficient F^(exponent + curvature ln F), in the unit of the areas with F in N."""

    coefficient: float
    exponent: float
    curvature: float = 0.0

    @overload
    def area(self, force_n: float) -> float: ...
    @overload
    def area(self, force_n: Vector) -> Vector: ...
    def area(self, force_n: float | Vector) -> float | Vector:
        """Area at forces above 0, N: a scalar, or (n,)."""
        return self.coefficient * force_n ** (self.exponent + self.curvature * np.log(force_n))

    def mean_rate(self, low_n: float, high_n: float) -> float:
        """(A(high) - A(low)) / (high - low)."""
        return float(self.area(high_n) - self.area(low_n)) / (high_n - low_n)

    def rate(self, force_n: Vector) -> Vector:
        """dA/dF at forces (n,) above 0, N: units of area for each N."""
        return (self.exponent + 2 * self.curvature * np.log(force_n)) * self.area(force_n) / force_n


@dataclass(frozen=True)
class PowerLawFits:
    """Power laws through the areas and forces of P presses.

    ln A is ``found`` (P, 3) times three columns: 1, x = ln F from its mean, and x^2 without its own mean and slope.
    ``moments`` (P, 3): mean of ln F, of x^2, and of x^3 over that. log_area : (P, n) drawn to Huber's limit.
    weigh : (P, 3, n) what each area gives to ``found``. untold : (P,) share of the curvature that no area tells.
    """

    found: Matrix
    moments: Matrix
    log_area: Matrix
    columns: NDArray[np.float64]
    weigh: NDArray[np.float64]
    untold: Vector

    def mean_rates(self, low_n: float, high_n: float | Vector) -> Vector:
        """(P,) as ``PowerLaw.mean_rate``; low_n, high_n : N, the latter one or (P,).

        The mean rate stands in place of the paper's sum, equation (2).
        """
        low, high = (np.exp((self.found * self._at(force_n)).sum(axis=1)) for force_n in (low_n, high_n))
        return np.asarray((high - low) / (high_n - low_n))

    @property
    def law(self) -> PowerLaw:
        """Power law of the first press."""
        (level, exponent, curvature), (mean, square, skew) = self.found[0].tolist(), self.moments[0].tolist()
        level += (curvature * (mean + skew) - exponent) * mean - curvature * square
        return PowerLaw(float(np.exp(level)), exponent - curvature * (2 * mean + skew), curvature)

    def standard_error(self, low_n: float, high_n: float) -> tuple[float, float] | None:
        """Standard error of the mean rate of the first press, for the errors of single areas and for the curvature that
        they do not tell, and its degrees of freedom.

        None below four points.
        """
        if self.log_area.shape[1] < POWER_LAW_POINTS:
            return None
        low, high = (self._at(force_n)[0] for force_n in (low_n, high_n))
        slope = (self.law.area(high_n) * high - self.law.area(low_n) * low) / (high_n - low_n)
        scatter, freedom = standard_error(self.log_area[0], self.columns[0].T, slope @ self.weigh[0], AREA_SD)
        return float(np.hypot(scatter, slope[2] * self.untold[0] * CURVATURE_SD)), freedom

    def _at(self, force_n: float | Vector) -> Matrix:
        """(P, 3) columns at a force."""
        return _columns(np.broadcast_to(np.log(force_n), self.untold.shape)[:, None], self.moments)[..., 0]


def fit_power_laws(area: ArrayLike, force_n: ArrayLike) -> PowerLawFits:
    """Least squares of ln A on ln F and its square.

    The contact of a dome grows as a power of the force: F^(2/3) for Hertz, and an exponent from 0 to 2/3 for a soft
    finger (Xydas and Kao 1999, Int. J. Robotics Research 18, 941). In finite elements the exponent falls with force, so
    the law has a curvature, which is drawn to ``CURVATURE`` as far as the scatter of the areas leaves it open. A frame
    weighs its force, which lies between what equal errors of area in percent ask for (1) and equal errors of force in
    newtons (F^2). Areas far off are drawn to Huber's limit.

    area, force_n : (n,) of one press or (P, n), above 0, NaN for no frame. A press with fewer than two frames, or with
    forces all alike, has NaN.
    """
    given = np.atleast_2d(np.asarray(area, dtype=np.float64))
    seen, force = np.isfinite(given), np.atleast_2d(np.asarray(force_n, dtype=np.float64))
    weights, n = np.where(seen, force, 0.0), seen.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        weights /= weights.sum(axis=1, keepdims=True)
        log_area, log_force = (np.log(np.where(seen, each, 1.0)) for each in (given, force))
        mean = (weights * log_force).sum(axis=1)
        square, cube = ((weights * (log_force - mean[:, None]) ** power).sum(axis=1) for power in (2, 3))
        moments = np.stack([mean, square, cube / square], axis=1)
        columns = _columns(log_force, moments)
        weighted = weights[:, None] * columns
        power = (weighted * columns).sum(axis=2)
        power[:, 2] += _STRAIGHT * square**2
        drawn, thought, rows = log_area, np.maximum(FEW_POINTS - n, 0), np.arange(n.size)
        freedom = np.maximum(thought + n - 3, 1) * n * CURVATURE_SD**2
        pull = np.zeros_like(power)
        for _ in range(50):
            told = (weighted @ drawn[..., None])[..., 0]
            left = drawn - _through(columns, told / power)
            pull[:, 2] = (thought * AREA_SD**2 + n * (weights * left**2).sum(axis=1)) / freedom
            found = (told + pull * CURVATURE) / (power + pull)
            line = _through(columns, found)
            off = np.sort(np.where(seen, np.abs(log_area - line), np.inf), axis=1)
            limit = (HUBER_LIMIT * 1.4826 / 2 * (off[rows, (n - 1) // 2] + off[rows, n // 2]))[:, None]
            before, drawn = drawn, np.minimum(np.maximum(log_area, line - limit), line + limit)
            if not (np.abs(drawn - before) > 1e-7 * limit + 1e-13).any():
                break
        total = power + pull
        return PowerLawFits(found, moments, drawn, columns, weighted / total[..., None], pull[:, 2] / total[:, 2])


def _columns(log_force: Matrix, moments: Matrix) -> NDArray[np.float64]:
    """(P, 3, n) at (P, n) forces."""
    mean, square, skew = moments.T[..., None]
    x = log_force - mean
    return np.stack([np.ones_like(x), x, x * (x - skew) - square], axis=1)


def _through(columns: NDArray[np.float64], found: Matrix) -> Matrix:
    return np.asarray((found[:, None] @ columns)[:, 0])


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
