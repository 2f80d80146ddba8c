"""Equality of variances: Levene's test and the form of Brown and Forsythe."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.stats.anova import Anova, one_way
from emg2vsa.stats.group_moments import group_moments
from emg2vsa.stats.outcome import Outcome

Center = Literal["median", "mean"]


@dataclass(frozen=True)
class VarianceTests:
    """Analysis of variance of the distances from each group's ``center``."""

    center: Center
    anova: Anova

    def outcome(self, i: int = 0) -> Outcome:
        found = self.anova.outcome(i)
        return Outcome(
            method="Brown-Forsythe (distances from medians)" if self.center == "median" else "Levene (from means)",
            n=found.n,
            statistic_name="F",
            statistic=found.statistic,
            df=found.df,
            p=found.p,
            notes=found.notes,
        )


def levene(values: ArrayLike, center: Center = "median") -> VarianceTests:
    """Levene (1960) with ``center="mean"``, Brown and Forsythe (1974) with "median"; ``values`` as for ``one_way``."""
    groups = group_moments(values)
    deviation = groups.deviation
    if center == "median":
        deviation = deviation - _medians(deviation, groups.valid)[..., None]
    return VarianceTests(center, one_way(np.where(groups.valid, np.abs(deviation), np.nan)))


def _medians(values: Floats, valid: np.ndarray) -> Floats:
    """(d, k) medians of the valid of ``values`` (d, k, n), 0 where there is none."""
    ordered = np.sort(np.where(valid, values, np.inf), axis=2)
    count = np.count_nonzero(valid, axis=2)[..., None]
    low = np.take_along_axis(ordered, np.maximum(count - 1, 0) // 2, axis=2)
    high = np.take_along_axis(ordered, np.minimum(count // 2, values.shape[2] - 1), axis=2)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(count > 0, (low + high) / 2, 0.0)[..., 0])
