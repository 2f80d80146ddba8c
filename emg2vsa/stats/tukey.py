"""Tukey's honestly significant difference (Kramer's form for unequal groups): all pairs, family-wise error held."""

from __future__ import annotations

import numpy as np

from emg2vsa.stats import studentized_range
from emg2vsa.stats.anova import Anova
from emg2vsa.stats.pair_differences import PairDifferences, pair_numbers


def tukey(anova: Anova, confidence: float = 0.95) -> PairDifferences:
    """Pairs by the studentized range of the k groups that have values, with the pooled SD (Tukey 1949, Kramer 1956)."""
    first, second = pair_numbers(anova.mean.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = anova.mean[:, first] - anova.mean[:, second]
        se = anova.sd[:, None] * np.sqrt((1 / anova.count[:, first] + 1 / anova.count[:, second]) / 2)
        q = np.abs(difference) / se
    df = np.where(np.isnan(q) | (anova.df2 < 1)[:, None], np.nan, anova.df2[:, None])
    groups = (anova.df1 + 1)[:, None]
    critical = studentized_range.quantile(confidence, np.where(np.isnan(df), np.nan, groups), df)
    return PairDifferences(
        method="Tukey's HSD",
        caution=f"family-wise error of the {first.size} pairs held, equal variances assumed",
        statistic_name="q",
        first=first,
        second=second,
        difference=difference,
        low=difference - critical * se,
        high=difference + critical * se,
        statistic=q,
        df=df,
        p=studentized_range.survival(q, groups, df),
        n=anova.count[:, first] + anova.count[:, second],
        confidence=confidence,
    )
