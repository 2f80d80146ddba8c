"""Does a condition raise the contrast, the logarithm of the ratio of CASR of two specimens? Tested over mountings.

A change of contrast between two conditions is a sum over four cells, each mounted on its own; its error is that of
``emg2vsa.discrimination.mountings``. Where nothing was mounted twice, nothing is claimed, unless mountings are said to
be alike.

Two measures: the slope CASR, and equation (2) as printed, which sums over frames and so grows with the duration of a
press. Within each measure the tests follow an order that holds the chance of any false claim at alpha: the human-like
condition against the rigid one, softest over stiffest specimen; if that is found, the stiffest with its neighbour; if
that is found, all others with Holm's correction (a fixed sequence; Maurer, Hothorn and Lehmacher 1995).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.mountings import CellSum, Mountings, checked, columns
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
    mountings = Mountings.of_table(table, casr, mounting_sd)
    levels = [
        mountings.sum({(design, soft): 1.0, (design, stiff): -1.0})
        for design in range(len(table.conditions))
        for soft, stiff in places
    ]
    compared = zip(one.tolist(), other.tolist(), pair.tolist(), strict=True)
    changes = _estimates([change_of(mountings, a, b, places[k]) for a, b, k in compared], alpha)
    adjusted = _in_order(changes.p, [_place(table, *row) for row in zip(one, other, pair, strict=True)], alpha)
    return Contrast(
        measure=measure,
        algorithm=algorithm,
        pairs=tuple((table.specimens[soft], table.specimens[stiff]) for soft, stiff in places),
        levels=_estimates(levels, alpha),
        one=one,
        other=other,
        pair=pair,
        changes=changes,
        p_adjusted=adjusted,
        verdicts=tuple(_verdict(e, p, alpha) for e, p in zip(changes.estimate, adjusted, strict=True)),
        mountings=mountings.count[:, used].min(axis=1),
        assumed_sd=mounting_sd,
        confidence=1 - alpha,
    )


def change_of(mountings: Mountings, one: int, other: int, pair: tuple[int, int]) -> CellSum:
    """Contrast of a pair, softer first, in design ``one`` less that in ``other``."""
    soft, stiff = pair
    return checked(mountings).sum({(one, soft): 1.0, (one, stiff): -1.0, (other, soft): -1.0, (other, stiff): 1.0})


def _estimates(sums: list[CellSum], alpha: float) -> Estimates:
    return Estimates(*columns([(each.estimate, *each.ends(1 - alpha), each.p, each.df) for each in sums], 5))


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
