"""Kruskal-Wallis on one-way designs, many in one call, and Dunn's test of all pairs of groups after it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, sums_of, unmasked
from emg2vsa.statistics.moments import common_count, shifted_doubles
from emg2vsa.statistics.multiplicity import adjust
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import pair_numbers


def midranks(values: ArrayLike) -> Floats:
    """Ranks 1, 2, ... along the last axis of ``values`` (..., n); ties share a mean rank, NaN stays NaN, uncounted. As
    Kruskal and Wallis (1952) rank."""
    rows = np.asarray(unmasked(values), dtype=np.float64)
    if rows.shape[-1] == 0:
        return rows.copy()
    table = rows.reshape(-1, rows.shape[-1])
    order = np.argsort(table, axis=1, kind="stable")  # NaN last; fast where parts are sorted already
    order += np.arange(0, table.size, table.shape[1])[:, None]
    ordered = table.ravel()[order]
    ranks = np.empty(rows.shape)
    rises = ordered.ravel()[1:] > ordered.ravel()[:-1]
    rises[table.shape[1] - 1 :: table.shape[1]] = True  # from one row to the next
    if np.count_nonzero(rises) == rises.size:  # neither ties nor, but for a row of one, NaN
        ranks.ravel()[order] = np.arange(1.0, table.shape[1] + 1)
        return ranks if table.shape[1] > 1 else ranks + 0 * rows
    first, last = _runs(ordered)
    ranks.ravel()[order] = np.where(np.isnan(ordered), np.nan, (first + last) / 2 + 1)
    return ranks


def _runs(ordered: Floats) -> tuple[Ints, Ints]:
    """First and last index of the run of equal values that each value of sorted rows (..., n) belongs to."""
    index = np.broadcast_to(np.arange(ordered.shape[-1]), ordered.shape)
    starts = np.ones(ordered.shape, dtype=np.bool_)
    np.not_equal(ordered[..., 1:], ordered[..., :-1], out=starts[..., 1:])
    ends = np.ones(ordered.shape, dtype=np.bool_)
    ends[..., :-1] = starts[..., 1:]
    first = np.maximum.accumulate(np.where(starts, index, 0), axis=-1)
    last = np.minimum.accumulate(np.where(ends, index, ordered.shape[-1])[..., ::-1], axis=-1)[..., ::-1]
    return first, last


@dataclass(frozen=True)
class KruskalWallis:
    """d designs of up to k groups; (d,) unless said, NaN where undefined.

    h : corrected for ties. df : groups with values less one. p : from chi squared. epsilon2 : H / (N - 1), of ranks.
    mean_rank, count : (d, k). rank_variance : of all ranks of a design,
    N (N + 1) / 12 without ties.
    """

    h: Floats
    df: Ints
    p: Floats
    epsilon2: Floats
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
    missing = np.isnan(doubles)
    gaps = np.count_nonzero(missing) > 0
    offset = midranks(doubles.reshape(d, k * n))
    count, total, groups = np.full((d, k), n), np.full(d, k * n), np.full(d, k)
    if gaps:
        count -= missing.sum(axis=2)
        total, groups = count.sum(axis=1), np.count_nonzero(count, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = (total[:, None] + 1) / 2 if gaps else (k * n + 1) / 2
        offset -= centre
        if gaps:
            offset[np.isnan(offset)] = 0.0
        mean_offset = sums_of(offset.reshape(d * k, n)).reshape(d, k) / count
        mean_rank, others = centre + mean_offset, total - 1
        rank_variance = np.vecdot(offset, offset) / others
        between = np.vecdot(count, np.where(count, mean_offset, 0.0) ** 2 if gaps else mean_offset**2)
        h = between / rank_variance
        if gaps or k < 2:
            h = np.where(groups > 1, h, np.nan)
        epsilon2 = h / others
    df = groups - 1
    p = special.chdtrc(np.maximum(df, 1.0), h)  # whole numbers would cost a cast of each
    return KruskalWallis(h, df, p, epsilon2, mean_rank, count, rank_variance)


@dataclass(frozen=True)
class RankPairs:
    """All q pairs of k groups of d designs; first, second (q,); difference of mean ranks, z, p, n (d, q)."""

    first: Ints
    second: Ints
    difference: Floats
    z: Floats
    p: Floats
    n: Ints

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        return Outcome(
            method="Dunn on pooled mean ranks, Bonferroni",
            n=int(self.n[i, pair]),
            statistic_name="z",
            statistic=float(self.z[i, pair]),
            p=float(self.p[i, pair]),
            estimate_name="difference of mean ranks",
            estimate=float(self.difference[i, pair]),
            notes=(
                f"one of {self.first.size} pairs, Bonferroni; ranks pooled over all groups",
                *(("undefined: a group has no values, or all values are equal",) if np.isnan(self.p[i, pair]) else ()),
            ),
        )


def dunn(found: KruskalWallis) -> RankPairs:
    """Dunn (1964), corrected for ties, Bonferroni's p, as MATLAB's multcompare after kruskalwallis (paper, VI)."""
    first, second = pair_numbers(found.mean_rank.shape[1])
    difference = found.mean_rank.take(first, axis=1) - found.mean_rank.take(second, axis=1)
    variance = found.rank_variance[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        if each := common_count(found.count):
            variance, n = variance * (2 / each), np.full(difference.shape, 2 * each)
        else:
            n1, n2 = found.count[:, first], found.count[:, second]
            variance, n = variance * (1 / n1 + 1 / n2), n1 + n2
        z = difference / np.sqrt(variance)
    return RankPairs(first, second, difference, z, adjust(2 * special.ndtr(-np.abs(z)), "bonferroni"), n)


def smallest_worst_p(groups: int, count: int) -> tuple[float, float]:
    """Smallest value that the largest p of all pairs can take with ``groups`` of ``count`` untied values each:
    uncorrected, and by Bonferroni.

    Mean ranks of equal groups span at most (groups - 1) count, so some neighbours lie no farther apart than count: the
    best case is groups that do not overlap at all. A smaller p cannot come from this test. NaN
    for fewer than two groups. With unequal groups no such simple bound holds.
    """
    if groups < 2 or count < 1:
        return float("nan"), float("nan")
    total = groups * count
    p = float(2 * special.ndtr(-count / np.sqrt(total * (total + 1) / 12 * 2 / count)))
    return p, min(p * (groups * (groups - 1) // 2), 1.0)
