"""Trend over repetitions: against scipy and statsmodels, on designs with gaps, and where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.statistics.trend import Trend, trend


def study(seed: int, slope: float, people: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Participants whose slopes differ, three specimens, six repetitions, a tenth of them missing."""
    rng = np.random.default_rng(seed)
    i, j, k = (index.ravel() for index in np.indices((people, 3, 6)))
    own = slope + 0.02 * rng.standard_normal(people)
    y = 5 + rng.standard_normal(people)[i] + j + own[i] * (k + 1) + 0.1 * rng.standard_normal(i.size)
    keep = rng.random(i.size) > 0.1
    return np.char.add("P", i.astype(str))[keep], np.char.add("S", j.astype(str))[keep], (k + 1.0)[keep], y[keep]


def test_slopes_are_regressions_with_a_level_for_every_specimen() -> None:
    people, specimens, order, y = study(0, 0.1)
    found = trend(people, specimens, order, y)
    for name, slope in zip(found.blocks, found.slope, strict=True):
        own = people == name
        levels = (specimens[own][:, None] == np.unique(specimens)).astype(float)
        model = np.column_stack([levels, order[own]])
        assert slope == pytest.approx(np.linalg.lstsq(model, y[own], rcond=None)[0][-1], rel=1e-10)


def test_the_test_is_that_of_the_slopes() -> None:
    found = trend(*study(1, 0.05))
    peer = stats.ttest_1samp(found.slope, 0)
    assert (found.t, found.p, found.df) == pytest.approx((peer.statistic, peer.pvalue, 7), rel=1e-11)
    assert (found.low, found.high) == pytest.approx(peer.confidence_interval(0.95), rel=1e-11)
    assert found.over_blocks


def test_one_participant_is_a_regression() -> None:
    people, _, order, y = study(2, 0.1, people=1)
    found = trend(people, np.full(people.size, "S1"), order, y)
    peer = stats.linregress(order, y)
    assert (found.mean, found.p) == pytest.approx((peer.slope, peer.pvalue), rel=1e-10)
    assert not found.over_blocks


def test_size_and_coverage() -> None:
    found = [trend(*study(seed, slope)) for slope in (0.0, 0.05) for seed in range(300)]
    assert 0.02 < np.mean([each.p < 0.05 for each in found[:300]]) < 0.085
    assert 0.915 < np.mean([each.low < 0.05 < each.high for each in found[300:]]) < 0.985


@pytest.mark.parametrize("offset", [0.0, 2.0**30])
def test_a_large_level_costs_no_digits(offset: float) -> None:
    people, specimens, order, y = study(3, 0.1)
    y = np.round(y * 2**20) / 2**20
    assert trend(people, specimens, order, y + offset).t == pytest.approx(
        trend(people, specimens, order, y).t, rel=1e-11
    )


@pytest.mark.parametrize("repetitions", [0, 1, 2])
def test_too_few_repetitions_have_no_trend(repetitions: int) -> None:
    order = np.arange(1.0, repetitions + 1)
    names = np.full(repetitions, "x")
    found: Trend = trend(names, names, order, order**2)
    assert np.isnan(found.p)


def test_values_that_are_no_numbers_are_left_out() -> None:
    people, specimens, order, y = study(4, 0.1)
    y[5], order[9] = np.nan, np.nan
    keep = np.isfinite(y) & np.isfinite(order)
    assert trend(people, specimens, order, y).t == trend(people[keep], specimens[keep], order[keep], y[keep]).t


def test_equal_slopes_of_all_participants_give_no_test() -> None:
    people = np.repeat(["A", "B"], 4)
    found = trend(people, people, np.tile([1.0, 2, 3, 4], 2), np.tile([1.0, 2, 3, 4], 2))
    assert found.mean == 1
    assert np.isnan(found.p)
