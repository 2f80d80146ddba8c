"""Pairs of groups by their mean ranks after Kruskal-Wallis: Dunn's test, which is what MATLAB's multcompare does."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.kruskal import KruskalWallis
from emg2vsa.stats.multiplicity import NAMES, Adjustment, adjust
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.pair_differences import pair_numbers

_MOST_GROUPS = 7


@dataclass(frozen=True)
class RankPairs:
    """All q pairs of k groups of d designs; first, second (q,); difference of mean ranks, z, p, n (d, q)."""

    adjustment: Adjustment
    first: Ints
    second: Ints
    difference: Floats
    z: Floats
    p: Floats
    n: Ints

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        return Outcome(
            method=f"Dunn on pooled mean ranks, {NAMES[self.adjustment]}",
            n=int(self.n[i, pair]),
            statistic_name="z",
            statistic=float(self.z[i, pair]),
            p=float(self.p[i, pair]),
            estimate_name="difference of mean ranks",
            estimate=float(self.difference[i, pair]),
            notes=(f"one of {self.first.size} pairs, {NAMES[self.adjustment]}; ranks pooled over all groups",),
        )


def dunn(found: KruskalWallis, adjustment: Adjustment = "bonferroni") -> RankPairs:
    """Dunn (1964), corrected for ties, as MATLAB's multcompare does after kruskalwallis (paper, section VI)."""
    first, second = pair_numbers(found.mean_rank.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = found.mean_rank[:, first] - found.mean_rank[:, second]
        per_value = 1 / found.count[:, first] + 1 / found.count[:, second]
        z = difference / np.sqrt(found.rank_variance[:, None] * per_value)
        z[np.isnan(found.h)] = np.nan
    p = adjust(2 * special.ndtr(-np.abs(z)), adjustment)
    return RankPairs(adjustment, first, second, difference, z, p, found.count[:, first] + found.count[:, second])


def smallest_worst_p(counts: ArrayLike, adjustment: Adjustment = "bonferroni") -> float:
    """Smallest value that the largest p of all pairs can take with groups of ``counts`` (k,) untied values.

    Groups that do not overlap at all are the best case: neighbours then differ by half the sum of their sizes. A
    smaller p than this cannot come from this test (statistics notes 4.5). NaN for fewer than two groups or more than 7.
    """
    sizes = np.asarray(counts, dtype=np.float64)
    if not 2 <= sizes.size <= _MOST_GROUPS:
        return float("nan")
    variance = np.sum(sizes) * (np.sum(sizes) + 1) / 12
    orders = np.array(list(permutations(sizes)))
    first, second = pair_numbers(sizes.size)
    centre = np.cumsum(orders, axis=1) - orders / 2
    z = (centre[:, second] - centre[:, first]) / np.sqrt(variance * (1 / orders[:, first] + 1 / orders[:, second]))
    return float(np.min(np.max(adjust(2 * special.ndtr(-z), adjustment), axis=1)))
