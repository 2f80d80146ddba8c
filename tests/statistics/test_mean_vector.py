"""Hotelling's test against its one-dimensional case and its definition; lengths against points of the ellipsoid."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.statistics.mean_vector import mean_vector

ONE_GROUP = np.zeros(9, dtype=np.int64)


def test_one_dimension_is_the_t_test() -> None:
    values = np.random.default_rng(1).normal(3.0, 1.0, (9, 1))
    found, peer = mean_vector(values, ONE_GROUP), stats.ttest_1samp(values[:, 0], 0)
    assert found.p == pytest.approx(peer.pvalue, rel=1e-10)
    assert found.interval(0.95) == pytest.approx(tuple(peer.confidence_interval(0.95)), rel=1e-7)


def test_means_of_groups_weigh_alike_and_share_a_variance() -> None:
    rng = np.random.default_rng(2)
    groups = np.repeat([0, 1, 2], [3, 4, 9])
    values = rng.normal(1.0, 1.0, (16, 1)) + groups[:, None]
    found = mean_vector(values, groups)
    means = np.array([values[groups == g].mean() for g in range(3)])
    pooled = sum(np.sum((values[groups == g] - means[g]) ** 2) for g in range(3)) / 13
    t = means.mean() / np.sqrt(pooled * (1 / 3 + 1 / 4 + 1 / 9) / 9)
    assert found.dof == 13
    assert found.p == pytest.approx(2 * stats.t.sf(abs(t), 13), rel=1e-10)


def test_lengths_are_those_of_the_ellipsoid() -> None:
    rng = np.random.default_rng(3)
    mixed = rng.standard_normal((3, 3))
    values = np.array([2.0, -1.0, 3.0]) + rng.standard_normal((9, 3)) @ mixed * 0.4
    found = mean_vector(values, ONE_GROUP)
    low, high = found.interval(0.95)
    reach = 3 * 8 / 6 * stats.f.ppf(0.95, 3, 6)
    sphere = rng.standard_normal((200_000, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    points = found.mean + np.sqrt(reach) * sphere @ np.linalg.cholesky(found.covariance).T
    lengths = np.linalg.norm(points, axis=1)
    assert low == pytest.approx(lengths.min(), rel=1e-3)
    assert high == pytest.approx(lengths.max(), rel=1e-3)
    assert low <= lengths.min()
    assert high >= lengths.max()


def test_the_interval_reaches_zero_where_the_test_does_not_reject() -> None:
    rng = np.random.default_rng(4)
    rejected = []
    for _ in range(400):
        found = mean_vector(rng.standard_normal((9, 3)) @ np.diag([1.0, 5.0, 0.2]) * 3, ONE_GROUP)
        assert (found.p < 0.05) == (found.interval(0.95)[0] > 0)
        rejected.append(found.p < 0.05)
    assert 0.02 < np.mean(rejected) < 0.09


@pytest.mark.parametrize("values", [np.ones((3, 3)), np.random.default_rng(0).standard_normal((3, 3)), np.ones((9, 3))])
def test_too_few_or_equal_vectors_say_nothing(values: np.ndarray) -> None:
    found = mean_vector(values, np.zeros(len(values), dtype=np.int64))
    assert np.isnan(found.p)
    assert np.isnan(found.interval(0.95)).all()


def test_the_longest_vector_about_zero_is_half_the_widest_axis() -> None:
    half = np.random.default_rng(5).standard_normal((6, 3))
    found = mean_vector(np.concatenate([half, -half]), np.zeros(12, dtype=np.int64))
    reach = 3 * 11 / 9 * stats.f.ppf(0.9, 3, 9)
    widest = np.sqrt(reach * np.linalg.eigvalsh(found.covariance)[-1])
    assert found.interval(0.9) == pytest.approx((0.0, widest), rel=1e-5)
