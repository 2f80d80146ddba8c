"""One-way analysis of variance, many designs in one call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.group_moments import GroupMoments, group_moments
from emg2vsa.stats.outcome import Outcome


@dataclass(frozen=True)
class Anova:
    """d one-way designs of up to k groups; (d,) unless said, NaN where undefined.

    df1 : groups - 1, groups without a value left out. df2 : values - groups. sd : pooled within groups, in the unit of
    the data. eta2 : share of the sum of squares that lies between groups (biased upwards).
    mean, count : (d, k), of each group.
    """

    f: Floats
    df1: Ints
    df2: Ints
    p: Floats
    eta2: Floats
    sd: Floats
    mean: Floats
    count: Ints

    def outcome(self, i: int = 0) -> Outcome:
        """Design ``i`` alone."""
        return Outcome(
            method="one-way ANOVA",
            n=int(np.sum(self.count[i])),
            statistic_name="F",
            statistic=float(self.f[i]),
            df=(float(self.df1[i]), float(self.df2[i])),
            p=float(self.p[i]),
            effect_name="eta2",
            effect_size=float(self.eta2[i]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        if self.df1[i] < 1:
            return (f"undefined: {self.df1[i] + 1} group(s) with values",)
        if self.df2[i] < 1:
            return ("undefined: one value a group leaves no variance within groups",)
        if np.isnan(self.f[i]):
            return ("undefined: all values are equal",)
        if self.sd[i] == 0:
            return ("the values within each group are equal: F is infinite",)
        return ()


def one_way(values: ArrayLike) -> Anova:
    """Analysis of variance of ``values`` (d, k groups, n a group), or of one design (k, n); NaN: no value there.

    Decimal, Fraction and int objects are accepted (None: no value): their differences are taken exactly, which float64
    cannot do for numbers like 1000000000000.4. Values all equal give F = NaN; groups constant but different give
    F = inf and p = 0. DataError for another shape.
    """
    return anova_of(group_moments(values))


def anova_of(groups: GroupMoments) -> Anova:
    """The same from moments that are already there."""
    count = groups.count
    with np.errstate(divide="ignore", invalid="ignore"):
        n = count.sum(axis=1)
        grand = np.vecdot(count, groups.offset) / n
        ss_between = np.vecdot(count, (groups.offset - grand[:, None]) ** 2)
        ss_within = groups.squares.sum(axis=1)
        df1 = np.count_nonzero(count, axis=1) - 1
        df2 = n - df1 - 1
        ms_within = ss_within / np.where(df2 > 0, df2, np.nan)
        f = ss_between / np.where(df1 > 0, df1, np.nan) / ms_within
        eta2 = np.where(df1 > 0, ss_between / (ss_between + ss_within), np.nan)
    return Anova(
        f=f,
        df1=df1,
        df2=df2,
        p=special.fdtrc(df1, df2, f),
        eta2=eta2,
        sd=groups.to_data(np.sqrt(ms_within)),
        mean=groups.mean,
        count=count,
    )
