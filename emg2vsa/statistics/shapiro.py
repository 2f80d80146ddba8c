"""Shapiro-Wilk test of normality, many samples at once (Royston 1995, algorithm AS R94)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.moments import row_moments
from emg2vsa.statistics.outcome import Outcome

MOST = 5000
"""Values of a sample up to which Royston fitted p."""
# Royston's polynomials, lowest power first
_LAST = (0.0, 0.221157, -0.147981, -2.071190, 4.434685, -2.706056)
_LAST_BUT_ONE = (0.0, 0.042981, -0.293762, -1.752461, 5.682633, -3.582633)
_SMALL_MEAN, _SMALL_LOG_SD = (0.5440, -0.39978, 0.025054, -6.714e-4), (1.3822, -0.77857, 0.062767, -0.0020322)
_LARGE_MEAN, _LARGE_LOG_SD = (-1.5861, -0.31082, -0.083751, 0.0038915), (-0.4803, -0.082676, 0.0030302)
_SMALL_SHIFT = (-2.273, 0.459)
_SMALL = 11


@dataclass(frozen=True)
class ShapiroWilk:
    """k tests; w, p : (k,), NaN where undefined; n : (k,) values that entered; ties : (k,) whether values repeat."""

    w: Floats
    p: Floats
    n: Ints
    ties: NDArray[np.bool_]

    def outcome(self, i: int = 0) -> Outcome:
        """Sample ``i`` alone."""
        return Outcome(
            method="Shapiro-Wilk",
            n=int(self.n[i]),
            statistic_name="W",
            statistic=float(self.w[i]),
            p=float(self.p[i]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        if self.n[i] < 3:
            return (f"undefined: {self.n[i]} values, needs 3",)
        if np.isnan(self.w[i]):
            return ("undefined: all values are equal",)
        notes = ("values repeat: rounded data look less normal than they are",) if self.ties[i] else ()
        return notes + ((f"p extrapolated: fitted for up to {MOST} values",) if self.n[i] > MOST else ())


def shapiro_wilk(values: ArrayLike) -> ShapiroWilk:
    """Test each row of ``values`` (k, n), or one row (n,); NaN marks a value that is not there.

    A row of fewer than three values, or without spread, has no test (NaN).
    """
    rows = row_moments(values)
    count, squares = rows.count[:, 0], rows.squares[:, 0]
    deviation = np.sort(np.where(rows.valid, rows.deviation, np.inf)[:, 0], axis=1)
    lack, p = np.full(count.shape, np.nan), np.full(count.shape, np.nan)
    for n in set(count[count >= 3].tolist()):
        same = (count == n) & (squares > 0)
        lack[same] = _lack(deviation[same, :n], n)
        p[same] = _p(lack[same], n)
    repeated = (deviation[:, 1:] == deviation[:, :-1]) & np.isfinite(deviation[:, 1:])
    return ShapiroWilk(1 - lack, p, count, repeated.any(axis=1))


@cache
def _weights(n: int) -> Floats:
    """The weights (n,) of the ordered values: antisymmetric, sum 0; squares sum to 1 but for rounding."""
    if n == 3:
        return np.array([-np.sqrt(0.5), 0.0, np.sqrt(0.5)])
    m = special.ndtri((np.arange(1, n + 1) - 0.375) / (n + 0.25))
    squares = np.sum(m**2)
    u = 1 / np.sqrt(n)
    ends = [_polynomial(_LAST, u) + m[-1] / np.sqrt(squares)]
    if n > 5:
        ends.append(_polynomial(_LAST_BUT_ONE, u) + m[-2] / np.sqrt(squares))
    e = len(ends)
    scale = (squares - 2 * np.sum(m[-e:] ** 2)) / (1 - 2 * sum(end**2 for end in ends))
    weights = np.asarray(m / np.sqrt(scale))
    weights[-e:] = ends[::-1]
    weights[:e] = -np.array(ends)
    return np.asarray(weights - np.mean(weights))


def _lack(ordered: Floats, n: int) -> Floats:
    """1 - W of centred, sorted rows (j, n), without the cancellation of taking W from 1."""
    weights = _weights(n)
    size = np.sqrt(np.sum(weights**2) * np.sum(ordered**2, axis=1))
    fit = ordered @ weights
    return np.asarray(np.maximum((size - fit) * (size + fit) / size**2, 0.0))


def _p(lack: Floats, n: int) -> Floats:
    if n == 3:  # exact
        return np.asarray(np.maximum(1 - 6 / np.pi * np.arcsin(np.sqrt(np.minimum(lack, 0.25))), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        y, log_n = np.log(lack), np.log(n)
        if n > _SMALL:
            mean, sd = _polynomial(_LARGE_MEAN, log_n), np.exp(_polynomial(_LARGE_LOG_SD, log_n))
            return np.asarray(special.ndtr((mean - y) / sd))
        bound = _polynomial(_SMALL_SHIFT, n)
        mean, sd = _polynomial(_SMALL_MEAN, n), np.exp(_polynomial(_SMALL_LOG_SD, n))
        z = (-np.log(np.maximum(bound - y, 0.0)) - mean) / sd
        return np.asarray(np.where(y >= bound, 0.0, special.ndtr(-z)))


def _polynomial(coefficients: tuple[float, ...], x: float) -> float:
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value
