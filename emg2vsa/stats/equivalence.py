"""Are two means equal within a margin: two one-sided t tests (Schuirmann 1987; Lakens 2017)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.errors import SettingError
from emg2vsa.stats.exact_shift import shifted_doubles
from emg2vsa.stats.group_moments import GroupMoments, group_moments
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.pair_differences import pair_numbers

Kind = Literal["pooled", "welch", "paired"]
MarginUnit = Literal["data", "sd"]
_TITLE = {"pooled": "pooled variance", "welch": "Welch", "paired": "paired", "one sample": "one sample"}


@dataclass(frozen=True, kw_only=True)
class Equivalence:
    """q comparisons of each of d designs; (d, q) unless said, NaN where undefined.

    first, second : (q,) group numbers; of one-sample tests the group twice. difference : mean of the first minus that
    of the second, or minus the reference. margin : in the unit of the data. sd : what the margin is measured by. t : of
    the one-sided test further from equivalence, p its p. low, high : interval of the difference at 1 - 2 alpha, inside
    the margin exactly where p < alpha. n : values that entered.
    """

    kind: str
    unit: MarginUnit
    alpha: float
    first: Ints
    second: Ints
    difference: Floats
    margin: Floats
    sd: Floats
    t: Floats
    df: Floats
    p: Floats
    low: Floats
    high: Floats
    n: Ints

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        """One comparison of design ``i`` alone."""
        with np.errstate(divide="ignore", invalid="ignore"):
            effect = self.difference[i, pair] / self.sd[i, pair]
        return Outcome(
            method=f"TOST, {_TITLE[self.kind]}",
            n=int(self.n[i, pair]),
            statistic_name="t",
            statistic=float(self.t[i, pair]),
            df=(float(self.df[i, pair]),),
            p=float(self.p[i, pair]),
            estimate_name="difference of means" if self.kind != "one sample" else "mean minus reference",
            estimate=float(self.difference[i, pair]),
            interval=(float(self.low[i, pair]), float(self.high[i, pair])),
            confidence=1 - 2 * self.alpha,
            effect_name="difference / SD",
            effect_size=float(effect),
            notes=self._notes(i, pair),
        )

    def _notes(self, i: int, pair: int) -> tuple[str, ...]:
        notes: tuple[str, ...] = (f"null hypothesis: the means differ by {self.margin[i, pair]:.4g} or more",)
        if self.unit == "sd":
            notes += ("margin in SDs of these data: p does not know that the SD is an estimate",)
        if np.isnan(self.p[i, pair]):
            notes += ("undefined: needs values to estimate a variance from, and a spread or a difference",)
        return notes


def tost(
    values: ArrayLike, margin: float, kind: Kind = "pooled", unit: MarginUnit = "data", alpha: float = 0.05
) -> Equivalence:
    """Every pair of groups of ``values`` (d, k, n), or of one design (k, n), against -margin and +margin.

    pooled : Student's t, the SD of the two groups alone. welch : variances may differ; the SD is the root of their
    mean. paired : value by value, pairs with a NaN left out; the SD is that of the differences. unit : "data", or "sd"
    for a margin in those SDs. alpha : level of each of the two tests. SettingError for a margin that is not positive
    and finite, or alpha outside 0 to 1/2.
    """
    first, second = pair_numbers(np.shape(values)[-2] if np.ndim(values) >= 2 else 0)
    if kind == "paired":
        doubles, _ = shifted_doubles(values)
        with np.errstate(invalid="ignore", over="ignore"):
            differences = doubles[:, first] - doubles[:, second]
        return _one_sample(differences, margin, 0.0, "paired", unit, alpha, (first, second))
    groups = group_moments(values)
    count, (n1, n2) = groups.count, (groups.count[:, first], groups.count[:, second])
    with np.errstate(divide="ignore", invalid="ignore"):
        if kind == "pooled":
            df = np.where((n1 > 0) & (n2 > 0), n1 + n2 - 2.0, np.nan)
            variance = (groups.squares[:, first] + groups.squares[:, second]) / df
            se = np.sqrt(variance * (1 / n1 + 1 / n2))
        else:
            own = np.where(count > 1, groups.squares / (count - 1), np.nan)
            variance = (own[:, first] + own[:, second]) / 2
            a, b = own[:, first] / n1, own[:, second] / n2
            se = np.sqrt(a + b)
            df = np.where(se > 0, (a + b) ** 2 / (a**2 / (n1 - 1) + b**2 / (n2 - 1)), n1 + n2 - 2.0)
    scaled = groups.offset[:, first] - groups.offset[:, second]
    return _decide(groups, scaled, np.sqrt(variance), se, df, n1 + n2, margin, kind, unit, alpha, (first, second))


def tost_one_sample(
    values: ArrayLike, margin: float, reference: float = 0.0, unit: MarginUnit = "data", alpha: float = 0.05
) -> Equivalence:
    """Mean of every group of ``values`` (d, k, n), or (k, n), against reference - margin and reference + margin."""
    doubles, origin = shifted_doubles(values)
    each = np.arange(doubles.shape[1])
    return _one_sample(doubles + (origin - reference)[:, None, None], margin, 0.0, "one sample", unit, alpha, (each, each))
