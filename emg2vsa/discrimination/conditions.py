"""Rigid, human-like and constant stiffness side by side: which sets specimens furthest apart (paper, VI.B, VII)?"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RunTable
from emg2vsa.discrimination.separation import (
    Gaps,
    closest_pair,
    cv_ratio,
    gaps_of,
    level_ratio,
    pressed_everywhere,
    repetition_cv,
)
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.statistics.bootstrap import Bootstrap, Statistic, bca
from emg2vsa.statistics.kruskal import KruskalWallis, kruskal


@dataclass(frozen=True)
class ConditionComparison:
    """Of D designs, over the ``specimens`` pressed in every one, the new one included.

    ranks, cv : (D,) Kruskal-Wallis, and ``repetition_cv``. gaps : (D,) of the ``pair`` of specimens that lies closest.
    human, other : (q,) numbers of the designs compared, the human-like condition with another at the same angle.
    gap_differences : (q,) human-like less other. level_ratio, cv_ratio : (q,) of mean CASR and of CVs, human-like over
    other. Intervals of gaps by the noncentral t, of ratios by bootstrap over presses; ``level_ratio`` counts the
    mountings too, one for each specimen and condition.
    """

    specimens: tuple[str, ...]
    pair: tuple[str, str]
    ranks: KruskalWallis
    gaps: Gaps
    cv: Floats
    human: Ints
    other: Ints
    gap_differences: Gaps
    level_ratio: Bootstrap
    cv_ratio: Bootstrap
    confidence: float

    def wins(self, i: int) -> bool | None:
        """Whether the human-like condition of comparison ``i`` separates better; None where it cannot be said."""
        low, high = self.gap_differences.low[i], self.gap_differences.high[i]
        return True if low > 0 else False if high < 0 else None


def compare_conditions(
    table: RunTable, settings: DiscriminationSettings, mounting_sd: float = 0.0
) -> ConditionComparison:
    """Scores of the algorithm of ``table``; mounting_sd : of a score between mountings, as a share, assumed."""
    values = table.casr[table.algorithm]
    used = pressed_everywhere(values)
    values = values[:, used]
    specimens = tuple(table.specimens[i] for i in used)
    human, other = _compared(table)
    both = np.concatenate([values[human], values[other]], axis=1)
    pair = closest_pair(values)
    gaps = gaps_of(values[:, pair : pair + 2], 1 - settings.alpha)

    def interval(samples: Floats, statistic: Statistic) -> Bootstrap:
        return bca(samples, statistic, settings.resamples, settings.seed, 1 - settings.alpha)

    return ConditionComparison(
        specimens=specimens,
        pair=(specimens[pair], specimens[pair + 1]),
        ranks=kruskal(values),
        gaps=gaps,
        cv=repetition_cv(values),
        human=human,
        other=other,
        gap_differences=gaps.at(human).less(gaps.at(other)),
        level_ratio=_over_mountings(interval(both, level_ratio), mounting_sd * np.sqrt(2 / used.size)),
        cv_ratio=interval(both, cv_ratio),
        confidence=1 - settings.alpha,
    )


def _over_mountings(ratio: Bootstrap, sd_of_log: float) -> Bootstrap:
    """The interval with an independent normal error of the logarithm joined to each end (as Zou and Donner 2008)."""
    reach = float(special.ndtri(0.5 + 0.5 * ratio.confidence)) * sd_of_log
    with np.errstate(invalid="ignore", divide="ignore"):
        low = ratio.estimate * np.exp(-np.hypot(np.log(ratio.estimate / ratio.low), reach))
        high = ratio.estimate * np.exp(np.hypot(np.log(ratio.high / ratio.estimate), reach))
    return replace(ratio, low=low, high=high) if sd_of_log else ratio


def _compared(table: RunTable) -> tuple[Ints, Ints]:
    """Numbers of the human-like design and of the other, for every comparison."""
    pairs = [
        (human, other)
        for human in table.of_condition(HUMAN_LIKE)
        for other, condition in enumerate(table.conditions)
        if condition != HUMAN_LIKE and table.angles_deg[other] == table.angles_deg[human]
    ]
    human, other = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return human, other
