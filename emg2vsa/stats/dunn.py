"""Pairs of groups by their mean ranks after Kruskal-Wallis: Dunn's test, which is what MATLAB's multcompare does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.kruskal import KruskalWallis
from emg2vsa.stats.multiplicity import NAMES, Adjustment, adjust
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.pair_differences import pair_numbers


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


def smallest_worst_p(groups: int, count: int, adjustment: Literal["none", "bonferroni"] = "bonferroni") -> float:
    """Smallest value that the largest p of all pairs can take with ``groups`` of ``count`` untied values each.

    Mean ranks of equal groups span at most (groups - 1) count, so some neighbours lie no farther apart than count: the
    best case is groups that do not overlap at all. A smaller p cannot come from this test (statistics notes 4.5). NaN
    for fewer than two groups. With unequal groups no such simple bound holds.
    """
    if groups < 2 or count < 1:
        return float("nan")
    total = groups * count
    gap = np.subtract(*np.triu_indices(groups, 1)[::-1]) * float(count)
    z = gap / np.sqrt(total * (total + 1) / 12 * 2 / count)
    return float(np.max(adjust(2 * special.ndtr(-z), adjustment)))
