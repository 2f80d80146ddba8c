"""Kruskal-Wallis on one-way designs, many in one call."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.exact_shift import shifted_doubles
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.ranks import midranks


@dataclass(frozen=True)
class KruskalWallis:
    """d designs of up to k groups; (d,) unless said, NaN where undefined.

    h : corrected for ties. df : groups with values less one. p : from chi squared. epsilon2 : H / (N - 1), of ranks.
    eta2_h : (H - k + 1) / (N - k). mean_rank, count : (d, k). rank_variance : of all ranks of a design,
    N (N + 1) / 12 without ties.
    """

    h: Floats
    df: Ints
    p: Floats
    epsilon2: Floats
    eta2_h: Floats
    mean_rank: Floats
    count: Ints
    rank_variance: Floats

    def outcome(self, i: int = 0) -> Outcome:
        return Outcome(
            method="Kruskal-Wallis, corrected for ties",
            n=int(np.sum(self.count[i])),
            statistic_name="H",
            statistic=float(self.h[i]),
            df=(float(self.df[i]),),
            p=float(self.p[i]),
            effect_name="rank epsilon2",
            effect_size=float(self.epsilon2[i]),
            notes=self._notes(i),
        )

    def _notes(self, i: int) -> tuple[str, ...]:
        if self.df[i] < 1:
            return (f"undefined: {self.df[i] + 1} group(s) with values",)
        if np.isnan(self.h[i]):
            return ("undefined: all values are equal",)
        small = int(np.min(self.count[i][self.count[i] > 0]))
        return (f"p from chi squared, rough for groups of {small}",) if small < 5 else ()


def kruskal(values: ArrayLike) -> KruskalWallis:
    """Kruskal and Wallis (1952) on ``values`` (d, k groups, n a group), or one design (k, n); NaN: no value there."""
    doubles, _ = shifted_doubles(values)
    d, k, n = doubles.shape
    doubles = np.where(np.isfinite(doubles), doubles, np.nan)
    ranks = midranks(doubles.reshape(d, k * n)).reshape(d, k, n)
    valid = ~np.isnan(ranks)
    count = valid.sum(axis=2)
    total = count.sum(axis=1)
    groups = np.count_nonzero(count, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = (total + 1) / 2
        offset = np.where(valid, ranks - centre[:, None, None], 0.0)
        mean_offset = offset.sum(axis=2) / np.maximum(count, 1)
        mean_rank = np.where(count > 0, centre[:, None] + mean_offset, np.nan)
        rank_variance = (offset**2).sum(axis=(1, 2)) / (total - 1)
        between = np.vecdot(count, mean_offset**2)
        h = np.where(groups > 1, between / rank_variance, np.nan)
        eta2_h = (h - groups + 1) / np.where(total > groups, total - groups, np.nan)
        epsilon2 = h / (total - 1)
    df = groups - 1
    p = special.chdtrc(np.maximum(df, 1), h)
    return KruskalWallis(h, df, p, epsilon2, eta2_h, mean_rank, count, rank_variance)
