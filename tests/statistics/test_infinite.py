"""An infinite value is no missing one: every test refuses it in words. Large finite values are compared like others."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from emg2vsa.errors import DataError
from emg2vsa.statistics.anova import brown_forsythe, one_way, welch
from emg2vsa.statistics.bayes import jzs_anova
from emg2vsa.statistics.drift import drift
from emg2vsa.statistics.equivalence import tost
from emg2vsa.statistics.factorial import factorial
from emg2vsa.statistics.hierarchy import recording_means
from emg2vsa.statistics.kruskal import kruskal
from emg2vsa.statistics.lilliefors import lilliefors
from emg2vsa.statistics.mann_whitney import mann_whitney
from emg2vsa.statistics.mixed import balanced_mixed
from emg2vsa.statistics.normality import ks_normal
from emg2vsa.statistics.repeated import friedman, paired_tests, rm_anova
from emg2vsa.statistics.serial import serial_correlation
from emg2vsa.statistics.trend import trend
from emg2vsa.statistics.whole_curve import curve_tests

_NAMES = np.array(["a", "a", "b", "b"] * 3)
TESTS: dict[str, Callable[[np.ndarray], Any]] = {
    "one_way": one_way, "welch": welch, "brown_forsythe": brown_forsythe, "kruskal": kruskal, "lilliefors": lilliefors,
    "mann_whitney": mann_whitney, "friedman": friedman, "rm_anova": rm_anova, "paired_tests": paired_tests,
    "jzs_anova": jzs_anova,
    "tost": lambda x: tost(x, 1.0),
    "ks_normal": lambda x: ks_normal(x, standardise=False),
    "factorial": lambda x: factorial(x.ravel(), {"side": ["l", "r"] * 6}),
    "trend": lambda x: trend(_NAMES, _NAMES, np.arange(12.0), x.ravel()),
    "drift": lambda x: drift(_NAMES, _NAMES, np.arange(12.0), np.arange(12.0), x.ravel()),
    "serial_correlation": lambda x: serial_correlation(x[None]),
    "recording_means": lambda x: recording_means(x, np.ones(3), np.zeros(3)),
    "balanced_mixed": lambda x: balanced_mixed(x.reshape(3, 2, 2)),
    "curve_tests": lambda x: curve_tests(x.reshape(3, 2, 2)),
}  # fmt: skip


@pytest.mark.parametrize("name", TESTS)
@pytest.mark.parametrize("odd", [np.inf, -np.inf])
def test_an_infinite_value_is_refused(name: str, odd: float) -> None:
    values = np.random.default_rng(2).standard_normal((3, 4))
    TESTS[name](values)
    values[1, 2] = odd
    with pytest.raises(
        DataError, match=r"expected finite numbers, and NaN where one is missing, but found 1 of 12 inf"
    ):
        TESTS[name](values)


def test_pairs_of_the_largest_numbers_are_those_of_smaller_ones() -> None:
    values = np.array([[1.0, -1.0], [0.5, -0.9], [0.9, -0.2], [0.7, -0.6]])
    near, far = paired_tests(values * 2.0**-3), paired_tests(values * 2.0**1023)
    for name in ("statistic", "p", "df"):
        np.testing.assert_array_equal(getattr(far.t, name), getattr(near.t, name))
    np.testing.assert_array_equal(far.g, near.g)
    np.testing.assert_array_equal(far.signed_rank_p, near.signed_rank_p)
    assert np.isfinite(far.t.statistic).all()
    assert far.t.difference[0, 0] == pytest.approx(1.45 * 2.0**1023)
