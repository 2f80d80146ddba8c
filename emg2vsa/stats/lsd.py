"""Fisher's least significant difference: all pairs of groups after an analysis of variance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.anova import Anova
from emg2vsa.stats.outcome import Outcome


@dataclass(frozen=True)
class PairDifferences:
    """All q = k (k - 1) / 2 pairs of groups of d designs, by the SD pooled over all groups of a design.

    first, second : (q,) group numbers. difference : mean of the first minus mean of the second, low, high : its
    interval at ``confidence``, t, p, n (values in the two groups) : (d, q). df : (d,). NaN where undefined.
    """

    first: Ints
    second: Ints
    difference: Floats
    low: Floats
    high: Floats
    t: Floats
    p: Floats
    n: Ints
    df: Ints
    confidence: float

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        """One pair of design ``i`` alone."""
        return Outcome(
            method="Fisher's LSD, pooled SD",
            n=int(self.n[i, pair]),
            statistic_name="t",
            statistic=float(self.t[i, pair]),
            df=(float(self.df[i]),),
            p=float(self.p[i, pair]),
            estimate_name="difference of means",
            estimate=float(self.difference[i, pair]),
            interval=(float(self.low[i, pair]), float(self.high[i, pair])),
            confidence=self.confidence,
            notes=(f"one of {self.first.size} pairs, not corrected for their number",),
        )


def lsd(anova: Anova, confidence: float = 0.95) -> PairDifferences:
    """Uncorrected pairwise t tests with the pooled SD and its df (Fisher 1935), as MATLAB's multcompare with 'lsd'.

    The family-wise error is not controlled beyond three groups: .20 with five groups of which one differs (statistics
    notes 4.2).
    """
    first, second = np.triu_indices(anova.mean.shape[1], 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = anova.mean[:, first] - anova.mean[:, second]
        per_value = 1 / anova.count[:, first] + 1 / anova.count[:, second]
        se = anova.sd[:, None] * np.sqrt(per_value)
        t = difference / se
        df = anova.df2[:, None]
        reach = special.stdtrit(np.where(df > 0, df, np.nan), 0.5 + 0.5 * confidence) * se
    return PairDifferences(
        first=first,
        second=second,
        difference=difference,
        low=difference - reach,
        high=difference + reach,
        t=t,
        p=2 * special.stdtr(df, -np.abs(t)),
        n=anova.count[:, first] + anova.count[:, second],
        df=anova.df2,
        confidence=confidence,
    )
