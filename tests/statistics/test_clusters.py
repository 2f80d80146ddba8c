"""Sorting trials into participants by specimens by repetitions."""

from __future__ import annotations

import numpy as np

from emg2vsa.statistics.clusters import clusters_of, in_order


def test_names_in_natural_order() -> None:
    names = np.array(["S10", "S2", "S1", "a²", "S2", "S"])
    assert in_order(names).tolist() == ["S", "S1", "S2", "S10", "a²"]


def test_table_keeps_the_order_of_repetitions() -> None:
    participant = np.array(["P2", "P1", "P1", "P2", "P1", "P1"])
    specimen = np.array(["S1", "S2", "S1", "S1", "S2", "S2"])
    clusters = clusters_of(participant, specimen, np.arange(6.0), np.array([1, 1, 1, 1, 0, 1], dtype=bool))
    assert clusters.participants.tolist() == ["P1", "P2"]
    assert clusters.specimens.tolist() == ["S1", "S2"]
    np.testing.assert_array_equal(clusters.count, [[1, 2], [2, 0]])
    np.testing.assert_array_equal(clusters.values, [[[2, np.nan], [1, 5]], [[0, 3], [np.nan, np.nan]]])


def test_nothing_admitted_and_nothing_at_all() -> None:
    one = np.array(["P1"])
    assert clusters_of(one, one, np.ones(1), np.zeros(1, dtype=bool)).values.shape == (1, 1, 1)
    none = np.empty(0, dtype=np.str_)
    assert clusters_of(none, none, np.empty(0), np.empty(0, dtype=bool)).values.shape == (0, 0, 1)
