"""Are two means equal within a margin: two one-sided t tests (Schuirmann 1987; Lakens 2017)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import SettingError
from emg2vsa.statistics.moments import GroupMoments, group_moments
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import check_two_groups, pair_numbers, student_quantile

MarginUnit = Literal["data", "sd"]


@dataclass(frozen=True, kw_only=True)
class Equivalence:
    """Tests of q contrasts of each of d designs; (d, q), NaN where undefined.

    difference, sd, df, n : of the two means, the pooled SD of their groups with its degrees of freedom, values that
    entered. margin : in the unit of the data. t, p : of the one-sided test with the larger p, which is the p of the
    whole. low, high : interval of the difference at 1 - 2 alpha, inside the margin exactly where p < alpha.
    """

    difference: Floats
    sd: Floats
    df: Floats
    n: Ints
    margin: Floats
    unit: MarginUnit
    alpha: float
    t: Floats
    p: Floats
    low: Floats
    high: Floats

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        """One comparison of design ``i`` alone."""
        at = (i, pair)
        defined = not np.isnan(self.p[at])
        return Outcome(
            method="TOST, pooled variance",
            n=int(self.n[at]),
            statistic_name="t",
            statistic=float(self.t[at]),
            df=(float(self.df[at]),),
            p=float(self.p[at]),
            estimate_name="difference of means",
            estimate=float(self.difference[at]),
            interval=(float(self.low[at]), float(self.high[at])),
            confidence=1 - 2 * self.alpha,
            effect_name="difference / SD",
            effect_size=float(self.difference[at] / self.sd[at]) if defined else float("nan"),
            notes=self._notes(float(self.margin[at]), defined),
        )

    def _notes(self, margin: float, defined: bool) -> tuple[str, ...]:
        if not defined:
            return ("undefined: too few values, or no spread, to estimate a standard error from",)
        notes = (f"null hypothesis: the difference is {margin:.4g} or more in size",)
        estimated = "margin in SDs of these data: p does not know that the SD is an estimate"
        return (*notes, estimated) if self.unit == "sd" else notes


def tost(values: ArrayLike, margin: float, unit: MarginUnit = "data", alpha: float = 0.05) -> Equivalence:
    """Every pair of groups of ``values`` (d, k, n), or of one design (k, n), against -margin and +margin.

    Student's t with the SD of the two groups alone. unit : "data", or "sd" for a margin in those SDs. alpha : level of
    each of the two tests. SettingError for a margin that is not positive and finite, or an alpha outside 0 to 1/2;
    DataError for another shape.
    """
    groups = group_moments(values)
    return _decide(groups, *pair_numbers(groups.counts.shape[1]), margin, unit, alpha)


def tost_in_parts(values: ArrayLike, margin: float, unit: MarginUnit, alpha: float) -> Iterator[Equivalence]:
    """``tost``, the pairs of each first group at a time: of many groups all would fill memory. SettingError as
    there."""
    groups = group_moments(values)
    k = groups.counts.shape[1]
    check_two_groups(k)
    for first in range(k - 1):
        second = np.arange(first + 1, k)
        yield _decide(groups, np.full(second.shape, first), second, margin, unit, alpha)


def _decide(
    groups: GroupMoments, first: Ints, second: Ints, margin: float, unit: MarginUnit, alpha: float
) -> Equivalence:
    where, do = "equivalence, margin", "Give such a margin."
    if not (np.isfinite(margin) and margin > 0):
        raise SettingError(where, wanted="a positive number", found=str(margin), do=do)
    if not 0 < alpha < 0.5:
        where, do = "equivalence, alpha", "Give such a level."
        raise SettingError(where, wanted="a level between 0 and 1/2", found=str(alpha), do=do)
    n1, n2 = groups.counts[:, first], groups.counts[:, second]
    both = (n1 > 0) & (n2 > 0)
    df = np.where(both & (n1 + n2 > 2), n1 + n2 - 2.0, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = (groups.squares[:, first] + groups.squares[:, second]) / df
        se = groups.to_data(np.sqrt(variance * (1 / n1 + 1 / n2)))
    sd, se = groups.to_data(np.sqrt(variance)), np.where(se > 0, se, np.nan)
    difference = groups.to_data(np.where(both, groups.offset[:, first] - groups.offset[:, second], np.nan))
    width = margin * sd if unit == "sd" else np.where(np.isnan(sd), np.nan, margin)
    # the side the difference leans to is the harder one to reject
    t = (np.abs(difference) - width) / se
    reach = student_quantile(df, 1 - alpha) * se
    return Equivalence(
        difference=difference,
        sd=sd,
        df=df,
        n=n1 + n2,
        margin=width,
        unit=unit,
        alpha=alpha,
        t=np.where(difference < 0, -t, t),
        p=np.where(np.isnan(se), np.nan, special.stdtr(df, t)),
        low=difference - reach,
        high=difference + reach,
    )
