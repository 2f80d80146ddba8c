"""Rows of the paper's tests beside their companions: does the verdict change, test by test and for a claim on all?"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.report.companion_rows import (
    change,
    change_of_claim,
    change_of_evidence,
    dunn_bounds,
    how_many,
    pair_rows,
)
from emg2vsa.statistics.kruskal import dunn, kruskal

NAN = np.nan


@pytest.mark.parametrize(
    ("changed", "paper", "other", "says"),
    [
        (change, [0.01], [0.04], "no"),
        (change, [0.01], [0.06], "yes: no longer significant"),
        (change, [0.2], [0.01], "yes: significant"),
        (change, [NAN], [0.01], "cannot be said"),
        (
            change,
            [0.01, 0.02, 0.3],
            [0.06, 0.02, 0.01],
            "yes, for 2 of 3: 1 no longer significant, 1 newly significant",
        ),
        (change, [0.01, NAN, 0.02], [0.2, 0.2, 0.01], "yes, for 1 of 2: 1 no longer significant"),
        (change, [0.05], [0.05], "no"),
        (change_of_claim, [0.01, 0.02], 0.03, "no"),
        (change_of_claim, [0.01, 0.02], 0.3, "yes: not significant"),
        (change_of_claim, [0.2, 0.3], 0.01, "yes: significant"),
        (change_of_claim, [0.2, 0.01], 0.01, "the paper's tests disagree (1 of 2 significant); here significant"),
        (change_of_claim, [0.01], NAN, "cannot be said"),
        (change_of_claim, [NAN], 0.01, "cannot be said"),
        (change_of_evidence, [0.001], [0.01], "no"),
        (change_of_evidence, [0.5], [8.0], "no"),
        (change_of_evidence, [0.5], [2.0], "no evidence either way"),
        (change_of_evidence, [0.04], [4.0], "contradicted"),
        (
            change_of_evidence,
            [0.5, 0.5, 0.04],
            [8.0, 1.0, 5.0],
            "contradicted for 1, no evidence either way for 1 of 3",
        ),
        (change_of_evidence, [0.5], [np.inf], "no"),
        (change_of_evidence, [NAN], [1.0], "cannot be said"),
    ],
)
def test_whether_the_verdict_changes(changed, paper, other, says) -> None:
    """Test by test, for one companion of a family, and by Bayes factors."""
    assert changed(np.array(paper), np.array(other) if isinstance(other, list) else other, 0.05) == says


def test_counts_name_the_p_that_matters() -> None:
    few, many = np.array([0.2, 0.01, 0.6, NAN]), np.array([0.02, 0.01, 0.6])
    assert how_many(few, 0.05, "pairs", "plain") == "1 of 3 pairs significant (smallest p = 0.01)"
    assert how_many(many, 0.05, "pairs", "plain") == "2 of 3 pairs significant (largest p = 0.6)"
    assert how_many(np.array([NAN]), 0.05, "pairs") == "not defined"


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


def test_bounds_of_groups_of_one_size_alone() -> None:
    assert dunn_bounds(np.array([10, 10, 10])) == pytest.approx((0.01109, 0.03326), abs=5e-6)
    assert [dunn_bounds(np.array(count)) for count in ([10, 10, 9], [0, 0], [5])] == [None] * 3


def test_the_papers_test_of_pairs_is_on_the_left_and_its_companion_on_the_right() -> None:
    values = np.array([[[0.0, 1, 2, 3], [0.3, 1.2, 2.4, 3.1], [9.0, 10, 11, 12]]])
    tests = pair_tests(values, group_tests(values))
    rows = pair_rows(tests, 0.05)
    assert [row.paper.partition(":")[0] for row in rows] == [
        *[tests.lsd.method] * 4,
        "Dunn on mean ranks, Bonferroni (MATLAB's multcompare)",
    ]
    names = ("Holm", "Tukey's HSD", "Games-Howell", "False discovery rate", "Mann-Whitney, exact with ties, Holm")
    assert [row.companion.partition(":")[0] for row in rows] == list(names)
    assert rows[1].companion.startswith("Tukey's HSD: 2 of 3 pairs significant (")
    assert rows[0].effect.startswith("|g|")
    assert rows[4].effect.startswith("|r_rb|")
