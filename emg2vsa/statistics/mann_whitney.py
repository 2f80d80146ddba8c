"""Two groups by their ranks: Wilcoxon-Mann-Whitney, exact with ties, for all pairs of groups of many designs.

The exact law of the rank sum of one of two groups, ties included, counts every way to deal the ranks out. The shift of
Hodges and Lehmann is the median of all differences; where they are many, not all are written down: how many are up to v
takes one search of the sorted samples.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.statistics.kruskal import midranks
from emg2vsa.statistics.moments import shifted_doubles
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.post_hoc import pair_numbers

MOST_EXACT = 100
"""Values of both groups together up to which counting is done."""
_FEW = 1 << 14
"""Differences of a pair that are sorted together with those of all other pairs."""
_A_VALUE, _MANY = 2, 1 << 18
"""Differences that are sorted at once, for each value of a larger pair and at most: a further count costs as much."""

_SKETCHED = 64
"""Values of each sample whose differences tell where a search begins."""


@dataclass(frozen=True)
class MannWhitney:
    """All q pairs of k groups of d designs, as ``pair_numbers`` has them; (d, q), NaN where undefined.

    u : pairs of values of which the first group's is larger, ties count half. p : two-sided. rank_biserial :
    2 U / (n1 n2) - 1. shift : Hodges-Lehmann, the median difference, with its interval low to high at ``confidence``.
    """

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
        return Outcome(
            method="Mann-Whitney, " + ("normal" if large else "exact (all permutations, ties kept)"),
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
            notes=self._notes(i, pair, large),
        )

    def _notes(self, i: int, pair: int, large: bool) -> tuple[str, ...]:
        if np.isnan(self.p[i, pair]):
            return ("undefined: a group has no values",)
        return (f"more than {MOST_EXACT} values: normal instead of exact",) if large else ()


def mann_whitney(values: ArrayLike, confidence: float = 0.95) -> MannWhitney:
    """Test every pair of groups of ``values`` (d, k, n), or of one design (k, n); NaN: no value there.

    p is exact, P(|U - mean| >= |u - mean|) over all ways to deal the observed, possibly tied, values out; for more than
    100 values normal, with the variance corrected for ties, which for two groups is Kruskal-Wallis.
    """
    doubles, _ = shifted_doubles(values)
    doubles = np.sort(doubles, axis=2)  # once, not for every pair
    first, second = pair_numbers(doubles.shape[1])
    left, right = doubles.take(first, axis=1), doubles.take(second, axis=1)
    count = np.count_nonzero(doubles == doubles, axis=2)
    n1, n2 = count.take(first, axis=1), count.take(second, axis=1)
    ranks = midranks(np.concatenate([left, right], axis=2))
    rank_sum, scatter = _sums_of_ranks(ranks, left.shape[2], n1, n2)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.where(n1 * n2 > 0, rank_sum - n1 * (n1 + 1) / 2, np.nan)
        biserial = 2 * u / (n1 * n2) - 1
        p = _p(u, ranks, scatter, n1, n2)
    shift, low, high = _shift(left, right, n1, n2, confidence)
    return MannWhitney(u, p, biserial, shift, low, high, n1, n2, confidence)


def _sums_of_ranks(ranks: Floats, n: int, n1: Ints, n2: Ints) -> tuple[Floats, Floats]:
    """Of pairs (d, q): the sum of the first n ranks, which are whole or halves, and of squares about their mean."""
    centred = ranks - ((n1 + n2 + 1) / 2)[..., None]
    if np.any(n1 + n2 < ranks.shape[2]):
        ranks, centred = np.nan_to_num(ranks), np.nan_to_num(centred)
    return np.einsum("ijk->ij", ranks[..., :n]), np.einsum("ijk,ijk->ij", centred, centred)


def _p(u: Floats, ranks: Floats, scatter: Floats, n1: Ints, n2: Ints) -> Floats:
    """Exact where the groups are small enough: without ties by the law of U, else by that of the pattern of ties."""
    total = n1 + n2
    exact = (n1 * n2 > 0) & (total <= MOST_EXACT)
    tied = exact & (scatter < (total**3 - total) / 12)
    p = np.empty(u.shape) if exact.all() else _normal_p(u, scatter, n1, n2)
    for size1, size2, at in _by_sizes(n1, n2, exact & ~tied):
        p[at] = _p_without_ties(size1, size2)[u[at].astype(np.int64)]
    return _with_ties(p, u, ranks, tied, n1) if np.count_nonzero(tied) else p


def _by_sizes(n1: Ints, n2: Ints, among: NDArray[np.bool_]) -> Iterator[tuple[int, int, NDArray[np.bool_]]]:
    """Each two sizes of groups ``among`` (d, q), and which pairs have them."""
    for size1, size2 in set(zip(n1[among].tolist(), n2[among].tolist(), strict=True)):
        yield size1, size2, among & (n1 == size1) & (n2 == size2)


def _normal_p(u: Floats, scatter: Floats, n1: Ints, n2: Ints) -> Floats:
    total = n1 + n2
    variance = scatter * n1 * n2 / (total * (total - 1.0))
    return np.asarray(2 * special.ndtr(-np.abs(u - n1 * n2 / 2) / np.sqrt(variance)))


@lru_cache(maxsize=256)
def _p_without_ties(n1: int, n2: int) -> Floats:
    """Two-sided p (n1 n2 + 1,) of U = 0, 1, ..."""
    return _rank_sum_p(n1 * (n1 + 1) + 2 * np.arange(n1 * n2 + 1), 2 * np.arange(1, n1 + n2 + 1), n1)


def _with_ties(p: Floats, u: Floats, ranks: Floats, tied: NDArray[np.bool_], n1: Ints) -> Floats:
    """``p`` with the exact one of the ``tied`` pairs; equal patterns of ties share one law."""
    patterns: dict[tuple[int, bytes], list[tuple[int, int]]] = {}
    for i, j in np.argwhere(tied):
        row = ranks[i, j]
        doubled = np.sort(np.rint(2 * row[~np.isnan(row)]).astype(np.int64))
        patterns.setdefault((int(n1[i, j]), doubled.tobytes()), []).append((i, j))
    for (size, pattern), places in patterns.items():
        at = tuple(np.transpose(places))
        doubled_sum = np.rint(2 * u[at]).astype(np.int64) + size * (size + 1)
        p[at] = _rank_sum_p(doubled_sum, np.frombuffer(pattern, dtype=np.int64), size)
    return p


def _shift(left: Floats, right: Floats, n1: Ints, n2: Ints, confidence: float) -> tuple[Floats, Floats, Floats]:
    """Median of all differences, and the differences between which the interval lies (Hodges and Lehmann 1963)."""
    count = n1 * n2
    reach = _shift_reach(n1, n2, confidence)
    places = np.stack([(count - 1) // 2, count // 2, reach, count - 1 - reach]).astype(np.int64)
    found = np.where(count > 0, differences_at(left, right, places), np.nan)
    low, high = np.where(reach >= 0, found[2], -np.inf), np.where(reach >= 0, found[3], np.inf)
    return (found[0] + found[1]) / 2, low, high


def _rank_sum_p(doubled_sum: Ints, doubled_ranks: Ints, n1: int) -> Floats:
    """Two-sided p of rank sums (j,) of n1 out of N values with ``doubled_ranks`` (N,); both doubled, to be integers.

    P(|W - mean| >= |w - mean|); the mean is n1 (N + 1) / 2 whatever the ties.
    """
    law = _law(doubled_ranks, n1)
    centre = n1 * (doubled_ranks.size + 1)  # doubled
    distance = np.abs(np.arange(law.size) - centre)
    order = np.argsort(-distance, kind="stable")
    # summed from the far end inwards, small terms first; every sum at the same distance belongs to the tail
    tail = np.cumsum(law[order])
    reached = np.searchsorted(-distance[order], -np.abs(doubled_sum - centre), side="right") - 1
    return np.minimum(tail[reached], 1.0)


def _shift_reach(n1: Ints, n2: Ints, confidence: float) -> Ints:
    """Place, from 0, of the lowest of the ordered differences inside the interval; -1: it has no lower end.

    The largest c with P(U <= c) <= tail for untied values; exact for up to 100 values, normal beyond.
    """
    tail = (1 - confidence) / 2
    reach = np.full(n1.shape, -1, dtype=np.int64)
    for size1, size2, at in _by_sizes(n1, n2, n1 * n2 > 0):
        reach[at] = _reach(size1, size2, tail)
    return reach


@lru_cache(maxsize=256)
def _reach(n1: int, n2: int, tail: float) -> int:
    total = n1 + n2
    if total > MOST_EXACT:
        sd = np.sqrt(n1 * n2 * (total + 1) / 12)
        return int(np.floor(n1 * n2 / 2 + special.ndtri(tail) * sd - 0.5))
    law = _law(2 * np.arange(1, total + 1), n1)[n1 * (n1 + 1) :: 2]  # of U = 0, 1, ...
    return int(np.count_nonzero(np.cumsum(law) <= tail)) - 1


def _law(doubled_ranks: Ints, n1: int) -> Floats:
    """Probability of every doubled rank sum 0, 1, ..., of n1 values drawn without replacement."""
    total = int(np.sum(np.sort(doubled_ranks)[-n1:]))
    ways = np.zeros((n1 + 1, total + 1))
    ways[0, 0] = 1.0
    for taken, rank in enumerate(doubled_ranks.tolist(), start=1):
        most = min(taken, n1)
        ways[1 : most + 1, rank:] += ways[:most, : total + 1 - rank]
    return np.asarray(ways[n1] / special.binom(doubled_ranks.size, n1))


def differences_at(left: Floats, right: Floats, places: Ints) -> Floats:
    """Differences left minus right at ``places`` (p, d, q) of their ascending order, for pairs (d, q, n); NaN absent.

    A place outside the differences of a pair takes the nearest.
    Their median is the shift of Hodges and Lehmann (1963).
    """
    d, q, n = left.shape
    if n * right.shape[2] <= _FEW:
        ordered = np.sort(
            (left[..., :, None] - right[..., None, :]).reshape(d, q, n * right.shape[2]), axis=2
        )  # NaN last
        index = np.minimum(np.maximum(places, 0), ordered.shape[2] - 1)
        return np.asarray(ordered.ravel()[index + np.arange(0, ordered.size, ordered.shape[2]).reshape(d, q)])
    found = np.full(places.shape, np.nan)
    for i, j in np.ndindex(d, q):
        x, y = (np.sort(side[i, j][~np.isnan(side[i, j])], kind="stable") for side in (left, right))
        if x.size and y.size:
            found[:, i, j] = _at(x, y, np.clip(places[:, i, j], 0, x.size * y.size - 1))
    return found


def _at(x: Floats, y: Floats, places: Ints) -> Floats:
    """Differences of the sorted ``x``, ``y`` at ``places`` (p,)."""
    samples = _Samples.of(x, y)
    found, window = np.empty(places.size), None
    for k in np.argsort(places).tolist():
        place = int(places[k])
        if window is None or not window.first <= place < window.end:
            window = _window(samples, place)
        found[k] = window.value(place)
    return found


@dataclass(frozen=True)
class _Samples:
    """Distinct values of two samples, ascending, how often they occur, and how many of the second lie before each.

    plain : every value occurs once. sketch : differences of a few values of each, ascending.
    """

    x: Floats
    y: Floats
    x_count: Ints
    y_count: Ints
    y_before: Ints
    plain: bool
    sketch: Floats

    @classmethod
    def of(cls, left: Floats, right: Floats) -> _Samples:
        (x, x_count), (y, y_count) = _distinct(left), _distinct(right)
        some_x, some_y = (side[(2 * np.arange(_SKETCHED) + 1) * side.size // (2 * _SKETCHED)] for side in (x, y))
        return cls(
            x, y, x_count, y_count,
            y_before=np.concatenate([[0], np.cumsum(y_count)]),
            plain=x.size + y.size == left.size + right.size,
            sketch=np.sort((some_x[:, None] - some_y).ravel()),
        )  # fmt: skip

    @property
    def every(self) -> int:
        """Differences, alike ones too."""
        return int(self.x_count.sum() * self.y_before[-1])

    def up_to(self, v: float) -> _Cut:
        at = np.searchsorted(self.y, self.x - v, side="left")
        if self.plain:
            return _Cut(v, at, at.size * self.y.size - int(at.sum()))
        return _Cut(v, at, int(np.dot(self.x_count, self.y_before[-1] - self.y_before[at])))

    def guess(self, place: int) -> tuple[float, float]:
        """About which difference is at a place, and how fast they rise from place to place there."""
        at = int(place / self.every * self.sketch.size)
        below, above = max(at - _SKETCHED, 0), min(at + _SKETCHED, self.sketch.size - 1)
        rise = float(self.sketch[above] - self.sketch[below])
        return float(self.sketch[at]), rise / (above - below) * self.sketch.size / self.every


def _distinct(ordered: Floats) -> tuple[Floats, Ints]:
    """Values that occur and how often."""
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    return ordered[first], np.diff(first, append=ordered.size)


@dataclass(frozen=True)
class _Cut:
    """All differences up to ``v``: those of value i of x with the values of y from ``at`` (i) on; ``count`` of them."""

    v: float
    at: Ints
    count: int


@dataclass(frozen=True)
class _Window:
    """Sorted differences at the places ``first`` to ``end`` - 1, and the place of the last of each alike."""

    first: int
    end: int
    values: Floats
    last: Ints

    def value(self, place: int) -> float:
        return float(self.values[np.searchsorted(self.last, place - self.first, side="left")])


def _window(samples: _Samples, place: int) -> _Window:
    """The differences around ``place``: from a guess the range narrows by secants of the last two counts, or is halved
    where these took little away, until few enough are left in it to be sorted."""
    least, most = samples.x[0] - samples.y[-1], samples.x[-1] - samples.y[0]
    low = _Cut(float(np.nextafter(least, -np.inf)), np.full(samples.x.size, samples.y.size), 0)
    high = _Cut(float(most), np.zeros(samples.x.size, dtype=np.int64), samples.every)
    (middle, rate), before = samples.guess(place), None
    few = min(_A_VALUE * (samples.x.size + samples.y.size), _MANY)
    while np.sum(low.at - high.at) > few:
        if not low.v < middle < high.v:
            middle = low.v + (high.v - low.v) / 2
            if not low.v < middle < high.v:
                break
        cut, held = samples.up_to(middle), high.count - low.count
        low, high = (cut, high) if cut.count <= place else (low, cut)
        if before is not None and cut.count != before.count:
            rate = (cut.v - before.v) / (cut.count - before.count)
        # past the place, so that the other end comes nearer, too
        off = abs(place - cut.count)
        goal = place + np.sign(place - cut.count + 0.5) * max(few // 4, off // 16)
        nearer = before is None or high.count - low.count < 0.9 * held or 2 * off < abs(place - before.count)
        middle, before = cut.v + (goal - cut.count) * rate if nearer else np.nan, cut
    return _sorted_between(samples, low, high)


def _sorted_between(samples: _Samples, low: _Cut, high: _Cut) -> _Window:
    lengths = low.at - high.at
    of_x = np.repeat(np.arange(lengths.size), lengths)
    of_y = np.arange(of_x.size) - np.repeat(np.cumsum(lengths) - lengths - high.at, lengths)
    values = samples.x[of_x] - samples.y[of_y]
    if values.size == high.count - low.count:  # every value occurs once
        return _Window(low.count, high.count, np.sort(values), np.arange(values.size))
    order = np.argsort(values)
    weights = samples.x_count[of_x] * samples.y_count[of_y]
    return _Window(low.count, high.count, values[order], np.cumsum(weights[order]) - 1)
