"""Does the verdict change: counted test by test, and for a claim on all of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.report.verdicts import change, change_of_claim, change_of_evidence, dunn_bounds, how_many
from emg2vsa.statistics.kruskal import dunn, kruskal

NAN = np.nan


@pytest.mark.parametrize(
    ("paper", "companion", "says"),
    [
        ([0.01], [0.04], "no"),
        ([0.01], [0.06], "yes: no longer significant"),
        ([0.2], [0.01], "yes: significant"),
        ([NAN], [0.01], "cannot be said"),
        ([0.01, 0.02, 0.3], [0.06, 0.02, 0.01], "yes, for 2 of 3: 1 no longer significant, 1 newly significant"),
        ([0.01, NAN, 0.02], [0.2, 0.2, 0.01], "yes, for 1 of 2: 1 no longer significant"),
        ([0.05], [0.05], "no"),
    ],
)
def test_test_by_test(paper, companion, says) -> None:
    assert change(np.array(paper), np.array(companion), 0.05) == says


@pytest.mark.parametrize(
    ("paper", "companion", "says"),
    [
        ([0.01, 0.02], 0.03, "no"),
        ([0.01, 0.02], 0.3, "yes: not significant"),
        ([0.2, 0.3], 0.01, "yes: significant"),
        ([0.2, 0.01], 0.01, "the paper's tests disagree (1 of 2 significant); here significant"),
        ([0.01], NAN, "cannot be said"),
        ([NAN], 0.01, "cannot be said"),
    ],
)
def test_one_companion_of_a_family(paper, companion, says) -> None:
    assert change_of_claim(np.array(paper), companion, 0.05) == says


@pytest.mark.parametrize(
    ("p", "bf01", "says"),
    [
        ([0.001], [0.01], "no"),
        ([0.5], [8.0], "no"),
        ([0.5], [2.0], "no evidence either way"),
        ([0.04], [4.0], "contradicted"),
        ([0.5, 0.5, 0.04], [8.0, 1.0, 5.0], "contradicted for 1, no evidence either way for 1 of 3"),
        ([0.5], [np.inf], "no"),
        ([NAN], [1.0], "cannot be said"),
    ],
)
def test_evidence(p, bf01, says) -> None:
    assert change_of_evidence(np.array(p), np.array(bf01), 0.05) == says


def test_counts_name_the_p_that_matters() -> None:
    few, many = np.array([0.2, 0.01, 0.6, NAN]), np.array([0.02, 0.01, 0.6])
    assert how_many(few, 0.05, "pairs", "plain") == "1 of 3 pairs significant (smallest p = 0.01)"
    assert how_many(many, 0.05, "pairs", "plain") == "2 of 3 pairs significant (largest p = 0.6)"
    assert how_many(np.array([NAN]), 0.05, "pairs") == "not defined"


def test_three_groups_of_ten() -> None:
    assert dunn_bounds(np.array([10, 10, 10])) == pytest.approx((0.01109, 0.03326), abs=5e-6)


def test_no_design_of_equal_groups_is_below() -> None:
    rng = np.random.default_rng(0)
    for k, n in ((3, 2), (3, 4), (4, 3)):
        bounds = dunn_bounds(np.full(k, n))
        assert bounds is not None
        designs = rng.permuted(np.tile(np.arange(float(k * n)), (5000, 1)), axis=1).reshape(-1, k, n)
        found = dunn(kruskal(designs))
        alone = 2 * stats.norm.sf(np.abs(found.z))
        for bound, p in zip(bounds, (alone, found.p), strict=True):
            assert np.max(p, axis=1).min() >= bound - 1e-12


@pytest.mark.parametrize("count", [[10, 10, 9], [0, 0], [5]])
def test_other_designs_have_none(count) -> None:
    assert dunn_bounds(np.array(count)) is None
