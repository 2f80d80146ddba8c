from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.discrimination.run_table import run_table
from emg2vsa.errors import DataError


def test_designs_and_specimens_are_in_order(runs, stiffness_n_per_mm):
    table = run_table(runs[::-1], stiffness_n_per_mm, "S_new")
    assert table.specimens == ("S1", "S_new", "S3", "S5")
    assert (table.new, table.known) == (1, [0, 2, 3])
    designs = list(zip(table.conditions, table.angles_deg.tolist(), strict=True))
    assert designs[:4] == [("high-stiffness", 0), ("high-stiffness", 30), ("high-stiffness", 45), ("modular", 0)]
    assert [name for name, _ in designs[6:]] == ["constant-min", "constant-mean", "constant-max"]
    assert table.design("modular", 30.0) == 4
    assert table.design("modular", 10.0) == -1


def test_every_score_is_at_its_place(runs, stiffness_n_per_mm):
    table = run_table(runs, stiffness_n_per_mm, "S_new")
    for run in runs:
        place = table.design(run.condition, run.angle_deg), table.specimens.index(run.specimen)
        for name in run.casr:
            assert np.array_equal(table.casr[name][place], run.casr[name])
            assert np.array_equal(table.a_c0[name][place], run.a_c0[name])
            assert np.array_equal(table.start_area[name][place], run.start_area[name])
        assert np.array_equal(table.true_a_c0[place], run.true_a_c0)


def test_rejected_presses_have_no_score_and_short_runs_are_padded(run_of, stiffness_n_per_mm):
    short = run_of("S1", 0.0, "modular", presses=4)
    refused = replace(run_of("S5", 0.0, "modular"), verdicts=("rejected", *("ok",) * 9))
    table = run_table([short, refused], stiffness_n_per_mm, "S_new")
    assert np.isfinite(table.casr["edge"]).sum(axis=2).tolist() == [[4, 9]]
    assert np.isnan(table.casr["edge"][0, 1, 0])
    assert table.new == -1


def test_truth_in_millimetres_is_none_for_areas_in_pixels(run_of, stiffness_n_per_mm):
    pixels = replace(run_of("S1", 0.0, "modular"), area_unit="px2")
    assert np.isnan(run_table([pixels], stiffness_n_per_mm, "S_new").true_a_c0).all()


def test_a_condition_nobody_knows_comes_last(run_of, stiffness_n_per_mm):
    runs = [run_of("S1", 0.0, name) for name in ("by hand", "modular")]
    assert run_table(runs, stiffness_n_per_mm, "S_new").conditions == ("modular", "by hand")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda runs: [], "none"),
        (lambda runs: [*runs, runs[0]], "S1_0_high-stiffness more than once"),
        (lambda runs: [replace(runs[0], area_unit="px2"), *runs[1:]], "mm2 and px2"),
        (lambda runs: [replace(runs[0], algorithm="circle"), *runs[1:]], "circle and front"),
        (lambda runs: [replace(runs[0], specimen="S9"), *runs[1:]], "S9"),
    ],
)
def test_what_cannot_be_sorted_is_said(change, says, runs, stiffness_n_per_mm):
    with pytest.raises(DataError, match=says):
        run_table(change(list(runs)), stiffness_n_per_mm, "S_new")
