"""Bounds of p: the paper's design, and no design of equal groups below them."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.report.p_bounds import dunn_bounds
from emg2vsa.stats.dunn import dunn
from emg2vsa.stats.kruskal import kruskal


def test_three_groups_of_ten() -> None:
    assert dunn_bounds(np.array([10, 10, 10])) == pytest.approx((0.01109, 0.03326), abs=5e-6)


def test_no_design_of_equal_groups_is_below() -> None:
    rng = np.random.default_rng(0)
    for k, n in ((3, 2), (3, 4), (4, 3)):
        bounds = dunn_bounds(np.full(k, n))
        assert bounds is not None
        designs = rng.permuted(np.tile(np.arange(float(k * n)), (5000, 1)), axis=1).reshape(-1, k, n)
        for bound, adjustment in zip(bounds, ("none", "bonferroni"), strict=True):
            worst = np.max(dunn(kruskal(designs), adjustment).p, axis=1)  # type: ignore[arg-type]
            assert worst.min() >= bound - 1e-12


@pytest.mark.parametrize("count", [[10, 10, 9], [0, 0], [5]])
def test_other_designs_have_none(count) -> None:
    assert dunn_bounds(np.array(count)) is None
