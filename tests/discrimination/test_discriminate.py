""" """

from __future__ import annotations

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.artifacts import load, save
from emg2vsa.discrimination import discriminate
from emg2vsa.discrimination.conditions import compare_conditions
from emg2vsa.discrimination.run_table import run_table
from emg2vsa.errors import DataError
from emg2vsa.settings import DiscriminationSettings
from tests.rig_worlds import DESIGNS, TRUE_LN, rig_table

FEW = DiscriminationSettings()
KNOWN = ("S1", "S3", "S5")


def scaled(run, level=1.0, noise=1.0):
    """The run with its rates at another level, their scatter about the mean multiplied."""
    rates = {}
    for name, casr in run.casr.items():
        rates[name] = level * (casr.mean() + noise * (casr - casr.mean()))
    return replace(run, casr=rates)


def world(run_of, **human):
    """Rigid and human-like presses that differ by nothing but ``human``, as ``scaled``."""
    rigid = [run_of(name, 0.0, "high-stiffness") for name in ("S1", "S_new", "S3", "S5")]
    return [*rigid, *(scaled(replace(run, condition="modular"), **human) for run in rigid)]


def compared_at_once(runs, stiffness_n_per_mm):
    """Pressed at one place, so that nothing is drift."""
    table = run_table(runs, stiffness_n_per_mm, "S_new")
    return compare_conditions(replace(table, position=np.ones(table.mounting.shape)), 0.05, 0.0)


def test_a_quieter_actuator_separates_further_and_a_noisier_one_less(run_of, stiffness_n_per_mm):
    for noise, sign in ((0.2, 1), (3.0, -1), (1.0, 0)):
        compared = compared_at_once(world(run_of, noise=noise), stiffness_n_per_mm)
        low, high = compared.gap_differences.low[0], compared.gap_differences.high[0]
        assert int(low > 0) - int(high < 0) == sign
        assert compared.cv_ratio.estimate[0] == pytest.approx(noise, rel=0.02)
        # a mean of logarithms falls by half the variance of the presses
        assert compared.gaps.gap[1] == pytest.approx(compared.gaps.gap[0] / noise, rel=0.03)
        assert compared.level_ratio.estimate[0] == pytest.approx(1, abs=0.005)


def test_another_level_alone_separates_no_better(run_of, stiffness_n_per_mm):
    compared = compared_at_once(world(run_of, level=3.0), stiffness_n_per_mm)
    assert compared.level_ratio.estimate[0] == pytest.approx(3)
    assert compared.level_ratio.low[0] > 2.9
    assert compared.gap_differences.gap[0] == pytest.approx(0, abs=1e-9)


def test_the_scatter_of_mountings_that_runs_imply_holds_the_truth(stiffness_n_per_mm):
    """From mountings of a cell; and, mounted once, from conditions of the same specimen and angle."""
    rng, held, tries = np.random.default_rng(5), {1: 0, 3: 0}, 200
    for mountings in held:
        for _ in range(tries):
            found = compare_conditions(rig_table(rng, mountings=mountings, mounting_sd=0.043), 0.05, 0.02)
            held[mountings] += found.mounting_sd[1] <= 0.043 <= found.mounting_sd[2]
            assert found.mountings == (mountings, mountings)
    assert min(held.values()) >= 0.9 * tries


def test_cells_that_differ_by_more_than_two_sds_of_mountings_are_named():
    truth = np.broadcast_to(TRUE_LN, (9, 4)).copy()
    truth[DESIGNS.index(("modular", 45.0)), 2] -= 0.2
    table = rig_table(np.random.default_rng(0), truth, mountings=1, presses=10, mounting_sd=0.01, press_sd=0.01)
    ((design, specimen, change),) = compare_conditions(table, 0.05, 0.043).far
    assert (table.conditions[design], table.angles_deg[design], table.specimens[specimen]) == ("modular", 45, "S3")
    assert change == pytest.approx(-0.2, abs=0.05)


def test_chance_names_as_many_cells_as_two_sds_of_a_normal_difference_say():
    """4.55 % of cells; at two SDs of one mean it would be 16 %."""
    rng, tries = np.random.default_rng(6), 150
    found = [compare_conditions(rig_table(rng, mountings=6, mounting_sd=0.05), 0.05, 0.02) for _ in range(tries)]
    share = sum(len(each.far) for each in found) / sum(each.cells for each in found)
    assert share == pytest.approx(0.0455, abs=0.02)


def test_human_like_is_compared_with_every_condition_at_its_angle(runs, stiffness_n_per_mm):
    found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW)
    names = [(found.table.conditions[i], found.table.angles_deg[i]) for i in found.conditions.other.tolist()]
    assert names == [
        ("high-stiffness", 0), ("constant-min", 0), ("constant-mean", 0), ("constant-max", 0), ("high-stiffness", 30),
        ("high-stiffness", 45),
    ]  # fmt: skip
    assert found.conditions.specimens == ("S1", "S_new", "S3", "S5")


