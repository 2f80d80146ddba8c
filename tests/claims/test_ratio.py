"""A ratio of means by Fieller, and what drift may have done to both."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.claims.drifting import Difference, contrast
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


def people(rng, apart, by, effect=3.0):
    return Difference(rng.normal(effect, 1.0, apart.size), apart, by)


def test_an_order_that_differs_takes_the_drift_out():
    """Steps that consist of drift alone: 0.5 a place, and the slope that the order tells is exact."""
    apart = np.array([1.0, -2.0, 3.0, 1.0, -1.0, 2.0])
    by = Drift("differs", Slope(0.5, 0.0, 10.0), Slope(), 5)
    level = Difference(RNG.normal(10, 0.1, 6), np.empty(0), by)
    top = Difference(0.5 * apart + RNG.normal(0, 1e-3, 6), apart, by)
    assert contrast(top, level).estimate == pytest.approx(0, abs=1e-3)
    unsure = Drift("differs", Slope(0.5, 1.0, 10.0), Slope(), 5)
    wide = contrast(Difference(top.values, apart, unsure), level).interval(0.95)
    assert wide[1] - wide[0] > 10 * np.diff(contrast(top, level).interval(0.95))


@pytest.mark.parametrize(("order", "places"), [("same", 2.0), ("unknown", 4.0)])
def test_drift_that_nobody_can_tell_moves_both_ends(order, places):
    within = Slope(0.4, 0.2, 13.0)
    by, none = Drift(order, Slope(), within, 5), np.full(8, 10.0) + 1e-6 * RNG.normal(size=8)
    top = people(RNG, np.full(8, 2.0) if order == "same" else np.full(8, np.nan), by)
    low, high = contrast(top, Difference(none, np.empty(0), by)).interval(0.91)
    alone, most = ratio(top.values, none).interval(0.97), places * within.most(0.97) / 10
    assert (low, high) == pytest.approx((alone[0] - most, alone[1] + most))
    endless = Drift(order, Slope(), Slope(), 5)
    assert contrast(Difference(top.values, top.apart, endless), Difference(none, np.empty(0), endless)).interval(
        0.9
    ) == (-np.inf, np.inf)


def test_a_denominator_that_drift_may_make_zero_leaves_no_ends():
    by = Drift("same", Slope(), Slope(4.0, 0.5, 13.0), 5)
    bottom = Difference(RNG.normal(8, 0.1, 6), np.full(6, 2.0), by)
    assert contrast(people(RNG, np.zeros(6), by), bottom).interval(0.9) == (-np.inf, np.inf)


def test_people_of_an_unknown_order_count_by_their_share():
    """One of eight: an eighth of the drift of a session."""
    within, apart = Slope(0.4, 0.2, 13.0), np.array([1.0, -1, 2, -2, 1, -1, 0, np.nan])
    by = Drift("differs", Slope(0.5, 0.0, 10.0), within, 5)
    level = Difference(np.full(8, 10.0) + 1e-6 * RNG.normal(size=8), np.empty(0), by)
    top = people(RNG, apart, by)
    low, high = contrast(top, level).interval(0.91)
    alone, most = ratio(top.freed, level.values).interval(0.97), within.times(4 / 8).most(0.97) / 10
    assert (low, high) == pytest.approx((alone[0] - most, alone[1] + most))
