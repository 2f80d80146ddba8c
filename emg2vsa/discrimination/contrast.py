"""Does a condition raise the contrast, the logarithm of the ratio of CASR of two specimens? Tested over mountings.

Presses of one mounting share its errors, so a press is no replicate: the mounting is. Of each cell (specimen, angle,
condition) the mean of ln CASR of every mounting counts once. A change of contrast between two conditions is a sum over
four cells, each mounted on its own; its standard error comes from the scatter of their mountings, pooled:
t with sum(M - 1) degrees of freedom. The scatter is taken as equal in the four cells; the false alarms where it is not
are in benchmarks/results/controls. Where the cells differ in their number of mountings, or a mounting has less than
half the presses of another, equal scatter would raise false alarms: each cell then has a scatter of its own, with the
degrees of freedom of Welch and Satterthwaite, or those that cells of equal scatter would have if these are fewer. Where
one of the four was mounted once, the SD from mounting to mounting is
assumed, and nothing is claimed, unless it is assumed to be 0.

Two measures: the slope CASR, and equation (2) as printed, which sums over frames and so grows with the duration of a
press. Within each measure the tests follow an order that holds the chance of any false claim at alpha: the human-like
condition against the rigid one, softest over stiffest specimen; if that is found, the stiffest with its neighbour; if
that is found, all others with Holm's correction (a fixed sequence; Maurer, Hothorn and Lehmacher 1995).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import stats

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.discrimination.separation import pressed_everywhere
from emg2vsa.statistics.multiplicity import adjust

Measure = Literal["slope", "frame_sum"]
Verdict = Literal["raises", "lowers", "not shown", "cannot be told"]
FRAME_SUM = "paper"
"The algorithm whose rate is equation (2) as printed."


@dataclass(frozen=True, eq=False)
class Estimates:
    """n differences of mean ln CASR; (n,) each. df : degrees of freedom of the scatter; NaN where there is no test."""

    estimate: Floats
    low: Floats
    high: Floats
    p: Floats
    df: Floats

    def at(self, i: int) -> tuple[float, float, float]:
        """Estimate, low and high."""
        return float(self.estimate[i]), float(self.low[i]), float(self.high[i])


@dataclass(frozen=True, eq=False)
class Contrast:
    """One measure of CASR, of D designs and P pairs of specimens, the softer first in each.

    levels : ln of the ratio of each pair in each design, D P of them, design by design. one, other, pair : (q,) designs
    compared and place of the pair. changes : (q,) contrast in ``one`` less that in ``other``. p_adjusted : (q,) by the
    order of tests above. mountings : (D,) fewest of a cell, 0 without a score. verdicts : (q,), of ``one``.
    assumed_sd : of ln CASR from mounting to mounting, where a cell was mounted once.
    """

    measure: Measure
    algorithm: str
    pairs: tuple[tuple[str, str], ...]
    levels: Estimates
    one: Ints
    other: Ints
    pair: Ints
    changes: Estimates
    p_adjusted: Floats
    verdicts: tuple[Verdict, ...]
    mountings: Ints
    assumed_sd: float
    confidence: float


def contrasts(table: RunTable, alpha: float, mounting_sd: float) -> tuple[Contrast, ...]:
    """Both measures, as far as the runs have them. mounting_sd : of a score, as a share of it, where not measured."""
    slope = table.algorithm if table.algorithm != FRAME_SUM else next(iter(table.casr))
    measures: dict[Measure, str] = {"slope": slope, "frame_sum": FRAME_SUM}
    return tuple(
        _contrast(table, measure, name, alpha, mounting_sd)
        for measure, name in measures.items()
        if name in table.casr and (measure == "frame_sum" or name != FRAME_SUM)
    )


def _contrast(table: RunTable, measure: Measure, algorithm: str, alpha: float, mounting_sd: float) -> Contrast:
    casr = table.casr[algorithm]
    used = pressed_everywhere(casr)
    # the softest over the stiffest specimen, then the neighbour of the stiffest over it
    places = list(dict.fromkeys([(int(used[-1]), int(used[0])), (int(used[1]), int(used[0]))]))
    one, other, pair = _compared(table, len(places))
    cells = _Cells(casr, table.mounting, mounting_sd)
    d = len(table.conditions)
    levels = cells.sums(
        [((design, soft), (design, stiff)) for design in range(d) for soft, stiff in places],
        [(1.0, -1.0)] * (d * len(places)), alpha,
    )  # fmt: skip
    changes = cells.sums(
        [
            ((a, places[k][0]), (a, places[k][1]), (b, places[k][0]), (b, places[k][1]))
            for a, b, k in zip(one.tolist(), other.tolist(), pair.tolist(), strict=True)
        ],
        [(1.0, -1.0, -1.0, 1.0)] * one.size, alpha,
    )  # fmt: skip
    adjusted = _in_order(changes.p, [_place(table, *row) for row in zip(one, other, pair, strict=True)], alpha)
    return Contrast(
        measure=measure,
        algorithm=algorithm,
        pairs=tuple((table.specimens[soft], table.specimens[stiff]) for soft, stiff in places),
        levels=levels,
        one=one,
        other=other,
        pair=pair,
        changes=changes,
        p_adjusted=adjusted,
        verdicts=tuple(_verdict(e, p, alpha) for e, p in zip(changes.estimate, adjusted, strict=True)),
        mountings=cells.count[:, used].min(axis=1),
        assumed_sd=mounting_sd,
        confidence=1 - alpha,
    )


class _Cells:
    """Means, counts and scatter of the mountings of every cell; casr, mounting : (D, S, R)."""

    def __init__(self, casr: Floats, mounting: Ints, mounting_sd: float) -> None:
        with np.errstate(invalid="ignore", divide="ignore"):
            logs = np.log(np.where(casr > 0, casr, np.nan))
        numbers = np.arange(1, int(mounting.max(initial=1)) + 1)
        of_mounting = np.where(mounting[:, :, None] == numbers[:, None], logs[:, :, None], np.nan)  # (D, S, M, R)
        own = mean_of(of_mounting)
        self.mean, self.count = mean_of(own), np.isfinite(own).sum(axis=2)
        self.presses = np.isfinite(logs).sum(axis=2)
        pressed = np.isfinite(of_mounting).sum(axis=3)
        self.most_presses = pressed.max(axis=2)
        self.fewest_presses = np.where(pressed > 0, pressed, self.most_presses[..., None]).min(axis=2)
        self.of_mountings = np.nansum((own - self.mean[..., None]) ** 2, axis=2)
        self.of_presses = np.nansum((of_mounting - own[..., None]) ** 2, axis=(2, 3))
        self._sd = mounting_sd

    def sums(
        self, cells: list[tuple[tuple[int, int], ...]], weights: list[tuple[float, ...]], alpha: float
    ) -> Estimates:
        """Weighted sums of the means of ``cells``, (design, specimen) each."""
        rows = [self._sum(*each, alpha) for each in zip(cells, weights, strict=True)]
        return Estimates(*np.array(rows, dtype=np.float64).reshape(-1, 5).T)

    def _sum(self, cells: tuple[tuple[int, int], ...], weights: tuple[float, ...], alpha: float) -> tuple[float, ...]:
        at = tuple(np.array(cells).T)
        mean, count, presses = self.mean[at], self.count[at], self.presses[at]
        estimate = float(np.dot(weights, mean))
        if not np.isfinite(estimate):
            return (np.nan,) * 5
        known = 0.0
        if (count > 1).all():
            squares = self.of_mountings[at]
            unequal = 2 * self.fewest_presses[at].min() < self.most_presses[at].max()
            if unequal or count.min() < count.max():
                df, variance = _welch(squares / (count - 1) / count, count)
            else:
                df = float(np.sum(count - 1))
                variance = float(squares.sum() / df * np.sum(1 / count))
        else:
            # within one mounting presses are replicates; what mountings add is assumed
            df = float(np.sum(presses - count))
            variance = float(self.of_presses[at].sum() / df * np.sum(1 / presses)) if df else np.nan
            known = float(stats.norm.ppf(1 - alpha / 2)) * self._sd * float(np.sqrt(np.sum(1 / count)))
        if df < 1:
            return estimate, np.nan, np.nan, np.nan, np.nan
        error = float(np.sqrt(variance))
        reach = float(np.hypot(stats.t.ppf(1 - alpha / 2, df) * error, known))
        p = np.nan if known else 2 * float(stats.t.sf(abs(estimate) / error, df)) if error else np.nan
        return estimate, estimate - reach, estimate + reach, p, df


def _welch(variances: Floats, count: Ints) -> tuple[float, float]:
    """Degrees of freedom and variance of a sum of means with ``variances`` of their own, over ``count`` mountings each.

    The estimated degrees of freedom (Welch 1947, Satterthwaite 1946) are too many where a cell of few mountings happens
    to scatter little: those of equal scatter bound them.
    """
    variance = float(variances.sum())
    equal = float(np.sum(1 / count) ** 2 / np.sum(1 / count**2 / (count - 1)))
    if not variance:
        return equal, 0.0
    return min(equal, float(variance**2 / np.sum(variances**2 / (count - 1)))), variance


def _compared(table: RunTable, pairs: int) -> tuple[Ints, Ints, Ints]:
    """Human-like against all others, and the others against rigid, at the same angle, for every pair."""
    designs = list(zip(table.conditions, table.angles_deg.tolist(), strict=True))
    rows = [
        (a, b, pair)
        for pair in range(pairs)
        for a, (one, angle_deg) in enumerate(designs)
        for b, (other, other_deg) in enumerate(designs)
        if angle_deg == other_deg and a != b and (one == HUMAN_LIKE or (other == RIGID and one != HUMAN_LIKE))
    ]
    one, other, pair = np.array(rows, dtype=np.int64).reshape(-1, 3).T
    return one, other, pair


def _place(table: RunTable, one: int, other: int, pair: int) -> int:
    """Step of the fixed sequence: place of the pair for human-like against rigid at the smallest angle; else 2."""
    first = (table.conditions[one], table.conditions[other]) == (HUMAN_LIKE, RIGID)
    smallest = min(table.angles_deg[design] for design in table.of_condition(HUMAN_LIKE)) if first else 0.0
    return int(pair) if first and table.angles_deg[one] == smallest else 2


def _in_order(p: Floats, steps: list[int], alpha: float) -> Floats:
    """Adjusted p: of each step of the sequence at least that of the step before, of the last step by Holm.

    NaN from the first step on that has no p: the sequence ends there.
    """
    step = np.array(steps, dtype=np.int64)
    adjusted, before = np.full(p.shape, np.nan), 0.0
    for number in range(3):
        own = step == number
        if own.any():
            adjusted[own] = np.maximum(adjust(p[own], "holm"), before)
            before = float(np.max(adjusted[own])) if number < 2 else before
    return adjusted


def _verdict(estimate: float, p: float, alpha: float) -> Verdict:
    if np.isnan(p):
        return "cannot be told"
    return "not shown" if p >= alpha else "raises" if estimate > 0 else "lowers"
