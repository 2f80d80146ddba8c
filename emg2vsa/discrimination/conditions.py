"""Rigid, human-like and constant stiffness side by side: which sets specimens furthest apart (paper, VI.B, VII)?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.mountings import Mountings, Ratios, columns, ratios
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID, RunTable
from emg2vsa.discrimination.separation import (
    Gaps,
    closest_pair,
    gaps_of,
    press_sds,
    pressed_everywhere,
    sd_ratio,
)


@dataclass(frozen=True, eq=False)
class ConditionComparison:
    """Conditions compared in D designs over the ``specimens`` pressed in every one, the new one included.

    gaps : (D,) d' of the ``pair`` of specimens that lies closest. press_sd : (D,) SD of ln CASR of a press within its
    mounting. human, other : (q,) numbers of the designs compared, the human-like condition with another at the same
    angle. gap_differences : (q,) human-like less other. level_ratio, cv_ratio : (q,) of mean CASR (geometric, over
    specimens and mountings) and of press_sd, human-like over other. mountings : fewest and most of a cell with a score.
    mounting_sd : of ln CASR from mounting to mounting, as the runs imply it, low and high. assumed_sd : the same, as
    assumed. cells : number of human-like cells with a rigid one at their angle. far : design, specimen and difference
    of ln CASR of those that differ by more than two SDs of a difference of two means over mountings.
    """

    specimens: tuple[str, ...]
    pair: tuple[str, str]
    gaps: Gaps
    press_sd: Floats
    human: Ints
    other: Ints
    gap_differences: Gaps
    level_ratio: Ratios
    cv_ratio: Ratios
    mountings: tuple[int, int]
    mounting_sd: tuple[float, float, float]
    assumed_sd: float
    cells: int
    far: tuple[tuple[int, int, float], ...]
    confidence: float


def compare_conditions(table: RunTable, alpha: float, mounting_sd: float) -> ConditionComparison:
    """Scores of the algorithm of ``table``; mounting_sd : of a score between mountings, as a share, assumed."""
    values = table.casr[table.algorithm]
    used = pressed_everywhere(values).tolist()
    mountings = Mountings.of_table(table, values, mounting_sd)
    pair = closest_pair(table.stiffness_n_per_mm, used)
    gaps = gaps_of(mountings, pair, 1 - alpha)
    pairs = _compared(table)
    human, other = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    share, count, implied = 1 / len(used), mountings.count, implied_sd(table, mountings, used, 1 - alpha)
    pressed = count[count > 0]
    sd = implied[0] if pressed.max(initial=0) > 1 else mounting_sd
    changes = [
        (a, s, float(mountings.mean[a, s] - mountings.mean[b, s]), sd * np.sqrt(1 / count[a, s] + 1 / count[b, s]))
        for a, b in pairs
        if table.conditions[b] == RIGID
        for s in np.flatnonzero((count[a] > 0) & (count[b] > 0)).tolist()
    ]
    levels = [mountings.sum({(a, s): share for s in used} | {(b, s): -share for s in used}) for a, b in pairs]
    return ConditionComparison(
        specimens=tuple(table.specimens[i] for i in used),
        pair=(table.specimens[pair[0]], table.specimens[pair[1]]),
        gaps=gaps,
        press_sd=press_sds(mountings),
        human=human,
        other=other,
        gap_differences=gaps.at(human).less(gaps.at(other)),
        level_ratio=ratios(levels, 1 - alpha),
        cv_ratio=Ratios(*columns([sd_ratio(mountings, a, b, 1 - alpha) for a, b in pairs])),
        mountings=(int(pressed.min()) if pressed.size else 0, int(pressed.max(initial=0))),
        mounting_sd=implied,
        assumed_sd=mounting_sd,
        cells=len(changes),
        far=tuple((a, s, change) for a, s, change, of_two in changes if abs(change) > 2 * of_two),
        confidence=1 - alpha,
    )


def implied_sd(table: RunTable, mountings: Mountings, used: list[int], confidence: float) -> tuple[float, float, float]:
    """SD of ln score from mounting to mounting, low and high by chi-square; NaN where nothing tells it.

    From mountings of the same cell. Where none was mounted twice, from cells of the same specimen and angle under
    several conditions, less what a condition changes on all specimens: then effects of conditions on single specimens
    are part of it. What presses add is taken off.
    """
    squares, df = float(mountings.scatter.sum()), float(np.sum(np.maximum(mountings.count - 1, 0)))
    if not df:
        for angle in np.unique(table.angles_deg):
            means = mountings.mean[table.angles_deg == angle][:, used]
            means = means[np.isfinite(means).all(axis=1)]
            if len(means) < 2:
                continue
            rest = means - means.mean(axis=0) - means.mean(axis=1, keepdims=True) + means.mean()
            squares, df = squares + float(np.sum(rest**2)), df + (len(means) - 1) * (len(used) - 1)
    pressed = mountings.presses[mountings.presses > 0]
    if not df:
        return np.nan, np.nan, np.nan
    of_press = mountings.press_sd(range(len(mountings.own)))[0] ** 2 * float(np.mean(1 / pressed))
    tail = 0.5 - 0.5 * confidence
    ends = squares / np.array([df, special.chdtri(df, tail), special.chdtri(df, 1 - tail)])
    estimate, low, high = np.sqrt(np.maximum(ends - (of_press if of_press == of_press else 0.0), 0.0)).tolist()
    return estimate, low, high


def _compared(table: RunTable) -> list[tuple[int, int]]:
    """Numbers of the human-like design and of the other, for every comparison."""
    return [
        (human, other)
        for human in table.of_condition(HUMAN_LIKE)
        for other, condition in enumerate(table.conditions)
        if condition != HUMAN_LIKE and table.angles_deg[other] == table.angles_deg[human]
    ]
