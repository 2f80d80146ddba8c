"""Rows of the paper's tests beside their companions: what each says, and what it cannot say at all."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.companions.table import table_tests
from emg2vsa.report.companion_rows import COLUMNS, dunn_bounds, group_rows, how_many, pair_rows
from emg2vsa.statistics.clusters import clusters_of
from emg2vsa.statistics.kruskal import dunn, kruskal

NAN = np.nan


def test_counts_name_the_p_that_matters() -> None:
    few, many = np.array([0.2, 0.01, 0.6, NAN]), np.array([0.02, 0.01, 0.6])
    assert how_many(few, 0.05, "pairs", "plain") == "1 of 3 pairs significant (smallest p = 0.01)"
    assert how_many(many, 0.05, "pairs", "plain") == "2 of 3 pairs significant (the others from p = 0.6)"
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


def test_people_come_before_presses_and_what_allows_for_unequal_scatter_before_what_does_not() -> None:
    rng = np.random.default_rng(1)
    who, what, _ = (axis.ravel() for axis in np.indices((5, 3, 4)))
    values = rng.normal(what.astype(float), 1)
    names = np.char.mod("P%d", who), np.char.mod("S%d", what)
    tests = table_tests(clusters_of(*names, values, np.ones(values.size, dtype=np.bool_)), 0.05)
    assert tests.blocks is not None
    rows = [
        row.companion.partition(":")[0]
        for row in group_rows(tests.between_groups, 0.05, "participants", over=tests.blocks)
    ]
    assert rows[0] == "Repeated-measures ANOVA, Greenhouse-Geisser"
    assert rows[1].startswith("Linear mixed model")
    assert rows[3:] == ["Welch's ANOVA", "Kruskal-Wallis", "Bayes factor (JZS)", "Brown-Forsythe"]
    methods = [outcome.method for outcome in tests.blocks.outcomes()]
    assert methods[0] == "repeated-measures ANOVA, Greenhouse-Geisser"


def test_the_share_without_bias_comes_first() -> None:
    values = np.random.default_rng(2).normal(size=(1, 3, 5))
    effect = group_rows(group_tests(values), 0.05, "designs")[0].effect
    assert 0 <= effect.index("ω²") < effect.index("η²")
    many = group_rows(group_tests(np.repeat(values, 2, axis=0)), 0.05, "designs")[0].effect
    assert many.startswith("ω²")
    assert "η²" not in many


def test_no_row_says_whether_a_verdict_changes() -> None:
    assert [column.key for column in COLUMNS] == ["paper", "companion", "effect"]
