"""One-way analysis of variance, many designs in one call; of distances from the groups' centres it is Levene's test."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.moments import group_moments
from emg2vsa.statistics.outcome import Outcome


@dataclass(frozen=True)
class Anova:
    """d one-way designs of up to k groups; (d,) unless said, NaN where undefined.

    df1 : groups - 1, groups without a value left out. df2 : values - groups. sd : pooled within groups, in the unit of
    the data. eta2 : share of the sum of squares that lies between groups (biased upwards).
    mean, count : (d, k), of each group. offset : (d, k) means less the first value of the design, free of the rounding
    that an origin far away brings.
    """

    f: Floats
    df1: Ints
    df2: Ints
    p: Floats
    eta2: Floats
    sd: Floats
    mean: Floats
    count: Ints
    offset: Floats

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
    groups = group_moments(values)
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
        offset=np.where(count > 0, groups.to_data(groups.offset), np.nan),
    )


@dataclass(frozen=True)
class VarianceTests:
    """Analysis of variance of the distances from each group's median; F and p are NaN where no group can tell."""

    anova: Anova

    def outcome(self, i: int = 0) -> Outcome:
        found = self.anova.outcome(i)
        most = int(np.max(self.anova.count[i], initial=0))
        notes = found.notes
        if np.isnan(self.anova.f[i]) and most > 1 and self.anova.df1[i] > 0:
            alike = "every value is equally far from the median of its group"
            notes = ("undefined: no group has three values" if most == 2 else f"undefined: {alike}",)
        elif most == 3:
            notes = (*notes, "groups of three values or fewer: next to no power")
        return Outcome(
            method="Brown-Forsythe (distances from medians)",
            n=found.n,
            statistic_name="F",
            statistic=found.statistic,
            df=found.df,
            p=found.p,
            notes=notes,
        )


def brown_forsythe(values: ArrayLike) -> VarianceTests:
    """Brown and Forsythe's (1974) form of Levene's test; ``values`` as for ``one_way``.

    Two values are equally far from their median. A design without a group of three therefore has no scatter of these
    distances, and no test: F and p are NaN.
    """
    groups = group_moments(values)
    deviation = groups.deviation - _medians(groups.deviation, groups.valid)[..., None]
    anova = one_way(np.where(groups.valid, np.abs(deviation), np.nan))
    tells = np.max(groups.count, axis=1, initial=0) > 2
    return VarianceTests(replace(anova, f=np.where(tells, anova.f, np.nan), p=np.where(tells, anova.p, np.nan)))


def _medians(values: Floats, valid: np.ndarray) -> Floats:
    """(d, k) medians of the valid of ``values`` (d, k, n), 0 where there is none."""
    ordered = np.sort(np.where(valid, values, np.inf), axis=2)
    count = np.count_nonzero(valid, axis=2)[..., None]
    low = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=2)
    high = np.take_along_axis(ordered, np.minimum(count // 2, values.shape[2] - 1), axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(count > 0, (low + high) / 2, 0.0)[..., 0])
