"""A data set as a whole: written anew, or beside what others wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.bids.dataset import DataSet, write_dataset, write_scans
from emg2vsa.bids.names import RecordingName
from emg2vsa.errors import DataError

SET = DataSet("mine", "Made.", "Text.\n", participants=("P02",), ethics="2026-7", events={"press": {"a": {}}})


def test_what_is_not_known_is_not_said(tmp_path: Path) -> None:
    write_dataset(tmp_path, SET)
    told = json.loads((tmp_path / "dataset_description.json").read_text())
    assert (told["Name"], told["DatasetType"], told["EthicsApprovals"]) == ("mine", "raw", ["2026-7"])
    assert not {"License", "Authors"} & told.keys()
    assert (tmp_path / "README.md").read_text() == "# mine\n\nText.\n"
    assert (tmp_path / "participants.tsv").read_text() == "participant_id\nsub-P02\n"
    assert {path.name for path in tmp_path.iterdir()} == {
        "dataset_description.json", "README.md", "participants.tsv", "participants.json", "task-press_events.json",
    }  # fmt: skip


@pytest.mark.parametrize("keep", [True, False])
def test_what_others_wrote_stays_where_that_is_asked_for(keep: bool, tmp_path: Path) -> None:
    for name in ("dataset_description.json", "README.rst", "participants.json"):
        (tmp_path / name).write_text("theirs")
    (tmp_path / "participants.tsv").write_text("participant_id\tage\nsub-P01\t31\nsub-P02\t40\n")
    write_dataset(tmp_path, SET, keep=keep)
    for name in ("dataset_description.json", "participants.json"):
        assert ((tmp_path / name).read_text() == "theirs") == keep
    assert (tmp_path / "README.md").exists() != keep
    kept = "participant_id\tage\nsub-P01\t31\nsub-P02\t40\n"
    assert (tmp_path / "participants.tsv").read_text() == (kept if keep else "participant_id\nsub-P02\n")


def test_scans_stand_in_time_order_and_go_with_their_files(tmp_path: Path) -> None:
    def rows() -> list[str]:
        return (tmp_path / "sub-P02" / "sub-P02_scans.tsv").read_text().splitlines()

    old, lost, new = (RecordingName("P02", task) for task in ("old", "lost", "new"))
    old.path(tmp_path).parent.mkdir(parents=True)
    old.path(tmp_path).touch()
    write_scans(tmp_path, "P02", {old: "2", lost: "1"})
    assert rows() == ["filename\tacq_time", "emg/sub-P02_task-lost_emg.bdf\t1", "emg/sub-P02_task-old_emg.bdf\t2"]
    write_scans(tmp_path, "P02", {new: "3"}, keep=True)
    assert rows() == ["filename\tacq_time", "emg/sub-P02_task-old_emg.bdf\t2", "emg/sub-P02_task-new_emg.bdf\t3"]


def test_a_table_that_is_none_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "participants.tsv").write_text("age\n31\n")
    with pytest.raises(DataError, match=r"participants.tsv: expected columns participant_id.*found age"):
        write_dataset(tmp_path, SET, keep=True)
    assert (tmp_path / "participants.tsv").read_text() == "age\n31\n"
