"""Is each sample Gaussian? The paper's Kolmogorov-Smirnov in both its forms, and the two tests that can tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.stats.lilliefors import Lilliefors, lilliefors
from emg2vsa.stats.normality import KsTests, ks_normal
from emg2vsa.stats.outcome import Outcome
from emg2vsa.stats.shapiro import ShapiroWilk, shapiro_wilk


@dataclass(frozen=True)
class NormalityTests:
    """Four tests of k samples, row by row."""

    standardised: KsTests
    raw: KsTests
    lilliefors: Lilliefors
    shapiro: ShapiroWilk

    def outcomes(self, i: int) -> tuple[Outcome, ...]:
        """All tests of sample ``i``."""
        return tuple(tests.outcome(i) for tests in (self.standardised, self.raw, self.lilliefors, self.shapiro))


def normality_of(values: ArrayLike, origin: float = 0.0) -> NormalityTests:
    """Test each row of ``values`` (k, n), relative to ``origin``; NaN marks a value that is not there."""
    return NormalityTests(
        standardised=ks_normal(values, standardise=True),
        raw=ks_normal(np.asarray(values) + origin, standardise=False),
        lilliefors=lilliefors(values),
        shapiro=shapiro_wilk(values),
    )
