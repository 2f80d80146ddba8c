"""Which runs a folder holds: the rig's own, or those of a table."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.run_folders.find import find_runs, left_by_emulator, left_out

KNOWN = ("S1", "S3", "S5", "S_new")


def own_run(root: Path, name: str, specimen: str = "S1", angle_deg: float = 30, condition: str = "modular") -> Path:
    folder = root / name
    folder.mkdir(parents=True)
    plan = {"specimen": specimen, "angle_deg": angle_deg, "condition": condition}
    (folder / "plan.json").write_text(json.dumps({"plan": plan, "rig": {}}))
    return folder


def table(root: Path, *rows: str, head: str = "folder\tspecimen\tangle_deg\tcondition") -> None:
    (root / "runs.tsv").write_text("\n".join([head, *rows]) + "\n")


def test_the_rigs_own_runs_say_what_they_are(tmp_path):
    first, again = own_run(tmp_path, "S1_30_modular"), own_run(tmp_path, "S1_30_modular-2")
    other = own_run(tmp_path, "S3_0_high-stiffness", "S3", 0, "high-stiffness")
    (tmp_path / "notes").mkdir()
    runs = find_runs(tmp_path, KNOWN)
    assert [(run.key, run.folders) for run in runs] == [
        ("S1_30_modular", (first, again)),
        ("S3_0_high-stiffness", (other,)),
    ]


def test_runs_of_an_unknown_object_are_left_out_and_named(tmp_path):
    own_run(tmp_path, "S1_30_modular")
    unknown = own_run(tmp_path, "S4_30_modular", "S4")
    (unknown / "kappa.json").write_text("{}")
    (unknown / "press-001").mkdir()
    (unknown / "press-001" / "frames.tif").touch()
    runs = find_runs(tmp_path, KNOWN)
    assert [run.key for run in runs] == ["S1_30_modular"]
    assert left_out(tmp_path, runs) == ("S4_30_modular",)
    (unknown / "kappa.json").unlink()
    with pytest.raises(DataError, match="but found 'S4'"):
        find_runs(tmp_path, KNOWN)


def test_a_table_names_runs_of_any_origin(tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    own_run(tmp_path, "not-listed")
    table(tmp_path, "a\tS1\t45\tmodular", "b\tS5\t0\tconstant-min")
    assert [run.key for run in find_runs(tmp_path, KNOWN)] == ["S1_45_modular", "S5_0_constant-min"]


@pytest.mark.parametrize(
    ("row", "wanted"),
    [
        ("a\tS1\t\tmodular", "line 2: expected a value for angle_deg, but found nothing"),
        ("a\tS1\tsteep\tmodular", "line 2, angle_deg: expected 0 to below 90 degrees, but found 'steep'"),
        ("a\tS9\t0\tmodular", r"line 2, specimen: .* \(S1, S3, S5, S_new\), but found 'S9'"),
        ("a\ts_new\t0\tmodular", "line 2, specimen: .* Did you mean 'S_new'"),
        ("a\tS1\t0\tmodularr", "line 2, condition: expected one of high-stiffness, .* Did you mean 'modular'"),
        ("a\tS1\t0\tHigh stiffness", "line 2, condition: .* Did you mean 'high-stiffness'"),
        ("gone\tS1\t0\tmodular", "line 2, folder: expected a folder beside the table, but found 'gone'"),
    ],
)
def test_a_row_that_makes_no_sense_is_named(tmp_path, row, wanted):
    (tmp_path / "a").mkdir()
    table(tmp_path, row)
    with pytest.raises(DataError, match=wanted):
        find_runs(tmp_path, KNOWN)


ORDERED = "folder\tspecimen\tangle_deg\tcondition\torder"


def test_a_table_may_say_the_order_of_its_folders(tmp_path):
    for name in ("a", "b", "c"):
        (tmp_path / name).mkdir()
    rows = ("a\tS1\t0\tmodular\t3", "b\tS3\t0\tmodular\t1", "c\tS1\t0\tmodular\t2")
    table(tmp_path, *rows, head=ORDERED)
    assert {run.key: run.order for run in find_runs(tmp_path, KNOWN)} == {"S1_0_modular": (3, 2), "S3_0_modular": (1,)}
    table(tmp_path, *(row.rpartition("\t")[0] for row in rows))
    assert {run.order for run in find_runs(tmp_path, KNOWN)} == {()}


@pytest.mark.parametrize(
    ("order", "wanted"),
    [("", "a whole number"), ("first", "a whole number"), ("-11", "a whole number from 1"), ("1", "every place once")],
)
def test_an_order_that_makes_no_sense_is_named(tmp_path, order, wanted):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    table(tmp_path, "a\tS1\t0\tmodular\t1", f"b\tS3\t0\tmodular\t{order}", head=ORDERED)
    with pytest.raises(DataError, match=f"line 3, order: expected {wanted}"):
        find_runs(tmp_path, KNOWN)


def test_an_order_that_is_lost_or_misspelt_is_named(tmp_path):
    (tmp_path / "a").mkdir()
    table(tmp_path, "a\tS1\t0\tmodular", head=ORDERED)
    with pytest.raises(DataError, match=r"line 2, order: expected a whole number from 1.*, but found ''"):
        find_runs(tmp_path, KNOWN)
    table(tmp_path, "a\tS1\t0\tmodular\t1", head=ORDERED.replace("order", "Order"))
    with pytest.raises(DataError, match="header: expected the column order so spelt, but found 'Order'"):
        find_runs(tmp_path, KNOWN)


def test_a_table_without_its_columns(tmp_path):
    table(tmp_path, "a\tS1", head="folder\tname")
    with pytest.raises(DataError, match="columns folder, specimen, angle_deg, condition, but found folder, name"):
        find_runs(tmp_path, KNOWN)


def test_a_plan_that_is_no_plan(tmp_path):
    folder = own_run(tmp_path, "S1_0_modular")
    (folder / "plan.json").write_text("{}")
    with pytest.raises(DataError, match=r"plan.json: expected a plan with specimen, angle_deg and condition"):
        find_runs(tmp_path, KNOWN)


def test_no_folder_holds_no_run(tmp_path):
    assert find_runs(tmp_path / "nowhere", KNOWN) == ()


def test_another_name_of_a_condition_is_its_users_own(tmp_path):
    (tmp_path / "a").mkdir()
    table(tmp_path, "a\tS1\t0\tconstant-low")
    assert [run.condition for run in find_runs(tmp_path, KNOWN)] == ["constant-low"]


@pytest.mark.parametrize("again", ["a", "a/inner", "."])
def test_no_press_is_in_two_rows(tmp_path, again):
    (tmp_path / "a" / "inner").mkdir(parents=True)
    table(tmp_path, "a\tS1\t45\tmodular", f"{again}\tS1\t0\tmodular")
    with pytest.raises(
        DataError,
        match=r"line 3, folder: expected every folder once, but found .*whose presses line "
        r"2 has",
    ):
        find_runs(tmp_path, KNOWN)


def test_folders_with_frames_that_no_row_lists_are_known(tmp_path):
    for name in ("a", "b", "notes"):
        (tmp_path / name / "press-001").mkdir(parents=True)
    (tmp_path / "a" / "press-001" / "frames.tif").touch()
    (tmp_path / "b" / "press-001" / "frames.tif").touch()
    table(tmp_path, "a\tS1\t45\tmodular")
    assert left_out(tmp_path, find_runs(tmp_path, KNOWN)) == ("b",)


def test_runs_that_the_emulated_rig_left(tmp_path):
    assert left_by_emulator(tmp_path / "nowhere") == ()
    own_run(tmp_path, "S1_30_modular")
    emulated = [own_run(tmp_path, name) for name in ("S3_0_modular", "S1_0_modular-2")]
    for folder in (*emulated, tmp_path / "no-run"):
        folder.mkdir(exist_ok=True)
        (folder / "emulated.json").write_text("{}")
    assert left_by_emulator(tmp_path) == (emulated[1], emulated[0])
