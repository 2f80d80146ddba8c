"""The budget of a press: sums, errors, and what each cause does to a and b."""

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.signals.bias import LEAST, BiasBudget, left_in, line_change, taken_out
from emg2vsa.signals.crosstalk import without_crosstalk
from emg2vsa.signals.level_drift import level_drift, level_trends


def test_shifts_of_one_cause_add_and_causes_multiply():
    budget = BiasBudget.of(
        [
            left_in("lag", np.array([0.1, 0.0]), np.array([-0.1, 0.0]), 0.02),
            left_in("lag", np.zeros(2), np.array([-0.1, 0.0]), 0.0),
            left_in("level drift", np.zeros(2), np.array([0.5, np.nan]), 0.0),
            left_in("clipping", np.zeros(2), np.zeros(2)),
            taken_out("rest level", np.array([-0.3, -0.2]), 0.04),
        ],
        2,
    )
    assert budget.causes == ("rest level", "lag", "level drift")
    np.testing.assert_allclose(budget.total, [0.8 * 1.5 - 1, 0.0])
    np.testing.assert_allclose(budget.total_se, np.hypot(0.02, 0.04))
    np.testing.assert_allclose(budget.corrected.sum(axis=0), [-0.3, -0.2])
    assert budget.largest == ("level drift", "rest level")


def test_budgets_of_recordings_join_press_by_press():
    one = BiasBudget.of([left_in("lag", np.zeros(1), np.array([-0.1]))], 1)
    other = BiasBudget.of([left_in("rest level", np.zeros(2), np.array([0.1, 0.2]))], 2)
    joined = BiasBudget.joined([one, other, BiasBudget.of((), 1)])
    assert joined.causes == ("rest level", "lag")
    np.testing.assert_allclose(joined.total, [-0.1, 0.1, 0.2, 0.0])
    assert joined.largest == ("lag", "rest level", "rest level", "")


def test_nothing_takes_more_than_nearly_all_of_b():
    budget = BiasBudget.of([left_in("lag", np.zeros(1), np.array([-3.0]))], 1)
    assert budget.total == LEAST


def test_changes_of_a_and_b_are_those_of_the_lines():
    x = np.tile(np.log(np.linspace(0.5, 7, 60)), 2)
    true = 30 + 15 * x
    a, b = line_change(x, 33 + 12 * x, x, true, true, np.array([0, 60, 120]))
    np.testing.assert_allclose(b, -0.2)
    np.testing.assert_allclose(a, 3 / true[:60].mean())
    assert np.isnan(line_change(x[:5], x[:5], x[:5], x[:5], true[:5], np.array([0, 5]))[1]).all()


def test_crosstalk_of_a_known_share_is_taken_out():
    force_n = np.linspace(0.5, 7, 200)
    own = np.array([10 + 5 * np.log(force_n), 20 + 2 * np.log(force_n)])
    seen = np.array([np.hypot(own[0], 0.3 * own[1]), own[1]])
    left, level = without_crosstalk(seen, seen, ("EDC", "FDS"), {"EDC": {"FDS": 0.3}})
    np.testing.assert_allclose(left, own)
    np.testing.assert_allclose(level, own)


@pytest.mark.parametrize(
    ("shares", "found"),
    [
        ({"EDC": {"FCR": 0.2}}, "FCR"),
        ({"EDC": {"EDC": 0.2}}, "EDC"),
        ({"EDC": {"FDS": 1.0}, "FDS": {"EDC": 1.0}}, "same"),
    ],
)
def test_crosstalk_that_cannot_be_is_refused(shares, found):
    with pytest.raises(SettingError, match=found):
        without_crosstalk(np.ones((2, 4)), np.ones((2, 4)), ("EDC", "FDS"), shares)


def test_a_muscle_that_fades_counts_by_its_share():
    presses, n = 10, 50
    fading = np.exp(-0.8 * np.repeat(np.linspace(0, 1, presses), n))
    envelopes = np.array([60 * fading, np.full(presses * n, 40.0)])
    offsets = n * np.arange(presses + 1)
    slopes, errors = level_trends(envelopes, offsets)
    np.testing.assert_allclose(slopes, [-0.8, 0.0], atol=1e-9)
    shift = level_drift(envelopes, offsets, slopes, errors)
    np.testing.assert_allclose(shift.b, (60 * fading[::n] + 40) / 100 - 1, atol=1e-9)
    assert not level_drift(
        envelopes[:, : 4 * n], offsets[:5], *level_trends(envelopes[:, : 4 * n], offsets[:5])
    ).b.any()
