"""Exact law of the rank sum of one of two groups, ties included: every way to deal the ranks out is counted."""

from __future__ import annotations

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints

MOST_EXACT = 100
"""Values of both groups together up to which counting is done."""


def rank_sum_p(doubled_sum: Ints, doubled_ranks: Ints, n1: int) -> Floats:
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


def shift_reach(n1: Ints, n2: Ints, confidence: float) -> Ints:
    """Place, from 0, of the lowest of the ordered differences inside the interval; -1: it has no lower end.

    The largest c with P(U <= c) <= tail for untied values; exact for up to 100 values, normal beyond.
    """
    tail = (1 - confidence) / 2
    reach = np.full(np.broadcast(n1, n2).shape, -1, dtype=np.int64)
    for size1, size2 in set(zip(np.ravel(n1).tolist(), np.ravel(n2).tolist(), strict=True)):
        if size1 > 0 and size2 > 0:
            reach[(n1 == size1) & (n2 == size2)] = _reach(size1, size2, tail)
    return reach


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
