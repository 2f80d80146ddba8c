"""Groups of unequal variance: Welch's analysis of variance and the pairs of Games and Howell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics import studentized_range
from emg2vsa.statistics.moments import GroupMoments, group_moments
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers


@dataclass(frozen=True)
class WelchAnova:
    """d one-way designs; f, df2, p, n : (d,), df1 : (d,) groups of two or more values less one. NaN: undefined."""

    f: Floats
    df1: Ints
    df2: Floats
    p: Floats
    n: Ints

    def outcome(self, i: int = 0) -> Outcome:
        undefined = np.isnan(self.f[i])
        return Outcome(
            method="Welch's analysis of variance",
            n=int(self.n[i]),
            statistic_name="F",
            statistic=float(self.f[i]),
            df=(float(self.df1[i]), float(self.df2[i])),
            p=float(self.p[i]),
            notes=("undefined: needs two groups of two or more values that are not all equal",) if undefined else (),
        )


def welch(values: ArrayLike) -> WelchAnova:
    """Welch (1951) on ``values`` as ``one_way`` takes them; groups of one value are left out, they have no variance.

    A group without spread makes its weight infinite and the test undefined (NaN).
    """
    groups = group_moments(values)
    used, per_mean = _variance_of_means(groups)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(used, 1 / per_mean, 0.0)
        total = np.sum(weight, axis=1)
        k = np.count_nonzero(used, axis=1)
        grand = np.sum(weight * groups.offset, axis=1) / total
        between = np.sum(weight * (groups.offset - grand[:, None]) ** 2, axis=1) / (k - 1)
        spare = np.where(used, (1 - weight / total[:, None]) ** 2 / (groups.count - 1), 0.0)
        lack = np.sum(spare, axis=1)
        f = between / (1 + 2 * (k - 2) * lack / (k**2 - 1))
        df2 = (k**2 - 1) / (3 * lack)
        f, df2 = np.where(k > 1, f, np.nan), np.where(k > 1, df2, np.nan)
    df1 = np.maximum(k - 1, 0)
    p = np.asarray(special.fdtrc(df1, df2, f), dtype=np.float64)
    return WelchAnova(f, df1, df2, p, np.sum(np.where(used, groups.count, 0), axis=1))


def games_howell(values: ArrayLike, confidence: float = 0.95) -> PairDifferences:
    """All pairs with their own variances and Welch's df against Tukey's range (Games and Howell 1976)."""
    groups = group_moments(values)
    used, per_mean = _variance_of_means(groups)
    first, second = pair_numbers(groups.count.shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = np.where(used[:, first] & used[:, second], per_mean[:, first] + per_mean[:, second], np.nan)
        share = per_mean**2 / (groups.count - 1)
        df = squared**2 / (share[:, first] + share[:, second])
        se = groups.to_data(np.sqrt(squared / 2))
        difference = groups.to_data(groups.offset[:, first] - groups.offset[:, second])
        difference = np.where((groups.count[:, first] > 0) & (groups.count[:, second] > 0), difference, np.nan)
        q = np.where(np.isnan(df), np.nan, np.abs(difference) / se)
    k = np.count_nonzero(used, axis=1)[:, None]
    reach = studentized_range.quantile(confidence, np.where(np.isnan(df), np.nan, k), df) * se
    return PairDifferences(
        method="Games-Howell",
        caution=f"family-wise error of the {first.size} pairs held approximately, variances may differ",
        statistic_name="q",
        first=first,
        second=second,
        difference=difference,
        low=difference - reach,
        high=difference + reach,
        statistic=q,
        df=df,
        p=studentized_range.survival(q, k, df),
        n=groups.count[:, first] + groups.count[:, second],
        confidence=confidence,
    )


def _variance_of_means(groups: GroupMoments) -> tuple[np.ndarray, Floats]:
    """Which groups (d, k) have two or more values, and the squared standard errors of their means, scaled unit."""
    used = groups.count > 1
    with np.errstate(divide="ignore", invalid="ignore"):
        return used, np.where(used, groups.squares / (groups.count - 1) / groups.count, np.nan)
