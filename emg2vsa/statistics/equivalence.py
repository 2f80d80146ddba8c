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
from emg2vsa.statistics.moments import GroupMoments, group_moments, shifted_doubles
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import check_two_groups, pair_numbers

Kind = Literal["pooled", "welch", "paired"]
MarginUnit = Literal["data", "sd"]


@dataclass(frozen=True, kw_only=True)
class Contrasts:
    """q differences of each of d designs, in the unit of the data; (d, q) unless said, NaN where undefined.

    sd : what a standardised difference is measured by. se : standard error with df degrees of freedom. n : values that
    entered.
    """

    difference: Floats
    se: Floats
    sd: Floats
    df: Floats
    n: Ints


@dataclass(frozen=True, kw_only=True)
class Equivalence:
    """Tests of q contrasts of each of d designs; (d, q), NaN where undefined.

    margin : in the unit of the data. t, p : of the one-sided test with the larger p, which is the p of the whole.
    low, high : interval of the difference at 1 - 2 alpha, inside the margin exactly where p < alpha.
    """

    variant: str
    of: Contrasts
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
            method=f"TOST, {self.variant}",
            n=int(self.of.n[at]),
            statistic_name="t",
            statistic=float(self.t[at]),
            df=(float(self.of.df[at]),),
            p=float(self.p[at]),
            estimate_name="difference of means",
            estimate=float(self.of.difference[at]),
            interval=(float(self.low[at]), float(self.high[at])),
            confidence=1 - 2 * self.alpha,
            effect_name="difference / SD",
            effect_size=float(self.of.difference[at] / self.of.sd[at]) if defined else float("nan"),
            notes=self._notes(float(self.margin[at]), defined),
        )

    def _notes(self, margin: float, defined: bool) -> tuple[str, ...]:
        if not defined:
            return ("undefined: too few values, or no spread, to estimate a standard error from",)
        notes = (f"null hypothesis: the difference is {margin:.4g} or more in size",)
        estimated = "margin in SDs of these data: p does not know that the SD is an estimate"
        return (*notes, estimated) if self.unit == "sd" else notes


def tost(
    values: ArrayLike, margin: float, kind: Kind = "pooled", unit: MarginUnit = "data", alpha: float = 0.05
) -> Equivalence:
    """Every pair of groups of ``values`` (d, k, n), or of one design (k, n), against -margin and +margin.

    pooled : Student's t with the SD of the two groups alone. welch : variances may differ; the SD is the root of their
    mean. paired : value by value, pairs with a NaN left out; the SD is that of the differences. unit : "data", or "sd"
    for a margin in those SDs. alpha : level of each of the two tests. SettingError for a margin that is not positive
    and finite, an alpha outside 0 to 1/2, or an unknown kind; DataError for another shape.
    """
    variants = {"pooled": "pooled variance", "welch": "Welch", "paired": "paired"}
    if kind not in variants:
        do = f"Choose one of {', '.join(variants)}."
        raise SettingError("equivalence, kind", wanted="a known kind", found=repr(kind), do=do)
    doubles, _ = shifted_doubles(values)
    pairs = pair_numbers(doubles.shape[1])
    if kind == "paired":
        contrasts = _paired(doubles, *pairs)
    else:
        contrasts = _two_sample(group_moments(doubles), *pairs, welch=kind == "welch")
    return _decide(contrasts, variants[kind], margin, unit, alpha)


def tost_in_parts(values: ArrayLike, margin: float, unit: MarginUnit, alpha: float) -> Iterator[Equivalence]:
    """``tost`` with pooled variance, the pairs of each first group at a time: of many groups all would fill memory."""
    doubles, _ = shifted_doubles(values)
    groups = group_moments(doubles)
    check_two_groups(doubles.shape[1])
    for first in range(doubles.shape[1] - 1):
        second = np.arange(first + 1, doubles.shape[1])
        contrasts = _two_sample(groups, np.full(second.shape, first), second, welch=False)
        yield _decide(contrasts, "pooled variance", margin, unit, alpha)


def _two_sample(groups: GroupMoments, first: Ints, second: Ints, *, welch: bool) -> Contrasts:
    n1, n2 = groups.count[:, first], groups.count[:, second]
    both = (n1 > 0) & (n2 > 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        if welch:
            own = groups.squares / np.where(groups.count > 1, groups.count - 1, np.nan)
            of_mean = own / groups.count
            se2, variance = of_mean[:, first] + of_mean[:, second], (own[:, first] + own[:, second]) / 2
            spare = of_mean**2 / (groups.count - 1)
            df = se2**2 / (spare[:, first] + spare[:, second])
        else:
            df = np.where(both & (n1 + n2 > 2), n1 + n2 - 2.0, np.nan)
            variance = (groups.squares[:, first] + groups.squares[:, second]) / df
            se2 = variance * (1 / n1 + 1 / n2)
    difference = np.where(both, groups.offset[:, first] - groups.offset[:, second], np.nan)
    return Contrasts(
        difference=groups.to_data(difference),
        se=groups.to_data(np.sqrt(se2)),
        sd=groups.to_data(np.sqrt(variance)),
        df=df,
        n=n1 + n2,
    )


def _paired(values: Floats, first: Ints, second: Ints) -> Contrasts:
    finite = np.where(np.isfinite(values), values, np.nan)
    differences = finite[:, first] - finite[:, second]
    groups = group_moments(differences)
    df = np.where(groups.count > 1, groups.count - 1.0, np.nan)
    sd = np.sqrt(groups.squares / df)
    with np.errstate(divide="ignore", invalid="ignore"):
        se = sd / np.sqrt(groups.count)
    return Contrasts(
        difference=groups.mean,
        se=groups.to_data(se),
        sd=groups.to_data(sd),
        df=df,
        n=groups.count,
    )


def _decide(of: Contrasts, variant: str, margin: float, unit: MarginUnit, alpha: float) -> Equivalence:
    if not (np.isfinite(margin) and margin > 0):
        raise SettingError(
            "equivalence, margin", wanted="a positive number", found=str(margin), do="Give such a margin."
        )
    if not 0 < alpha < 0.5:
        raise SettingError(
            "equivalence, alpha", wanted="a level between 0 and 1/2", found=str(alpha), do="Give such a level."
        )
    se = np.where(of.se > 0, of.se, np.nan)
    width = margin * of.sd if unit == "sd" else np.where(np.isnan(of.sd), np.nan, margin)
    # the side the difference leans to is the harder one to reject
    t = (np.abs(of.difference) - width) / se
    known, of_known = np.unique(of.df, return_inverse=True)  # few, and the quantile is slow
    reach = special.stdtrit(known, 1 - alpha)[of_known].reshape(se.shape) * se
    return Equivalence(
        variant=variant,
        of=of,
        margin=width,
        unit=unit,
        alpha=alpha,
        t=np.where(of.difference < 0, -t, t),
        p=np.where(np.isnan(se), np.nan, special.stdtr(of.df, t)),
        low=of.difference - reach,
        high=of.difference + reach,
    )
