"""A ratio of means by Fieller, and a bias within bounds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.claims.claim import student
from emg2vsa.claims.drifting import biased, free_of_drift
from emg2vsa.claims.ratio import ratio
from emg2vsa.statistics.drift import Drift, Slope

RNG = np.random.default_rng(1)


def test_the_ends_are_the_ratios_that_a_t_test_does_not_reject():
    top, bottom = RNG.normal(3, 1, 9), RNG.normal(10, 1, 9)
    found = ratio(top, bottom)
    assert found.estimate == pytest.approx(top.mean() / bottom.mean())
    for end in found.interval(0.9):
        assert stats.ttest_1samp(top - end * bottom, 0).pvalue == pytest.approx(0.1)


def test_a_denominator_that_may_be_zero_has_no_ends():
    assert ratio(RNG.normal(3, 1, 5), RNG.normal(0.1, 1, 5)).interval(0.95) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("top", "bottom"), [([1.0], [2.0]), ([], []), ([1.0, 2.0], [2.0, 4.0]), ([0.0, 0.0], [1.0, 1.0])]
)
def test_too_few_values_or_no_scatter_have_no_interval(top, bottom):
    assert np.isnan(ratio(np.array(top), np.array(bottom)).interval(0.95)).all()


def test_a_further_error_widens_the_interval():
    top, bottom = RNG.normal(3, 1, 9), np.full(9, 10.0)
    alone = ratio(top, bottom).interval(0.95)
    more = ratio(top, bottom, Slope(0.0, float(np.std(top, ddof=1) / 3), np.inf)).interval(0.95)
    assert more[0] < alone[0]
    assert more[1] > alone[1]
    assert ratio(top, bottom, Slope(0.0, 0.0, 5.0)).interval(0.95) == alone


def test_a_bias_moves_both_ends_and_shares_alpha():
    found = student(2.0, 1.0, np.inf)
    low, high = biased(found, lambda confidence: 0.5 if confidence == 0.95 else np.nan).interval(0.9)
    expected = found.interval(0.95)
    assert (low, high) == pytest.approx((expected[0] - 0.5, expected[1] + 0.5))


def test_an_order_that_differs_takes_the_drift_out_and_others_bound_it():
    slope, within = Slope(0.5, 0.1, 10.0), Slope(0.4, 0.2, 13.0)
    free = free_of_drift(3.0, 0.2, 8.0, 2.0, Drift("differs", slope, within, 5))
    assert free.estimate == pytest.approx(2.0)
    assert free.interval(0.95)[1] - free.estimate > student(2.0, np.hypot(0.2, 0.2), np.inf).interval(0.95)[1] - 2
    same = free_of_drift(3.0, 0.2, 8.0, -2.0, Drift("same", Slope(), within, 5))
    assert same.interval(0.9)[1] == pytest.approx(student(3.0, 0.2, 8.0).interval(0.95)[1] + 2 * within.most(0.95))
    unknown = free_of_drift(3.0, 0.2, 8.0, np.nan, Drift("unknown", Slope(), within, 5))
    assert unknown.interval(0.9)[1] == pytest.approx(student(3.0, 0.2, 8.0).interval(0.95)[1] + 4 * within.most(0.95))
    unbounded = free_of_drift(3.0, 0.2, 8.0, 1.0, Drift("same", Slope(), Slope(), 5))
    assert unbounded.interval(0.9) == (-np.inf, np.inf)
