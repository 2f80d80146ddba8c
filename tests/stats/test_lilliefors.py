"""Lilliefors: simulated p against fresh simulation, published critical values, and its size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.errors import SettingError
from emg2vsa.stats.lilliefors import critical_d, lilliefors, lilliefors_survival
from emg2vsa.stats.lilliefors_table import LEVELS, largest_d
from emg2vsa.stats.normality import ks_normal


def test_numbers_of_the_statistics_notes() -> None:
    assert lilliefors_survival([0.22], [10])[0] == pytest.approx(0.1846, abs=0.002)
    assert critical_d(0.05, 10) == pytest.approx(0.2620, abs=2e-4)


@pytest.mark.parametrize(
    ("n", "critical"),
    [
        (5, [0.3027, 0.3188, 0.3427, 0.3959]), (10, [0.2225, 0.2410, 0.2616, 0.3037]),
        (20, [0.1645, 0.1784, 0.1920, 0.2226]), (30, [0.1370, 0.1478, 0.1590, 0.1848]),
    ],
)  # fmt: skip
def test_table_of_abdi_and_molin(n: int, critical: list[float]) -> None:
    """Critical D at .15, .10, .05 and .01, Molin and Abdi (1998), 100 000 samples each, corrected for n - 1."""
    mine = [critical_d(alpha, n) for alpha in (0.15, 0.1, 0.05, 0.01)]
    np.testing.assert_allclose(mine, critical, atol=0.01)


@pytest.mark.parametrize("n", [4, 5, 6, 10, 13, 28, 60, 200])
def test_p_is_how_often_a_normal_sample_has_such_a_d(n: int) -> None:
    samples = 400_000 if n <= 28 else 50_000
    rng = np.random.default_rng(n)
    d = np.sort(np.concatenate([ks_normal(rng.standard_normal((50_000, n)), standardise=True).d for _ in range(samples // 50_000)]))
    for share in (0.9, 0.5, 0.2, 0.1, 0.05, 0.01, 0.002):
        at = d[-round(share * samples)]
        error = np.sqrt(share * (1 - share) / samples)
        assert abs(lilliefors_survival([at], [n])[0] - share) < 4.5 * error
