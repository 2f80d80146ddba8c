"""Rigid, human-like and constant stiffness side by side: which sets specimens furthest apart (paper, VI.B, VII)?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from emg2vsa.arrays import Floats, Ints
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RunTable
from emg2vsa.discrimination.separation import (
    gap_difference,
    level_ratio,
    pressed_everywhere,
    repetition_cv,
    smallest_gap,
)
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.stats.bootstrap import Bootstrap, Statistic, bca
from emg2vsa.stats.kruskal import KruskalWallis, kruskal


@dataclass(frozen=True)
class ConditionComparison:
    """Of D designs, over the ``specimens`` pressed in every one, the new one included.

    ranks, gap, cv : (D,) Kruskal-Wallis, ``smallest_gap`` and ``repetition_cv``, intervals by bootstrap over presses.
    human, other : (q,) numbers of the designs compared, the human-like condition with another at the same angle.
    gap_difference, level_ratio, cv_ratio : (q,) of their gaps, human-like less other; of their mean CASR and of their
    CVs, human-like over other.
    """

    specimens: tuple[str, ...]
    ranks: KruskalWallis
    gap: Bootstrap
    cv: Bootstrap
    human: Ints
    other: Ints
    gap_difference: Bootstrap
    level_ratio: Bootstrap
    cv_ratio: Bootstrap

    def wins(self, i: int) -> bool | None:
        """Whether the human-like condition of comparison ``i`` separates better; None where it cannot be said."""
        low, high = self.gap_difference.low[i], self.gap_difference.high[i]
        return True if low > 0 else False if high < 0 else None


def compare_conditions(table: RunTable, settings: DiscriminationSettings) -> ConditionComparison:
    """Scores of the algorithm in ``settings``."""
    values = table.casr[settings.algorithm]
    used = pressed_everywhere(values)
    values = values[:, used]
    pairs = _pairs(table)
    human, other = (np.array([pair[side] for pair in pairs], dtype=np.int64) for side in (0, 1))
    both = np.concatenate([values[human], values[other]], axis=1)

    def interval(samples: Floats, statistic: Statistic, name: str) -> Bootstrap:
        return bca(samples, statistic, settings.resamples, settings.seed, 1 - settings.alpha, name)

    return ConditionComparison(
        specimens=tuple(table.specimens[i] for i in used),
        ranks=kruskal(values),
        gap=interval(values, smallest_gap, "smallest gap in SDs"),
        cv=interval(values, repetition_cv, "coefficient of variation"),
        human=human,
        other=other,
        gap_difference=interval(both, gap_difference, "difference of smallest gaps in SDs"),
        level_ratio=interval(both, level_ratio, "ratio of CASR"),
        cv_ratio=interval(both, _cv_ratio, "ratio of coefficients of variation"),
    )


def _pairs(table: RunTable) -> list[tuple[int, int]]:
    return [
        (human, other)
        for human in table.of_condition(HUMAN_LIKE)
        for other, condition in enumerate(table.conditions)
        if condition != HUMAN_LIKE and table.angles_deg[other] == table.angles_deg[human]
    ]


def _cv_ratio(samples: Floats) -> Floats:
    first, second = np.split(samples, 2, axis=-2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(repetition_cv(first) / repetition_cv(second))
