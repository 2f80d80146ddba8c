"""Fisher's least significant difference: all pairs of groups after an analysis of variance."""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.stats.anova import Anova
from emg2vsa.stats.pair_differences import PairDifferences, pair_numbers


def lsd(anova: Anova, confidence: float = 0.95, *, protected: bool = False) -> PairDifferences:
    """Uncorrected pairwise t tests with the pooled SD and its df (Fisher 1935), as MATLAB's multcompare with 'lsd'.

    protected : pairs of a design whose F test has p above 1 - ``confidence`` get p = 1, Fisher's first step. Either way
    the family-wise error is not controlled beyond three groups: .276 without and up to .20 with protection for five
    groups (statistics notes 4.2).
    """
    first, second = pair_numbers(anova.mean.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = anova.mean[:, first] - anova.mean[:, second]
        per_value = 1 / anova.count[:, first] + 1 / anova.count[:, second]
        se = anova.sd[:, None] * np.sqrt(per_value)
        t = difference / se
        df = np.where(np.isnan(t), np.nan, anova.df2[:, None])
        critical = special.stdtrit(np.where(anova.df2 > 0, anova.df2, np.nan), 0.5 + 0.5 * confidence)
        reach = critical[:, None] * se
        p = 2 * special.stdtr(df, -np.abs(t))
    if protected:
        p = np.where((anova.p[:, None] > 1 - confidence) & ~np.isnan(p), 1.0, p)
    return PairDifferences(
        method="Fisher's LSD, pooled SD" + (", protected by the F test" if protected else ""),
        caution=f"one of {first.size} pairs, not corrected for their number",
        statistic_name="t",
        first=first,
        second=second,
        difference=difference,
        low=difference - reach,
        high=difference + reach,
        statistic=t,
        df=df,
        p=p,
        n=anova.count[:, first] + anova.count[:, second],
        confidence=confidence,
    )
