from __future__ import annotations

import numpy as np
import pytest
from pingouin import compute_effsize

from emg2vsa.discrimination.separation import (
    closest_pair,
    cv_ratio,
    gaps_of,
    level_ratio,
    pressed_everywhere,
    repetition_cv,
    steps,
)

SCORES = np.array([[1.0, 2.0, 3.0], [5.0, 6.0, 7.0], [8.0, 10.0, 12.0]])


def test_steps_are_cohens_d_of_neighbours():
    # (6 - 2) / 1 and (10 - 6) / sqrt((2 + 8) / 4)
    assert steps(SCORES).tolist() == pytest.approx([4, 4 / np.sqrt(2.5)])
    assert steps(SCORES[[1, 0, 2]])[0] == pytest.approx(-4)


def test_missing_presses_are_left_out():
    padded = np.concatenate([SCORES, np.full((3, 2), np.nan)], axis=1)
    assert np.array_equal(steps(padded), steps(SCORES))
    assert repetition_cv(padded) == repetition_cv(SCORES)


def test_a_gap_is_hedges_g():
    found = gaps_of(SCORES[None, :2], 0.95)
    expected = compute_effsize(SCORES[1], SCORES[0], eftype="hedges")  # approximates the factor: 1 - 3 / (4 n - 9)
    assert found.gap[0] == pytest.approx(expected, rel=0.005)
    assert found.low[0] < found.gap[0] < found.high[0]


@pytest.mark.parametrize(
    "pair",
    [
        [[1.0, 1.0], [2.0, 2.0]],
        [[1.0, 2.0], [np.nan, np.nan]],
        [[1.0, np.nan], [2.0, np.nan]],
        [[np.nan, np.nan], [np.nan, np.nan]],
    ],
)
def test_no_spread_and_no_press_have_no_gap(pair):
    found = gaps_of(np.array([pair]), 0.95)
    assert np.isnan([found.gap, found.low, found.high]).all()


@pytest.mark.parametrize("gap", [0.5, 8.0])
def test_intervals_of_gaps_and_of_their_differences_hold_the_truth_as_often_as_they_promise(gap):
    rng = np.random.default_rng(0)
    first, second = (rng.normal([[0.0], [gap]], 1.0, (300, 2, 10)) for _ in range(2))
    ours, other = gaps_of(first, 0.95), gaps_of(second, 0.95)
    difference = ours.less(other)
    assert np.mean((ours.low <= gap) & (gap <= ours.high)) == pytest.approx(0.95, abs=0.025)
    assert np.mean((difference.low <= 0) & (difference.high >= 0)) == pytest.approx(0.95, abs=0.025)
    assert np.mean(ours.gap) == pytest.approx(gap, rel=0.02, abs=0.03)


def test_a_difference_is_that_of_the_gaps_and_turns_with_them():
    found = gaps_of(np.stack([SCORES[:2], SCORES[1:]]), 0.95)
    one, other = found.at(np.array([0])), found.at(np.array([1]))
    there, back = one.less(other), other.less(one)
    assert there.gap == pytest.approx(one.gap - other.gap)
    assert (there.low[0], there.high[0]) == pytest.approx((-back.high[0], -back.low[0]))


def test_the_closest_pair_is_that_of_the_usual_design():
    values = np.stack([SCORES, SCORES, SCORES[[0, 0, 2]]])
    assert closest_pair(values) == 1
    assert closest_pair(np.full((2, 3, 4), np.nan)) == 0


def test_cv_is_the_root_mean_square_over_specimens():
    cvs = [1 / 2, 1 / 6, 2 / 10]
    assert repetition_cv(SCORES) == pytest.approx(np.sqrt(np.mean(np.square(cvs))))


def test_halves_are_compared():
    wider = np.concatenate([SCORES, SCORES + 2 * (SCORES - SCORES.mean(axis=1, keepdims=True))])
    assert cv_ratio(wider) == pytest.approx(1 / 3)
    assert level_ratio(np.concatenate([SCORES, 2 * SCORES])) == pytest.approx(0.5)
    assert np.isnan(level_ratio(np.concatenate([SCORES, -SCORES])))


def test_batches_are_what_single_designs_are():
    batch = np.stack([SCORES, SCORES**2, SCORES[::-1]])
    for statistic in (steps, repetition_cv):
        assert np.allclose(statistic(batch), [statistic(each) for each in batch])


def test_only_specimens_of_every_design_are_compared():
    values = np.ones((3, 3, 4))
    values[1, 1] = np.nan  # not pressed there
    values[2] = np.nan  # a design without any score rules nothing out
    assert pressed_everywhere(values).tolist() == [0, 2]
    values[1, 2] = np.nan
    assert pressed_everywhere(values).tolist() == [0, 1, 2]
