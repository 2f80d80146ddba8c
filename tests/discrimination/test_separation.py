from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.discrimination.separation import (
    gap_difference,
    level_ratio,
    pressed_everywhere,
    repetition_cv,
    smallest_gap,
)

SCORES = np.array([[1.0, 2.0, 3.0], [5.0, 6.0, 7.0], [8.0, 10.0, 12.0]])


def test_the_gap_is_cohens_d_of_the_closest_neighbours():
    # (6 - 2) / 1 and (10 - 6) / sqrt((2 + 8) / 4)
    assert smallest_gap(SCORES) == pytest.approx(4 / np.sqrt(2.5))


def test_a_wrong_order_is_negative():
    assert smallest_gap(SCORES[[1, 0, 2]]) == pytest.approx(-4.0)


def test_missing_presses_are_left_out():
    padded = np.concatenate([SCORES, np.full((3, 2), np.nan)], axis=1)
    assert smallest_gap(padded) == smallest_gap(SCORES)
    assert repetition_cv(padded) == repetition_cv(SCORES)


def test_no_spread_and_no_press_have_no_gap():
    assert np.isnan(smallest_gap(np.array([[1.0, 1.0], [2.0, 2.0]])))
    assert np.isnan(smallest_gap(np.array([[1.0, 2.0], [np.nan, np.nan]])))


def test_cv_is_the_root_mean_square_over_specimens():
    cvs = [1 / 2, 1 / 6, 2 / 10]
    assert repetition_cv(SCORES) == pytest.approx(np.sqrt(np.mean(np.square(cvs))))


def test_halves_are_compared():
    both = np.concatenate([SCORES, 2 * SCORES + [[0.0], [0.0], [4.0]]])
    assert gap_difference(both) == pytest.approx(4 / np.sqrt(2.5) - smallest_gap(2 * SCORES + [[0.0], [0.0], [4.0]]))
    assert level_ratio(np.concatenate([SCORES, 2 * SCORES])) == pytest.approx(0.5)
    assert np.isnan(level_ratio(np.concatenate([SCORES, -SCORES])))


def test_batches_are_what_single_designs_are():
    batch = np.stack([SCORES, SCORES**2, SCORES[::-1]])
    for statistic in (smallest_gap, repetition_cv):
        assert statistic(batch).tolist() == pytest.approx([float(statistic(each)) for each in batch])


def test_only_specimens_of_every_design_are_compared():
    values = np.ones((3, 3, 4))
    values[1, 1] = np.nan  # not pressed there
    values[2] = np.nan  # a design without any score rules nothing out
    assert pressed_everywhere(values).tolist() == [0, 2]
