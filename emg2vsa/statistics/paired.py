"""Two treatments on the same people: Student's paired t with its effect size, and Wilcoxon's signed ranks, exact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from emg2vsa.arrays import Floats, Ints, exponent_of
from emg2vsa.statistics.effect_size import paired_g
from emg2vsa.statistics.kruskal import midranks
from emg2vsa.statistics.moments import shifted_doubles, unmasked, without_rounding
from emg2vsa.statistics.post_hoc import PairDifferences, pair_numbers, student_pairs

MOST_EXACT = 100
"""People up to whom all signs are counted; beyond, the law of the signed ranks is taken as normal."""


@dataclass(frozen=True)
class PairedTests:
    """All q pairs of the k treatments of one table; arrays (1, q), NaN where undefined.

    t : paired t test, its own SD of differences for every pair. g, g_low, g_high : mean difference over the SD of the
    differences, Hedges' correction, interval from the noncentral t. signed_rank_p : two-sided, of Wilcoxon's signed
    ranks (1945), zeros left out, ties kept; exact over all signs up to 100 people.
    """

    t: PairDifferences
    g: Floats
    g_low: Floats
    g_high: Floats
    signed_rank_p: Floats


def paired_tests(values: ArrayLike, confidence: float = 0.95) -> PairedTests:
    """Test every pair of treatments of ``values`` (n people, k treatments); NaN: no value there, for that pair only."""
    doubles, _ = shifted_doubles(np.asarray(unmasked(values)).T)
    first, second = pair_numbers(doubles.shape[1])
    with np.errstate(over="ignore", invalid="ignore"):
        differences = doubles[0, first] - doubles[0, second]
    there = np.isfinite(differences)
    unit = exponent_of(np.where(there, differences, 0.0))
    differences = np.ldexp(differences, -unit)
    values = np.where(there, np.fmax(np.abs(doubles[0, first]), np.abs(doubles[0, second])), 0.0)
    largest = np.ldexp(np.max(values, axis=1, initial=0.0), -unit[:, 0])
    n = np.count_nonzero(there, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.sum(differences, axis=1, where=there) / n
        squares = without_rounding(np.sum((differences - mean[:, None]) ** 2, axis=1, where=there), n, largest)
        se = np.sqrt(squares / (n * (n - 1.0)))
    se = np.where(se > 0, se, np.nan)
    t = student_pairs(
        "paired t",
        np.ldexp(mean, unit[:, 0])[None],
        np.ldexp(se, unit[:, 0])[None],
        np.where(np.isnan(se), np.nan, n - 1.0)[None],
        n[None],
        doubles.shape[1],
        confidence,
    )
    g, low, high = paired_g(mean / se, np.maximum(n, 2), confidence)
    return PairedTests(
        t=t,
        g=g[None],
        g_low=low[None],
        g_high=high[None],
        signed_rank_p=np.array([[_signed_rank_p(row[np.isfinite(row) & (row != 0)]) for row in differences]]),
    )


def _signed_rank_p(differences: Floats) -> float:
    """P(|W - mean| >= |w - mean|) over all signs of the ranks of ``differences`` (m,), none of them 0."""
    if differences.size == 0:
        return float("nan")
    doubled = np.rint(2 * midranks(np.abs(differences))).astype(np.int64)
    distance = abs(2 * int(doubled[differences > 0].sum()) - int(doubled.sum()))
    if differences.size > MOST_EXACT:
        return float(2 * special.ndtr(-distance / np.sqrt(np.sum(doubled.astype(np.float64) ** 2))))
    law = _law_of_signs(doubled)
    far = np.abs(2 * np.arange(law.size) - law.size + 1) >= distance
    return float(min(law[far].sum(), 1.0))


def _law_of_signs(doubled_ranks: Ints) -> Floats:
    """Probability of every sum 0, 1, ... of the ranks with a positive sign, each sign as likely as the other."""
    law = np.zeros(int(doubled_ranks.sum()) + 1)
    law[0] = 1.0
    for rank in doubled_ranks.tolist():
        law[rank:] = (law[rank:] + law[: law.size - rank]) / 2
        law[:rank] /= 2
    return law