def test_old_and_new_algorithm_beside_the_truth(runs, stiffness_n_per_mm):
    compared = discriminate(runs, stiffness_n_per_mm, "S_new", FEW).algorithms
    assert compared.names[:2] == ("front", "circle")
    by_angle = compared.area_error[1, :3]
    assert by_angle == pytest.approx([0.0, 0.15, 0.41], abs=0.03)
    assert compared.area_error[0] == pytest.approx(np.zeros(9), abs=0.01)
    assert compared.area_ratio[0].tolist() == [1.0] * 9
    assert compared.area_ratio[4] == pytest.approx(np.full(9, 1.1))
    assert (compared.casr_cv[1, :6] > 1.5 * compared.casr_cv[0, :6]).all()
    assert len(compared.gaps) == len(compared.names)
    assert compared.pair == ("S1", "S_new")


def test_results_are_stored_and_come_back(runs, stiffness_n_per_mm, tmp_path):
    found = discriminate(runs, stiffness_n_per_mm, "S_new", FEW)
    save(tmp_path / "found", found)
    again = load(tmp_path / "found")
    for ours, theirs in zip(leaves(found), leaves(again), strict=True):
        assert np.array_equal(ours, theirs, equal_nan=isinstance(ours, np.ndarray) and ours.dtype.kind == "f")


def leaves(value):
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from leaves(getattr(value, field.name))
    elif isinstance(value, tuple) and not all(isinstance(each, str) for each in value):
        for each in value:
            yield from leaves(each)
    elif isinstance(value, dict):
        for each in value.values():
            yield from leaves(each)
    else:
        yield value


def test_a_single_condition_and_angle_without_a_new_specimen(run_of, stiffness_n_per_mm):
    found = discriminate([run_of(name, 0.0, "by hand") for name in KNOWN], stiffness_n_per_mm, "S_new", FEW)
    assert (found.area_by_angle, found.new) == (None, None)
    assert found.conditions.other.size == 0
    assert any("S_new" in note for note in found.notes)
    unnamed = discriminate([run_of(name, 0.0, "by hand") for name in KNOWN], stiffness_n_per_mm, "", FEW)
    assert unnamed.new is None
    assert not any("new specimen" in note for note in unnamed.notes)


def test_a_missing_run_is_told_and_stops_nothing(runs, stiffness_n_per_mm):
    found = discriminate([run for run in runs if run.name != "S_new_30_modular"], stiffness_n_per_mm, "S_new", FEW)
    assert "no scored press: S_new (modular at 30°)" in found.notes
    assert not found.new.discriminated[4]
    assert found.conditions.specimens == KNOWN


@pytest.mark.parametrize("name", ["S1_0_modular", "S5_45_high-stiffness", "S_new_0_constant-max"])
def test_a_run_without_a_scored_press_is_no_warning(name, runs, stiffness_n_per_mm):
    rejected = [replace(run, verdicts=("rejected",) * 10) if run.name == name else run for run in runs]
    found = discriminate(rejected, stiffness_n_per_mm, "S_new", FEW)
    assert np.isfinite(found.conditions.gaps.gap).any()


def test_one_press_each_is_tested_without_a_warning(run_of, stiffness_n_per_mm):
    found = discriminate([run_of(name, 0.0, "modular", presses=1) for name in KNOWN], stiffness_n_per_mm, "S_new", FEW)
    assert np.isnan(found.conditions.gaps.gap).all()


def test_presses_that_all_failed_are_compared_with_nothing(run_of, stiffness_n_per_mm):
    runs = [replace(run_of(name, 0.0, "modular"), verdicts=("rejected",) * 10) for name in KNOWN]
    with pytest.raises(DataError, match="a press that counts and has a score, but found none"):
        discriminate(runs, stiffness_n_per_mm, "S_new", FEW)


def test_scores_without_any_scatter_are_tested_without_a_warning(run_of, stiffness_n_per_mm):
    runs = [scaled(run_of(name, 0.0, "modular"), noise=0.0) for name in KNOWN]
    assert discriminate(runs, stiffness_n_per_mm, "S_new", FEW).spread.kruskal.p[0] < 1e-5


def test_one_known_specimen_is_told_from_nothing(run_of, stiffness_n_per_mm):
    runs = [run_of(name, 0.0, "modular") for name in ("S1", "S_new")]
    with pytest.raises(DataError, match="two specimens or more"):
        discriminate(runs, stiffness_n_per_mm, "S_new", FEW)


def test_the_scores_of_the_runs_own_algorithm_are_tested(run_of, stiffness_n_per_mm):
    runs = [replace(run_of(name, 0.0, "modular"), algorithm="circle") for name in KNOWN]
    found = discriminate(runs, stiffness_n_per_mm, "S_new", replace(FEW, old_algorithm="edge"))
    assert found.algorithms.names[:2] == ("circle", "edge")
    as_if = [
        replace(
            r, algorithm="edge", start_area={"edge": r.start_area["circle"]}, casr=r.casr | {"edge": r.casr["circle"]}
        )
        for r in runs
    ]
    other = discriminate(as_if, stiffness_n_per_mm, "S_new", FEW)
    assert found.spread.worst_p == pytest.approx(other.spread.worst_p)
    assert found.area.kruskal.p == pytest.approx(other.area.kruskal.p)


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
