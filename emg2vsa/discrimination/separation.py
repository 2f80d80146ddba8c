"""How far scores set two specimens apart, in a number that compares between algorithms and between actuators.

Rank tests cannot compare them: once specimens do not overlap, p and epsilon squared are at their bounds. What compares
is d': the size of the contrast of two specimens, difference of mean ln score over mountings, in SDs of a press within
its mounting. The pair is the two neighbours whose known stiffness differs least, whatever the scores are: a pair chosen
by the scores, or the smallest of several noisy gaps, would lie too low.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.mountings import Mountings, checked, columns


@dataclass(frozen=True, eq=False)
class Gaps:
    """d' of a pair of specimens in n designs, or differences of such; interval low to high; (n,) each."""

    gap: Floats
    low: Floats
    high: Floats

    def at(self, places: Ints) -> Gaps:
        """Those at ``places`` (k,)."""
        return Gaps(self.gap[places], self.low[places], self.high[places])

    def less(self, other: Gaps) -> Gaps:
        """Differences of independent gaps; the interval recovers the variance at each end (Zou and Donner 2008)."""
        difference = self.gap - other.gap
        below = np.hypot(self.gap - self.low, other.high - other.gap)
        above = np.hypot(self.high - self.gap, other.gap - other.low)
        return Gaps(difference, difference - below, difference + above)


def gaps_of(mountings: Mountings, pair: tuple[int, int], confidence: float) -> Gaps:
    """Gap of a pair of specimens in every design; NaN without two presses of a mounting, or where they do not
    scatter.
    """
    designs = range(len(checked(mountings).own))
    return Gaps(*columns([gap_of(mountings, design, pair, confidence) for design in designs]))


def gap_of(mountings: Mountings, design: int, pair: tuple[int, int], confidence: float) -> tuple[float, float, float]:
    """d' of a pair in one design, low and high: the interval of the contrast (t over mountings) and that of the SD of
    presses (chi-square) recover the variance of their ratio at each end, in logarithms (Zou and Donner 2008).
    """
    contrast = checked(mountings).sum({(design, pair[1]): 1.0, (design, pair[0]): -1.0})
    sd, df = mountings.press_sd([design])
    low, high = contrast.ends(confidence)
    if not (df and sd > 0 and low == low):
        return np.nan, np.nan, np.nan
    tail = 0.5 - 0.5 * confidence
    wider, narrower = np.sqrt(special.chdtri(df, (tail, 1 - tail)) / df)  # sd / low of the SD, sd / its high
    least, size, most = (0.0 if low <= 0 <= high else min(abs(low), abs(high))), abs(contrast.estimate), max(-low, high)
    below = np.hypot(np.log(size / least), np.log(narrower)) if least else np.inf
    above = np.hypot(np.log(most / size), np.log(wider)) if size else np.inf
    return size / sd, size / sd * float(np.exp(-below)), min(size / sd * float(np.exp(above)), most / sd * wider)


def closest_pair(stiffness_n_per_mm: Floats, used: Iterable[int]) -> tuple[int, int]:
    """Places of the two neighbours, stiffer first, whose stiffness (S,), N/mm, stiffest first, differs least as a
    ratio.

    used : at least two places.
    """
    places = sorted(used)
    pairs = list(pairwise(places))
    return min(pairs, key=lambda pair: stiffness_n_per_mm[pair[0]] / stiffness_n_per_mm[pair[1]])


def press_sds(mountings: Mountings) -> Floats:
    """(D,) SD of ln score of a press within its mounting, over the specimens of each design."""
    return np.array([checked(mountings).press_sd([design])[0] for design in range(len(mountings.own))])


def sd_ratio(mountings: Mountings, one: int, other: int, confidence: float) -> tuple[float, float, float]:
    """SD of a press within its mounting in design ``one`` over that in ``other``; low and high by F."""
    (first, df1), (second, df2) = (checked(mountings).press_sd([design]) for design in (one, other))
    if not (df1 and df2 and second > 0):
        return np.nan, np.nan, np.nan
    ratio, quantile = first / second, 0.5 + 0.5 * confidence
    ends = special.fdtri((df1, df2), (df2, df1), quantile) ** 0.5
    return ratio, float(ratio / ends[0]), float(ratio * ends[1])


def pressed_everywhere(values: Floats) -> NDArray[np.int64]:
    """Places of the specimens of (D, S, R) that have a score in each design that has any; all if fewer than two do."""
    count = np.isfinite(values).sum(axis=2)
    places = np.flatnonzero(np.all(count[count.sum(axis=1) > 0] > 0, axis=0))
    return places if places.size > 1 else np.arange(values.shape[1])
