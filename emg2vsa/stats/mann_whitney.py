"""Two groups by their ranks: Wilcoxon-Mann-Whitney, exact with ties, for all pairs of groups of many designs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.stats.exact_shift import shifted_doubles
from emg2vsa.stats.hodges_lehmann import differences_at
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.pair_differences import pair_numbers
from emg2vsa.stats.rank_sum_law import MOST_EXACT, rank_sum_p, shift_reach
from emg2vsa.stats.ranks import midranks

Method = Literal["exact", "normal", "normal, continuity"]


@dataclass(frozen=True)
class MannWhitney:
    """All q pairs of k groups of d designs; first, second (q,), the rest (d, q). NaN where undefined.

    u : pairs of values of which the first group's is larger, ties count half. p : two-sided. rank_biserial :
    2 U / (n1 n2) - 1. shift : Hodges-Lehmann, the median difference, with its interval low to high at ``confidence``.
    """

    method: Method
    first: Ints
    second: Ints
    u: Floats
    p: Floats
    rank_biserial: Floats
    shift: Floats
    low: Floats
    high: Floats
    n1: Ints
    n2: Ints
    confidence: float

    def outcome(self, i: int = 0, pair: int = 0) -> Outcome:
        large = self.n1[i, pair] + self.n2[i, pair] > MOST_EXACT
        used = "normal" if large and self.method == "exact" else self.method
        note = f"more than {MOST_EXACT} values: normal instead of exact" if used != self.method else ""
        return Outcome(
            method=f"Mann-Whitney, {used}" + (" (all permutations, ties kept)" if used == "exact" else ""),
            n=int(self.n1[i, pair] + self.n2[i, pair]),
            statistic_name="U",
            statistic=float(self.u[i, pair]),
            p=float(self.p[i, pair]),
            estimate_name="Hodges-Lehmann shift",
            estimate=float(self.shift[i, pair]),
            interval=(float(self.low[i, pair]), float(self.high[i, pair])),
            confidence=self.confidence,
            effect_name="rank-biserial",
            effect_size=float(self.rank_biserial[i, pair]),
            notes=(note,) if note else (),
        )


def mann_whitney(values: ArrayLike, method: Method = "exact", confidence: float = 0.95) -> MannWhitney:
    """Test every pair of groups of ``values`` (d, k, n), or of one design (k, n); NaN: no value there.

    exact : P(|U - mean| >= |u - mean|) over all ways to deal the observed, possibly tied, values out; for more than 100
    values the normal form. normal : variance corrected for ties, which for two groups is Kruskal-Wallis.
    """
    doubles, _ = shifted_doubles(values)
    doubles = np.where(np.isfinite(doubles), doubles, np.nan)
    first, second = pair_numbers(doubles.shape[1])
    left, right = doubles[:, first], doubles[:, second]
    n1, n2 = (np.count_nonzero(~np.isnan(side), axis=2) for side in (left, right))
    ranks = midranks(np.concatenate([left, right], axis=2))
    own = ranks[..., : left.shape[2]]
    rank_sum = np.sum(own, axis=2, where=~np.isnan(own))
    u = np.where((n1 > 0) & (n2 > 0), rank_sum - n1 * (n1 + 1) / 2, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        biserial = 2 * u / (n1 * n2) - 1
        p = _normal_p(u, ranks, n1, n2, continuity=method == "normal, continuity")
    if method == "exact":
        p = _exact_p(p, ranks, rank_sum, n1, n2)
    shift, low, high = _shift(left, right, n1, n2, confidence)
    return MannWhitney(method, first, second, u, p, biserial, shift, low, high, n1, n2, confidence)


def _normal_p(u: Floats, ranks: Floats, n1: Ints, n2: Ints, *, continuity: bool) -> Floats:
    total = n1 + n2
    centred = ranks - ((total + 1) / 2)[..., None]
    variance = np.sum(centred**2, axis=2, where=~np.isnan(ranks)) * n1 * n2 / (total * (total - 1.0))
    distance = np.abs(u - n1 * n2 / 2)
    if continuity:
        distance = np.maximum(distance - 0.5, 0.0)
    return np.asarray(2 * special.ndtr(-distance / np.sqrt(variance)))


def _exact_p(p: Floats, ranks: Floats, rank_sum: Floats, n1: Ints, n2: Ints) -> Floats:
    """``p`` with the exact one where the groups are small enough; equal tie patterns share one distribution."""
    exact = p.copy()
    small = (n1 > 0) & (n2 > 0) & (n1 + n2 <= MOST_EXACT)
    patterns: dict[tuple[int, bytes], list[tuple[int, int]]] = {}
    for i, j in np.argwhere(small):
        row = ranks[i, j]
        doubled = np.sort(np.rint(2 * row[~np.isnan(row)]).astype(np.int64))
        patterns.setdefault((int(n1[i, j]), doubled.tobytes()), []).append((i, j))
    for (size, pattern), places in patterns.items():
        at = tuple(np.transpose(places))
        doubled = np.frombuffer(pattern, dtype=np.int64)
        exact[at] = rank_sum_p(np.rint(2 * rank_sum[at]).astype(np.int64), doubled, size)
    return exact


def _shift(left: Floats, right: Floats, n1: Ints, n2: Ints, confidence: float) -> tuple[Floats, Floats, Floats]:
    """Median of all differences, and the differences between which the interval lies (Hodges and Lehmann 1963)."""
    count = n1 * n2
    reach = shift_reach(n1, n2, confidence)
    places = np.stack([(count - 1) // 2, count // 2, reach, count - 1 - reach]).astype(np.int64)
    found = np.where(count > 0, differences_at(left, right, places), np.nan)
    low, high = np.where(reach >= 0, found[2], -np.inf), np.where(reach >= 0, found[3], np.inf)
    return (found[0] + found[1]) / 2, low, high
