"""Rows placed by the counter that a device writes beside its samples."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.readers.on_demand import counted


@pytest.mark.parametrize("counter", [[7.0, 8.0], [14.0, 15.0, 0.0, 1.0], [65534.0, 65535.0, 0.0]])
def test_a_counter_that_rises_by_one_and_wraps_says_nothing(counter: list[float]) -> None:
    found = counted(np.array(counter), "nSeq", 1000.0)
    assert (found.at, found.notes) == (None, ())
    np.testing.assert_array_equal(found.placed(np.arange(len(counter))), np.arange(len(counter)))


def test_two_rows_tell_of_samples_lost_between_them() -> None:
    found = counted(np.array([7.0, 9.0]), "nSeq", 1000.0)
    np.testing.assert_array_equal(found.placed(np.array([1.0, 2.0])), [1.0, np.nan, 2.0])
    assert found.notes == ("nSeq: 1 samples were lost, the first after 0 s; they are missing.",)


@pytest.mark.parametrize("counter", [[0.0, np.nan, 2.0], [0.0, np.inf], [2.0**53, 1.0]])
def test_a_counter_with_blank_cells_is_not_followed(counter: list[float]) -> None:
    found = counted(np.array(counter), "nSeq", 1000.0)
    assert found.at is None
    assert found.notes == ("nSeq holds blank cells; the rows were counted instead.",)


def test_one_row_needs_no_counter() -> None:
    found = counted(np.array([np.nan]), "nSeq", 1000.0)
    assert (found.at, found.n_samples, found.notes) == (None, 1, ())
