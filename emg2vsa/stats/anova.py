"""One-way analysis of variance, many designs in one call.

Every group is shifted by one of its own values and then centred: on float64 input that reaches what exact arithmetic
on the same doubles gives for all of NIST's ANOVA sets (statistics notes 3a).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.stats.exact_shift import shifted_doubles
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
    doubles, origin = shifted_doubles(values)
    valid = np.isfinite(doubles)
    count = np.count_nonzero(valid, axis=2)
    filled = np.where(valid, doubles, 0.0)
    unit = exponent_of(np.max(np.abs(filled), axis=2))[:, 0] + 1
    filled = np.ldexp(filled, -unit[:, None, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        start, inner, deviation = _centred_groups(filled, valid, count)
        design_start = np.take_along_axis(start, np.argmax(count > 0, axis=1)[:, None], axis=1)
        offset = np.where(count > 0, start - design_start + inner, 0.0)
        n = np.sum(count, axis=1)
        grand = np.sum(count * offset, axis=1) / n
        ss_between = np.sum(count * (offset - grand[:, None]) ** 2, axis=1)
        ss_within = np.sum(deviation**2, axis=(1, 2))
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
        sd=np.ldexp(np.sqrt(ms_within), unit),
        mean=origin[:, None] + np.ldexp(np.where(count > 0, design_start + offset, np.nan), unit[:, None]),
        count=count,
    )


def _centred_groups(values: Floats, valid: np.ndarray, count: Ints) -> tuple[Floats, Floats, Floats]:
    """First value (d, k) of each group, mean relative to it (d, k), and deviations from the mean (d, k, n)."""
    start = np.take_along_axis(values, np.argmax(valid, axis=2)[..., None], axis=2)
    shifted = np.where(valid, values - start, 0.0)
    inner = np.sum(shifted, axis=2) / count
    return start[..., 0], inner, np.where(valid, shifted - inner[..., None], 0.0)
