"""The table of all runs: in which order their mountings were pressed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.discrimination.run_table import run_table


def runs_begun(run_of, times):
    """Runs of two mountings with three and two presses; ``times`` of their mountings, run by run."""
    return [
        replace(run_of(name, 0.0, "modular", 5), mounting=np.array([1, 1, 1, 2, 2]), pressed_at=np.repeat(two, (3, 2)))
        for name, two in zip(("S1", "S3", "S5"), times, strict=True)
    ]


def test_places_of_mountings_follow_the_times_at_which_they_were_begun(run_of, stiffness_n_per_mm):
    table = run_table(runs_begun(run_of, [(40.0, 10.5), (7.0, 1e9), (20.0, 8.0)]), stiffness_n_per_mm, "S_new")
    assert table.position is not None
    assert table.position[0].tolist() == [[5, 5, 5, 3, 3], [1, 1, 1, 6, 6], [4, 4, 4, 2, 2]]


def test_a_mounting_that_goes_on_in_a_further_folder_keeps_its_first_place(run_of, stiffness_n_per_mm):
    runs = runs_begun(run_of, [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])
    runs[0].pressed_at[2] = 99.0
    table = run_table(runs, stiffness_n_per_mm, "S_new")
    assert table.position is not None
    assert table.position[0, 0].tolist() == [1, 1, 1, 2, 2]


@pytest.mark.parametrize("second", [np.nan, 10.5])
def test_without_a_time_of_its_own_for_every_mounting_the_order_is_unknown(run_of, stiffness_n_per_mm, second):
    runs = runs_begun(run_of, [(40.0, 10.5), (7.0, second), (20.0, 8.0)])
    assert run_table(runs, stiffness_n_per_mm, "S_new").position is None


def test_a_place_without_a_press_has_no_position(run_of, stiffness_n_per_mm):
    runs = runs_begun(run_of, [(1.0, 2.0), (3.0, 4.0), (5.0, 6.0)])
    more = replace(run_of("S_new", 0.0, "modular", 6), pressed_at=np.full(6, 7.0))
    table = run_table([*runs, more], stiffness_n_per_mm, "S_new")
    assert table.position is not None
    assert np.isnan(table.position[table.mounting == 0]).all()
    assert np.isfinite(table.position[table.mounting > 0]).all()
