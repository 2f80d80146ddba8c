"""Intraclass correlations: the table of Shrout and Fleiss, and the laws behind F and the intervals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from emg2vsa.errors import DataError
from emg2vsa.statistics.agreement import KINDS, icc
from emg2vsa.statistics.anova import one_way

RATINGS = np.array([[9, 2, 5, 8], [6, 1, 3, 2], [8, 4, 6, 8], [7, 1, 2, 6], [10, 5, 6, 9], [6, 2, 4, 7.0]])
"""Four judges on six targets, Shrout and Fleiss (1979), table 2."""


def test_the_table_of_shrout_and_fleiss() -> None:
    found = icc(RATINGS)
    np.testing.assert_array_equal(np.round(found.value[0], 2), [0.17, 0.29, 0.71, 0.44, 0.62, 0.91])
    # R, psych::ICC of the same table
    np.testing.assert_array_equal(np.round(found.low[0], 3), [-0.133, 0.019, 0.342, -0.884, 0.071, 0.676])
    np.testing.assert_array_equal(np.round(found.high[0], 3), [0.723, 0.761, 0.946, 0.912, 0.927, 0.986])
    np.testing.assert_array_equal(np.round(found.f[0, :3], 2), [1.79, 11.03, 11.03])
    np.testing.assert_array_equal(np.round(found.p[0, :3], 6), [0.164769, 0.000135, 0.000135])
    np.testing.assert_array_equal(found.df2[0, :3], [18, 15, 15])


def test_values_are_their_definitions() -> None:
    """Mean squares from sums over the table, in integers."""
    n, k, grand = 6, 4, RATINGS.mean()
    subjects = k * np.sum((RATINGS.mean(axis=1) - grand) ** 2) / (n - 1)
    raters = n * np.sum((RATINGS.mean(axis=0) - grand) ** 2) / (k - 1)
    total = np.sum((RATINGS - grand) ** 2)
    error = (total - subjects * (n - 1) - raters * (k - 1)) / ((n - 1) * (k - 1))
    within = (total - subjects * (n - 1)) / (n * (k - 1))
    expected = [
        (subjects - within) / (subjects + (k - 1) * within),
        (subjects - error) / (subjects + (k - 1) * error + k * (raters - error) / n),
        (subjects - error) / (subjects + (k - 1) * error),
        (subjects - within) / subjects,
        (subjects - error) / (subjects + (raters - error) / n),
        (subjects - error) / subjects,
    ]
    np.testing.assert_allclose(icc(RATINGS).value[0], expected, rtol=1e-12)


def test_f_of_the_first_is_the_analysis_of_variance() -> None:
    values = np.random.default_rng(1).standard_normal((7, 9, 5))
    np.testing.assert_allclose(icc(values).f[:, 0], one_way(values).f, rtol=1e-12)
    np.testing.assert_allclose(icc(values).p[:, 0], one_way(values).p, rtol=1e-11)


def test_intervals_cover() -> None:
    """Subject SD 1, rater SD .5, error SD 1: true values 1 / 2, 1 / 2.25 and (without raters) 1 / 2."""
    rng = np.random.default_rng(7)
    d, n, k = 4000, 12, 5
    subject, rater = rng.standard_normal((d, n, 1)), 0.5 * rng.standard_normal((d, 1, k))
    error = rng.standard_normal((d, n, k))
    own, shared = icc(subject + error), icc(subject + rater + error)
    for found, kind, true in ((own, 0, 1 / 2), (shared, 1, 1 / 2.25), (shared, 2, 1 / 2), (shared, 5, 5 / 6)):
        covered = np.mean((found.low[:, kind] <= true) & (true <= found.high[:, kind]))
        assert covered == pytest.approx(0.95, abs=0.013), KINDS[kind]


@given(st.integers(0, 2**32 - 1), st.floats(-1e4, 1e4), st.sampled_from([1e-300, 1e-6, 1.0, 1e300]))
@settings(max_examples=30, deadline=None)
def test_shift_scale_and_order_do_not_matter(seed: int, shift: float, scale: float) -> None:
    rng = np.random.default_rng(seed)
    values = rng.standard_normal((3, 6, 4)) + rng.standard_normal((3, 6, 1))
    found = icc(values)
    for other in ((values + shift) * scale, -values, values[:, rng.permutation(6)][:, :, rng.permutation(4)]):
        np.testing.assert_allclose(icc(other).value, found.value, rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(icc(other).low, found.low, rtol=1e-6, atol=1e-9)
    moved = values + 5 * rng.standard_normal((3, 1, 4))
    np.testing.assert_allclose(icc(moved).value[:, 2], found.value[:, 2], rtol=1e-8)


def test_interval_holds_the_value() -> None:
    values = np.random.default_rng(3).standard_normal((200, 6, 3))
    values += np.random.default_rng(4).standard_normal((200, 6, 1)) * np.linspace(0, 3, 200)[:, None, None]
    found = icc(values)
    assert ((found.low <= found.value) & (found.value <= found.high) | np.isnan(found.low)).all()
    assert np.isfinite(found.low[100:]).all()


def test_gaps_and_hostile_designs() -> None:
    gap = np.vstack([RATINGS, [np.nan, 1.0, 2.0, 3.0]])
    found = icc(gap)
    np.testing.assert_allclose(found.value, icc(RATINGS).value, rtol=1e-13)
    assert "left out: 1" in found.outcome().notes[0]
    np.testing.assert_array_equal(icc([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).value, 1.0)
    np.testing.assert_array_equal(icc([[1.0, 1.0], [2.0, 2.0], [3.0, 3.0]]).low, 1.0)
    for hostile in ([[1.0, 1.0], [1.0, 1.0]], [[1.0, 2.0]], [[1.0], [2.0]], [[np.nan, np.nan], [np.inf, 1.0]]):
        assert np.isnan(icc(hostile).value).all()
        assert "undefined" in icc(hostile).outcome().notes[-1]
    alike = icc([[1.0, 2.0, 3.0], [3.0, 2.0, 1.0], [2.0, 2.0, 2.0]])
    assert alike.value[0, 0] == pytest.approx(-0.5)
    assert alike.value[0, 4] == -np.inf
    assert "negative" in alike.outcome(0, "ICC(2,k)").notes[0]
    with pytest.raises(DataError):
        icc([1.0, 2.0])


def test_outcome_names_the_form() -> None:
    outcome = icc(RATINGS).outcome(0, "ICC(3,k)")
    assert outcome.estimate_name == "ICC(3,k)"
    assert outcome.estimate == pytest.approx(0.909, abs=5e-4)
    assert outcome.df == (5.0, 15.0)
    assert outcome.n == 24
