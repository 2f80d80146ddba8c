"""How far scores set specimens apart, in numbers that compare between algorithms and between actuators.

Rank tests cannot compare them: once specimens do not overlap, p and epsilon squared are at their bounds. The smallest
of several gaps is no fair number either: as the smallest of noisy ones it lies too low, and its interval with it (79 %
of 95 % bootstrap intervals hold the truth for three equal gaps of 3 SDs and ten presses). So the closest pair of
neighbours is chosen once, over everything that is compared, and its gap is what is compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.statistics.effect_size import hedges_g


@dataclass(frozen=True)
class Gaps:
    """Hedges' g of pairs of specimens, softer less stiffer, or differences of such; interval low to high; (d,) each.

    The difference of two means over the pooled SD of their presses, without its bias on small samples.
    """

    gap: Floats
    low: Floats
    high: Floats

    def at(self, places: Ints) -> Gaps:
        """Those at ``places``."""
        return Gaps(self.gap[places], self.low[places], self.high[places])

    def less(self, other: Gaps) -> Gaps:
        """Differences of independent gaps; the interval recovers the variance at each end (Zou and Donner 2008)."""
        difference = self.gap - other.gap
        below = np.hypot(self.gap - self.low, other.high - other.gap)
        above = np.hypot(self.high - self.gap, other.gap - other.low)
        return Gaps(difference, difference - below, difference + above)


def gaps_of(pairs: Floats, confidence: float) -> Gaps:
    """Of two specimens, the stiffer first: (d, 2, n), NaN: no press. Interval by the noncentral t.

    NaN without spread, or without three presses of both together.
    """
    d = steps(pairs)[:, 0]
    _, _, count = _moments(pairs)
    n1, n2 = np.where(np.isnan(d)[:, None], 2, count).T
    t = d / np.sqrt(1 / n1 + 1 / n2)
    gap, low, high = hedges_g(t, n1, n2, confidence)
    # the noncentral t is exact for the ends without the correction that frees the estimate of its bias
    unbiased = hedges_g(np.ones(len(d)), n1, n2, confidence)[0] / np.sqrt(1 / n1 + 1 / n2)
    with np.errstate(invalid="ignore"):
        return Gaps(gap, low / unbiased, high / unbiased)


def steps(samples: Floats) -> Floats:
    """(..., k - 1) of scores (..., k specimens, n presses), stiffest first: Cohen's d from each to the next softer."""
    mean, squares, count = _moments(samples)
    df = count[..., 1:] + count[..., :-1] - 2
    with np.errstate(divide="ignore", invalid="ignore"):
        sd = np.sqrt((squares[..., 1:] + squares[..., :-1]) / np.where(df > 0, df, np.nan))
        return np.asarray(np.diff(mean, axis=-1) / np.where(sd > 0, sd, np.nan))


def closest_pair(values: Floats) -> int:
    """Place of the stiffer of the two neighbours in (D, S, R) that lie closest in the median design; 0 for none."""
    found = steps(values)
    usual = [np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else np.inf for column in found.T]
    return int(np.argmin(usual))


def repetition_cv(samples: Floats) -> Floats:
    """(...) root mean square over specimens of the presses' SD over their mean; scores as in ``steps``."""
    mean, squares, count = _moments(samples)
    with np.errstate(divide="ignore", invalid="ignore"):
        cv2 = squares / np.where(count > 1, count - 1, np.nan) / mean**2
    return np.asarray(np.sqrt(np.mean(cv2, axis=-1)))


def cv_ratio(samples: Floats) -> Floats:
    """``repetition_cv`` of the first half of the groups (..., 2k, n) over that of the second."""
    first, second = np.split(samples, 2, axis=-2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(repetition_cv(first) / repetition_cv(second))


def level_ratio(samples: Floats) -> Floats:
    """Geometric mean over specimens of mean score, first half of the groups (..., 2k, n) over second; NaN below 0."""
    mean = mean_of(samples)
    with np.errstate(divide="ignore", invalid="ignore"):
        log = np.log(np.where(mean > 0, mean, np.nan))
    first, second = np.split(log, 2, axis=-1)
    return np.asarray(np.exp(np.mean(first - second, axis=-1)))


def pressed_everywhere(values: Floats) -> NDArray[np.int64]:
    """Places of the specimens of (D, S, R) that have a score in each design that has any; all if fewer than two do."""
    count = np.isfinite(values).sum(axis=2)
    places = np.flatnonzero(np.all(count[count.sum(axis=1) > 0] > 0, axis=0))
    return places if places.size > 1 else np.arange(values.shape[1])


def _moments(samples: Floats) -> tuple[Floats, Floats, Ints]:
    """Mean, sum of squared deviations and count along the last axis, NaN skipped."""
    there = np.isfinite(samples)
    mean = mean_of(samples)
    squares = np.sum((samples - mean[..., None]) ** 2, axis=-1, where=there)
    return mean, squares, np.count_nonzero(there, axis=-1)
