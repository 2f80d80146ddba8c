"""Differences between the groups of one-way designs, pair by pair: the answer of every post-hoc test on means."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.outcome import Outcome


@dataclass(frozen=True, kw_only=True)
class PairDifferences:
    """All q = k (k - 1) / 2 pairs of groups of d designs.

    first, second : (q,) group numbers. difference : mean of the first minus mean of the second, low, high : its
    interval at ``confidence``, statistic, df, p, n (values in the two groups) : (d, q). NaN where undefined.
    method : the test's full name. caution : what its p does and does not account for.
    """

    method: str
    caution: str
    statistic_name: str
    first: Ints
    second: Ints
    difference: Floats
    low: Floats
    high: Floats
    statistic: Floats
    df: Floats
    p: Floats
    n: Ints
    confidence: float

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        """One pair of design ``i`` alone."""
        return Outcome(
            method=self.method,
            n=int(self.n[i, pair]),
            statistic_name=self.statistic_name,
            statistic=float(self.statistic[i, pair]),
            df=(float(self.df[i, pair]),),
            p=float(self.p[i, pair]),
            estimate_name="difference of means",
            estimate=float(self.difference[i, pair]),
            interval=(float(self.low[i, pair]), float(self.high[i, pair])),
            confidence=self.confidence,
            notes=(self.caution,),
        )


def pair_numbers(k: int) -> tuple[Ints, Ints]:
    """First and second group (q,) of all pairs of k groups: 0-1, 0-2, ..., 1-2, ..."""
    pairs = np.array(list(combinations(range(k), 2)), dtype=np.int64).reshape(-1, 2)
    return pairs[:, 0], pairs[:, 1]
