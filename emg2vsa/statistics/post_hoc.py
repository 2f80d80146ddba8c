"""Differences between the groups of one-way designs, pair by pair: the answer of every post-hoc test on means."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import DataError
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.anova import Anova
from emg2vsa.statistics.outcome import Outcome


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
            notes=(self.caution, *self.undefined(i, pair)),
        )

    def undefined(self, i: int, pair: int) -> tuple[str, ...]:
        """Why a pair of design ``i`` has no p; empty where it has one."""
        if not np.isnan(self.p[i, pair]):
            return ()
        return ("undefined: too few values in the two groups, or no scatter to compare their difference with",)


def pair_numbers(k: int) -> tuple[Ints, Ints]:
    """First and second group (q,) of all pairs of k groups: 0-1, 0-2, ..., 1-2, ...; DataError below two groups."""
    check_two_groups(k)
    first, second = np.triu_indices(k, 1)
    return first, second


def check_two_groups(k: int) -> None:
    """DataError below two groups."""
    if k < 2:
        raise DataError(
            "pairs of groups", wanted="two groups or more", found=str(k), do="Add a group, or test no pairs."
        )


def student_pairs(
    method: str, difference: Floats, se: Floats, df: Floats, n: Ints, k: int, confidence: float
) -> PairDifferences:
    """All pairs of k groups by Student's t; difference, its standard error se, df and n : (d, q)."""
    first, second = pair_numbers(k)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = difference / se
    reach = special.stdtrit(df, 0.5 + 0.5 * confidence) * se
    return PairDifferences(
        method=method,
        caution=f"one of {first.size} pairs, not corrected for their number",
        statistic_name="t",
        first=first,
        second=second,
        difference=difference,
        low=difference - reach,
        high=difference + reach,
        statistic=t,
        df=df,
        p=2 * special.stdtr(df, -np.abs(t)),
        n=n,
        confidence=confidence,
    )


def lsd(anova: Anova, confidence: float = 0.95, *, protected: bool = False) -> PairDifferences:
    """Uncorrected pairwise t tests with the pooled SD and its df (Fisher 1935), as MATLAB's multcompare with 'lsd'.

    protected : pairs of a design whose F test has p above 1 - ``confidence`` get p = 1, Fisher's first step. Either way
    the family-wise error is not controlled beyond three groups: .276 without and up to .20 with protection for five
    groups (benchmarks/familywise.py).
    """
    first, second = pair_numbers(anova.mean.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = anova.offset[:, first] - anova.offset[:, second]
        per_value = 1 / anova.count[:, first] + 1 / anova.count[:, second]
        se = anova.sd[:, None] * np.sqrt(per_value)
        t = difference / se
        df = np.where(np.isnan(t), np.nan, anova.df2[:, None])
        critical = special.stdtrit(np.where(anova.df2 > 0, anova.df2, np.nan), 0.5 + 0.5 * confidence)
        reach = np.where(np.isnan(t), np.nan, critical[:, None] * se)
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


def tukey(anova: Anova, confidence: float = 0.95) -> PairDifferences:
    """Pairs by the studentized range of the k groups that have values, with the pooled SD (Tukey 1949, Kramer 1956)."""
    first, second = pair_numbers(anova.mean.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = anova.offset[:, first] - anova.offset[:, second]
        se = anova.sd[:, None] * np.sqrt((1 / anova.count[:, first] + 1 / anova.count[:, second]) / 2)
        q = np.abs(difference) / se
        se = np.where(np.isnan(q), np.nan, se)
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
