"""The common form of results."""

from __future__ import annotations

import numpy as np

from emg2vsa.stats.anova import one_way
from emg2vsa.stats.lsd import lsd
from emg2vsa.stats.normality import ks_normal
from emg2vsa.stats.outcome import Outcome


def test_significance_needs_a_p() -> None:
    assert Outcome(method="t", n=3, p=0.04).significant(0.05) is True
    assert Outcome(method="t", n=3, p=0.05).significant(0.05) is False
    assert Outcome(method="t", n=3, p=float("nan")).significant(0.05) is None
    assert Outcome(method="Bayes factor", n=3, statistic_name="BF01", statistic=4.0).significant(0.05) is None


def test_holds_no_numpy() -> None:
    values = np.random.default_rng(0).standard_normal((3, 4))
    anova = one_way(values)
    for outcome in (anova.outcome(), lsd(anova).outcome(), ks_normal(values, standardise=True).outcome(1)):
        for value in vars(outcome).values():
            assert not isinstance(value, np.generic | np.ndarray)
