"""Are groups equal? Not having found a difference does not say so: what the data bound, and tests against a margin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.stats.anova import Anova
from emg2vsa.stats.equivalence import Equivalence, MarginUnit, tost


@dataclass(frozen=True)
class EqualityTests:
    """Over all pairs of groups of d designs.

    bound : (d,) smallest margin within which every pair would be shown equal, in the unit of the data; bound_sd : in
    pooled SDs of the design. tost : against the stated margin, both None without one.
    """

    bound: Floats
    bound_sd: Floats
    tost: Equivalence | None
    margin: float | None
    alpha: float


def equality_tests(
    values: ArrayLike, anova: Anova, alpha: float, margin: float | None = None, unit: MarginUnit = "data"
) -> EqualityTests:
    """Two one-sided tests of all pairs of ``values`` (d, k, n) whose ``anova`` is known; each at ``alpha``."""
    stated = tost(values, margin or 1.0, unit=unit, alpha=alpha)  # the intervals do not depend on the margin
    ends = np.fmax(np.abs(stated.low), np.abs(stated.high))
    bound = np.fmax.reduce(ends, axis=1, initial=-np.inf)
    bound = np.where(np.isfinite(bound), bound, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        return EqualityTests(bound, bound / anova.sd, stated if margin else None, margin, alpha)
