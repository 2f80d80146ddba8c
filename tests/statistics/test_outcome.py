"""The common form of results."""

from __future__ import annotations

import numpy as np

from emg2vsa.statistics.anova import one_way
from emg2vsa.statistics.normality import ks_normal
from emg2vsa.statistics.post_hoc import lsd


def test_holds_no_numpy() -> None:
    values = np.random.default_rng(0).standard_normal((3, 4))
    anova = one_way(values)
    for outcome in (anova.outcome(), lsd(anova).outcome(), ks_normal(values, standardise=True).outcome(1)):
        for value in vars(outcome).values():
            assert not isinstance(value, np.generic | np.ndarray)
