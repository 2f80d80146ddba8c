"""Equal variances: nothing is said of groups too small to say it, and why."""

from __future__ import annotations

import numpy as np

from emg2vsa.statistics.anova import brown_forsythe


def test_groups_of_two_are_no_test() -> None:
    """Both values are equally far from their median: F would be infinite for any data."""
    found = brown_forsythe(np.random.default_rng(0).standard_normal((200, 3, 2)))
    assert np.isnan(found.anova.f).all()
    assert np.isnan(found.anova.p).all()
    assert found.outcome().notes == ("undefined: no group has three values",)


def test_equal_distances_are_not_called_equal_values() -> None:
    found = brown_forsythe([[1.0, 3.0, 2.0, 2.0], [5.0, 7.0, 6.0, 6.0]])
    assert np.isfinite(found.anova.f[0])
    alike = brown_forsythe([[1.0, 3.0, 1.0, 3.0], [5.0, 7.0, 5.0, 7.0]])
    assert "equally far from the median" in alike.outcome().notes[0]


def test_groups_of_three_are_said_to_have_no_power() -> None:
    assert "power" in brown_forsythe(np.random.default_rng(1).standard_normal((3, 3))).outcome().notes[-1]


def test_size_with_four_and_more() -> None:
    for n, most in ((4, 0.09), (10, 0.06)):
        p = brown_forsythe(np.random.default_rng(2).standard_normal((4000, 5, n))).anova.p
        assert 0.02 < np.mean(p < 0.05) < most
