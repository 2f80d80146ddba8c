"""One-way analysis of variance, many designs in one call: the classical one, Welch's for unequal variances, and
of distances from the groups' medians, which is Brown and Forsythe's test of equal variances.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, sums_of, uniform
from emg2vsa.shown import shown
from emg2vsa.statistics.moments import GroupMoments, group_moments, unguarded_moments
from emg2vsa.statistics.outcome import Outcome, Outcomes


@dataclass(frozen=True)
class Anova:
    """d one-way designs of up to k groups; (d,) unless said, NaN where undefined.

    df1 : groups - 1, groups without a value left out. df2 : values - groups. sd : pooled within groups, in the unit of
    the data. eta2 : share of the sum of squares that lies between groups (biased upwards).
    mean, count : (d, k), of each group. offset : (d, k) means less the first value of the design, free of the rounding
    that an origin far away brings.
    """

    f: Floats = field(metadata=shown("F", digits=4))
    df1: Ints = field(metadata=shown("df 1"))
    df2: Ints = field(metadata=shown("df 2"))
    p: Floats = field(metadata=shown("p"))
    eta2: Floats = field(metadata=shown("η²"))
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
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        groups = unguarded_moments(values)
        count, offset, each, (d, k) = groups.counts, groups.offset, groups.each, groups.counts.shape
        if each:
            free1, free2 = k - 1, k * each - k
            df1, df2 = uniform(d, free1), uniform(d, free2)
            about = offset - (sums_of(offset) / k)[:, None]
            ss_between = each * np.vecdot(about, about)
        else:
            n, df1 = count.sum(axis=1), np.count_nonzero(count, axis=1) - 1
            df2 = n - df1 - 1
            free1, free2 = df1, df2
            about = offset - (np.vecdot(count, offset) / n)[:, None]
            ss_between = np.vecdot(count, about * about)
        ss_within = sums_of(groups.squares)
        ms_within = ss_within / free2  # 0 / 0 where no group has two values
        f = ss_between / free1 / ms_within
        eta2 = ss_between / (ss_between + ss_within)
    offset = groups.to_data(offset)
    if k < 2 or not each:
        f, eta2 = np.where(df1 > 0, f, np.nan), np.where(df1 > 0, eta2, np.nan)
        offset = np.where(count > 0, offset, np.nan)
    sd = groups.to_data(np.sqrt(ms_within))
    return Anova(f, df1, df2, np.asarray(special.fdtrc(df1, df2, f)), eta2, sd, groups.mean, count, offset)


def welch(values: ArrayLike) -> Outcomes:
    """Welch (1951) on ``values`` as ``one_way`` takes them; groups of one value are left out, they have no variance.

    A group without spread makes its weight infinite and the test undefined (NaN).
    """
    groups = group_moments(values)
    used, per_mean = variance_of_means(groups)
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = np.where(used, 1 / per_mean, 0.0)
        total = np.sum(weight, axis=1)
        k = np.count_nonzero(used, axis=1)
        grand = np.sum(weight * groups.offset, axis=1) / total
        between = np.sum(weight * (groups.offset - grand[:, None]) ** 2, axis=1) / (k - 1)
        spare = np.where(used, (1 - weight / total[:, None]) ** 2 / (groups.counts - 1), 0.0)
        lack = np.sum(spare, axis=1)
        f = between / (1 + 2 * (k - 2) * lack / (k**2 - 1))
        df2 = (k**2 - 1) / (3 * lack)
        f, df2 = np.where(k > 1, f, np.nan), np.where(k > 1, df2, np.nan)
    df1 = np.maximum(k - 1, 0)
    return Outcomes(
        method="Welch's analysis of variance",
        statistic_name="F",
        statistic=f,
        df=(df1, df2),
        p=np.asarray(special.fdtrc(df1, df2, f), dtype=np.float64),
        n=np.sum(np.where(used, groups.counts, 0), axis=1),
        notes=(("undefined: needs two groups of two or more values that are not all equal", np.isnan(f)),),
    )


def variance_of_means(groups: GroupMoments) -> tuple[np.ndarray, Floats]:
    """Which groups (d, k) have two or more values, and the squared standard errors of their means, scaled unit."""
    used = groups.counts > 1
    with np.errstate(divide="ignore", invalid="ignore"):
        return used, np.where(used, groups.squares / (groups.counts - 1) / groups.counts, np.nan)


def brown_forsythe(values: ArrayLike) -> Outcomes:
    """Brown and Forsythe's (1974) form of Levene's test; ``values`` as for ``one_way``.

    Two values are equally far from their median. A design without a group of three therefore has no scatter of these
    distances, and no test: F and p are NaN.
    """
    groups = group_moments(values)
    deviation = groups.deviation - _medians(groups.deviation, groups.valid)[..., None]
    anova = one_way(np.where(groups.valid, np.abs(deviation), np.nan))
    most = np.max(groups.counts, axis=1, initial=0)
    f, p = (np.where(most > 2, each, np.nan) for each in (anova.f, anova.p))
    several = anova.df1 > 0
    undefined = several & (most > 1) & np.isnan(f)
    alike = np.isnan(f) & ~undefined & several
    return Outcomes(
        method="Brown-Forsythe (distances from medians)",
        statistic_name="F",
        statistic=f,
        df=(anova.df1, anova.df2),
        p=p,
        n=np.sum(groups.counts, axis=1),
        notes=(
            *((f"undefined: {k} group(s) with values", anova.df1 == k - 1) for k in (0, 1)),
            ("undefined: no group has three values", undefined & (most == 2)),
            ("undefined: every value is equally far from the median of its group", undefined & (most > 2)),
            ("undefined: one value a group leaves no variance within groups", alike),
            ("the values within each group are equal: F is infinite", np.isinf(f)),
            ("groups of three values or fewer: next to no power", (most == 3) & ~undefined),
        ),
    )


def _medians(values: Floats, valid: np.ndarray) -> Floats:
    """(d, k) medians of the valid of ``values`` (d, k, n), 0 where there is none."""
    ordered = np.sort(np.where(valid, values, np.inf), axis=2)
    count = np.count_nonzero(valid, axis=2)[..., None]
    low = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=2)
    high = np.take_along_axis(ordered, np.minimum(count // 2, values.shape[2] - 1), axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(count > 0, (low + high) / 2, 0.0)[..., 0])
