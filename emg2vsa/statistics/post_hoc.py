"""Differences between the groups of one-way designs, pair by pair: the answer of every post-hoc test on means."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, uniform
from emg2vsa.errors import DataError
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.anova import Anova, variance_of_means
from emg2vsa.statistics.moments import common_count, group_moments
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


@cache
def pair_numbers(k: int) -> tuple[Ints, Ints]:
    """First and second group (q,) of all pairs of k groups: 0-1, 0-2, ..., 1-2, ...; DataError below two groups."""
    check_two_groups(k)
    first, second = np.triu_indices(k, 1)
    first.flags.writeable = second.flags.writeable = False
    return first, second


def check_two_groups(k: int) -> None:
    """DataError below two groups."""
    if k < 2:
        raise DataError(
            "pairs of groups", wanted="two groups or more", found=str(k), do="Add a group, or test no pairs."
        )


def student_quantile(df: Floats | float, probability: float) -> Floats | float:
    """Of Student's t at df (d, q), or one number where all are alike: they are few, and the quantile is slow."""
    if isinstance(df, float):
        return float(special.stdtrit(df, probability))
    first = df.item(0) if df.size else np.nan
    if np.count_nonzero(df == first) == df.size:
        return float(special.stdtrit(first, probability))
    known, at = np.unique(df, return_inverse=True)
    return np.asarray(special.stdtrit(known, probability)[at].reshape(df.shape))


def student_pairs(
    method: str, difference: Floats, se: Floats, df: Floats | float, n: Ints, k: int, confidence: float
) -> PairDifferences:
    """All pairs of k groups by Student's t (1908); difference, its standard error se (or (d, 1)), df (or one number),
    n : (d, q)."""
    first, second = pair_numbers(k)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = difference / se
    undefined = np.isnan(t)
    if np.count_nonzero(undefined):
        df = np.where(undefined, np.nan, df)
    reach = student_quantile(df, 0.5 + 0.5 * confidence) * se
    if isinstance(df, float):
        df = uniform(t.shape, df)
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
        p=2 * special.stdtr(df, np.copysign(t, -1.0)),
        n=n,
        confidence=confidence,
    )


def lsd(anova: Anova, confidence: float = 0.95, *, protected: bool = False) -> PairDifferences:
    """Uncorrected pairwise t tests with the pooled SD and its df (Fisher 1935), as MATLAB's multcompare with 'lsd'.

    protected : pairs of a design whose F test has p above 1 - ``confidence`` get p = 1, Fisher's first step. Either way
    the family-wise error is not controlled beyond three groups: .276 without and up to .20 with protection for five
    groups (benchmarks/familywise.py).
    """
    difference, se, n, each = _pooled(anova)
    df: Floats | float = float(anova.df2[0]) if each else anova.df2[:, None] + 0.0 * n
    method = "Fisher's LSD, pooled SD" + (", protected by the F test" if protected else "")
    pairs = student_pairs(method, difference, se, df, n, anova.mean.shape[1], confidence)
    if not protected:
        return pairs
    return replace(pairs, p=np.where((anova.p[:, None] > 1 - confidence) & ~np.isnan(pairs.p), 1.0, pairs.p))


def tukey(anova: Anova, confidence: float = 0.95) -> PairDifferences:
    """Pairs by the studentized range of the k groups that have values, with the pooled SD (Tukey 1949, Kramer 1956)."""
    difference, se, n, _ = _pooled(anova)
    df = np.where(anova.df2 < 1, np.nan, anova.df2)[:, None]
    held, k = "family-wise error of the {} pairs held, equal variances assumed", anova.mean.shape[1]
    return _range_pairs("Tukey's HSD", held, k, difference, se / np.sqrt(2), df, anova.df1 + 1, n, confidence)


def games_howell(values: ArrayLike, confidence: float = 0.95) -> PairDifferences:
    """All pairs with their own variances and Welch's df against Tukey's range (Games and Howell 1976)."""
    groups = group_moments(values)
    used, per_mean = variance_of_means(groups)
    first, second = pair_numbers(groups.counts.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = np.where(used[:, first] & used[:, second], per_mean[:, first] + per_mean[:, second], np.nan)
        share = per_mean**2 / (groups.counts - 1)
        df = squared**2 / (share[:, first] + share[:, second])
    n1, n2 = groups.counts[:, first], groups.counts[:, second]
    difference = groups.to_data(groups.offset[:, first] - groups.offset[:, second])
    difference = np.where((n1 > 0) & (n2 > 0), difference, np.nan)
    held = "family-wise error of the {} pairs held approximately, variances may differ"
    se, k = groups.to_data(np.sqrt(squared / 2)), groups.counts.shape[1]
    ranged = np.count_nonzero(used, axis=1)
    return _range_pairs("Games-Howell", held, k, difference, se, df, ranged, n1 + n2, confidence)


def _pooled(anova: Anova) -> tuple[Floats, Floats, Ints, int]:
    """Of all pairs (d, q): difference of the means, its standard error by the pooled SD, here also (d, 1), values; and
    the values of a group where all have the same, else 0."""
    first, second = pair_numbers(anova.mean.shape[1])
    count, sd = anova.count, anova.sd[:, None]
    difference = anova.offset.take(first, axis=1) - anova.offset.take(second, axis=1)
    if each := common_count(count):
        return difference, sd * sqrt(2 / each), uniform(difference.shape, 2 * each), each
    n1, n2 = count[:, first], count[:, second]
    with np.errstate(divide="ignore", invalid="ignore"):
        return difference, sd * np.sqrt(1 / n1 + 1 / n2), n1 + n2, 0


def _range_pairs(
    method: str, held: str, k: int, difference: Floats, se: Floats, df: Floats, ranged: Ints, n: Ints, confidence: float
) -> PairDifferences:
    """All pairs of k groups by the studentized range of ``ranged`` (d,) means; others (d, q). held : a caution."""
    with np.errstate(divide="ignore", invalid="ignore"):
        q = np.abs(difference) / se
    df = np.where(np.isnan(q), np.nan, df)
    q, means = np.where(np.isnan(df), np.nan, q), np.where(np.isnan(df), np.nan, ranged[:, None])
    reach = studentized_range.quantile(confidence, means, df) * se
    first, second = pair_numbers(k)
    return PairDifferences(
        method=method,
        caution=held.format(first.size),
        statistic_name="q",
        first=first,
        second=second,
        difference=difference,
        low=difference - reach,
        high=difference + reach,
        statistic=q,
        df=df,
        p=studentized_range.survival(q, means, df),
        n=n,
        confidence=confidence,
    )
