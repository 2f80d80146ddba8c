"""Lilliefors' test of normality: Kolmogorov-Smirnov with mean and SD estimated, and the p that belongs to that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.lilliefors_table import LARGE, LARGER, LEVELS, SMALL, SMALLEST, largest_d, reach
from emg2vsa.statistics.normality import largest_gap
from emg2vsa.statistics.outcome import Outcome

_LOG_LEVELS = np.log(LEVELS)


@dataclass(frozen=True)
class Lilliefors:
    """k tests; d, p : (k,), NaN where undefined; n : (k,) values that entered."""

    d: Floats
    p: Floats
    n: Ints

    def outcome(self, i: int = 0) -> Outcome:
        """Sample ``i`` alone."""
        return Outcome(
            method="Lilliefors",
            n=int(self.n[i]),
            statistic_name="D",
            statistic=float(self.d[i]),
            p=float(self.p[i]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        if self.n[i] < SMALLEST:
            return (f"undefined: {self.n[i]} values, needs {SMALLEST}",)
        if np.isnan(self.d[i]):
            return ("undefined: all values are equal",)
        return ("p below the simulated range, extrapolated",) if self.p[i] < LEVELS[-1] else ()


def lilliefors(values: ArrayLike) -> Lilliefors:
    """Test each row of ``values`` (k, n), or one row (n,); NaN marks a value that is not there.

    D is that of the standardised Kolmogorov-Smirnov test, p comes from ``lilliefors_survival``. A row of fewer than
    four values, or without spread, has no test (NaN).
    """
    d, n = largest_gap(values, standardise=True)
    return Lilliefors(d, lilliefors_survival(d, n), n)


def lilliefors_survival(d: ArrayLike, n: ArrayLike) -> Floats:
    """P(D >= d) for normal samples of n, mean and SD estimated; d, n : (k,). NaN for d NaN or n < 4.

    From tables of up to 1e7 simulated samples a size: p within 1.5 % down to .001, about 3 % down to 1e-6, 5 % to 1e-8;
    1 where it is above .9999. Beyond the tables log p goes on straight, beyond n = 1000 in 1 / sqrt(n).
    """
    d, n = np.broadcast_arrays(np.asarray(d, dtype=np.float64), np.asarray(n, dtype=np.int64))
    p = np.full(d.shape, np.nan)
    for size in np.unique(n[n >= SMALLEST]):
        same = (n == size) & ~np.isnan(d)
        at, most = np.clip(d[same], 0.0, 1.0), largest_d(size)
        inside = at < most
        p[same] = np.where(inside, _survival(reach(np.where(inside, at, 0.0), size), _row(int(size))), 0.0)
    return p


def _row(n: int) -> Floats:
    """Reach of D (levels,) for samples of n."""
    return SMALL[n - SMALLEST] if n < LARGE else np.asarray(np.polynomial.polynomial.polyval(n**-0.5, LARGER.T))


def _survival(at: Floats, row: Floats) -> Floats:
    """p at reach ``at`` (j,): log p by monotone cubics (Hyman 1983) through the row, straight beyond it."""
    step, rise = np.diff(row), np.diff(_LOG_LEVELS)
    slope = rise / step
    # that of the parabola through three levels, kept small enough for p to fall everywhere
    parabola = (step[:-1] * slope[1:] + step[1:] * slope[:-1]) / (step[:-1] + step[1:])
    inner = np.maximum(parabola, 3 * np.maximum(slope[:-1], slope[1:]))
    ends = np.concatenate([slope[:1], inner, slope[-1:]])
    i = np.clip(np.searchsorted(row, at, side="right") - 1, 0, step.size - 1)
    t = np.maximum((at - row[i]) / step[i], 0.0)
    cubic = _LOG_LEVELS[i] + step[i] * t * (
        ends[i] + t * (3 * slope[i] - 2 * ends[i] - ends[i + 1] + t * (ends[i] + ends[i + 1] - 2 * slope[i]))
    )
    beyond = _LOG_LEVELS[-1] + ends[-1] * (at - row[-1])
    log_p = np.where(at > row[-1], beyond, cubic)
    return np.asarray(np.exp(np.where(at < row[0], 0.0, log_p)))
