"""Rows of the paper's tests beside their companions."""

from __future__ import annotations

import numpy as np

from emg2vsa.companions.groups import group_tests, pair_tests
from emg2vsa.report.companion_rows import pair_rows


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
