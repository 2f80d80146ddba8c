"""What stands beside a recording: what is not known is not said, and what is told has the standard's keys.

A data set as a whole: written anew, or beside what others wrote.

Names of recordings and of what stands beside them.
"""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.bids.dataset import DataSet, write_dataset, write_scans
from emg2vsa.bids.names import RecordingName, beside, is_label, label_of, remove_recording
from emg2vsa.bids.recording import Channel, Event, Recording, event_columns, of_source, told_of_screen
from emg2vsa.bids.recording_files import short_labels, write_recording
from emg2vsa.bids.tables import Column
from emg2vsa.errors import DataError, SettingError

SAMPLES = np.linspace(-1, 1, 2000)
EMG = Channel("EMG 1", SAMPLES, "uV", 1000.0, "edc")
FORCE = Channel("Fz", SAMPLES, "N", 1000.0, None, told="odd")
KIND = Column("What.", levels={"press": "A press."})
COLUMNS = event_columns("When.", "How long.", KIND, {"note": Column("Said.")})
ONE = Recording(
    RecordingName("P01", "press"), [EMG, FORCE], 1000.0, 2.0, 1.0, "test", "emg2vsa 1",
    [Event(0.5, None, "start"), Event(1, 0.25, "press", {"note": "a\tb"})], COLUMNS, 3,
)  # fmt: skip


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def files(folder: Path) -> list[str]:
    return sorted(path.name.removeprefix("sub-P01_task-press_") for path in folder.rglob("*") if path.is_file())


def test_a_recording_is_written_with_what_is_known_of_it(tmp_path: Path) -> None:
    path = write_recording(tmp_path, ONE)
    assert files(tmp_path) == ["channels.tsv", "emg.bdf", "emg.json", "events.tsv"]
    emg, force = table(path.with_name("sub-P01_task-press_channels.tsv"))
    assert (emg["type"], emg["target_muscle"], emg["group"]) == ("EMG", "extensor digitorum communis", "EMG 1")
    assert (emg["interelectrode_distance"], emg["low_cutoff"], emg["status_description"]) == ("n/a", "n/a", "n/a")
    assert (force["type"], force["signal_electrode"], force["status_description"]) == ("MISC", "n/a", "odd")
    told = json.loads(path.with_suffix(".json").read_text())
    assert (told["EMGChannelCount"], told["MiscChannelCount"], told["PowerLineFrequency"]) == (1, 1, "n/a")
    assert "InterelectrodeDistance" not in told
    first, second = table(path.with_name("sub-P01_task-press_events.tsv"))
    assert first == {"onset": "0.500", "duration": "n/a", "trial_type": "start", "note": "n/a"}
    assert (second["duration"], second["note"]) == ("0.250", "a b")


def test_terms_become_keys_of_the_standard_and_further_keys_stand_as_they_are(tmp_path: Path) -> None:
    how = {"skin_preparation": "alcohol", "serial": "7", "Force model": "x", "placement": "wrist"}
    own = replace(ONE, how=how, further={"a_b": 1, "RecordingType": "epoched"}, electrode_mm=10)
    told = json.loads(write_recording(tmp_path, own).with_suffix(".json").read_text())
    assert (told["SkinPreparation"], told["DeviceSerialNumber"], told["ForceModel"]) == ("alcohol", "7", "x")
    assert told["EMGPlacementSchemeDescription"] == "wrist"
    assert (told["a_b"], told["RecordingType"], told["InterelectrodeDistance"]) == (1, "epoched", 10)


def test_events_that_are_not_known_have_no_table_and_a_screen_is_told(tmp_path: Path) -> None:
    write_recording(tmp_path / "a", replace(ONE, events=None))
    assert files(tmp_path / "a") == ["channels.tsv", "emg.bdf", "emg.json"]
    path = write_recording(
        tmp_path / "b", replace(ONE, events=(), screen=told_of_screen(software_version="1", screen_resolution=[3, 2]))
    )
    assert files(tmp_path / "b") == ["channels.tsv", "emg.bdf", "emg.json", "events.json", "events.tsv"]
    told = json.loads(path.with_name("sub-P01_task-press_events.json").read_text())
    assert told["onset"] == {"Description": "When.", "Units": "s"}
    assert told["trial_type"]["Levels"] == {"press": "A press."}
    assert told["StimulusPresentation"] == {
        "SoftwareName": "emg2vsa", "SoftwareVersion": "1", "ScreenResolution": [3, 2],
    }  # fmt: skip


def test_a_name_that_bdf_cannot_hold_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"at most 16 ASCII characters.*found 17 characters"):
        write_recording(tmp_path, replace(ONE, channels=[replace(EMG, label="x" * 17)]))
    assert not list(tmp_path.iterdir())
    assert short_labels(["x" * 17, "x" * 18, "é"]) == ["x" * 16, "x" * 14 + " 2", "channel"]


def test_of_another_data_set_only_how_it_was_recorded_is_taken() -> None:
    assert of_source({"SamplingFrequency": 1, "EMGGround": "wrist"}) == {"EMGGround": "wrist"}


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


@pytest.mark.parametrize(
    ("name", "stem"),
    [
        (RecordingName("P01", "press"), "sub-P01_task-press"),
        (RecordingName("P01", "press", "S1"), "sub-P01_task-press_acq-S1"),
        (RecordingName("P01", "press", "S1", 2, "rate1"), "sub-P01_task-press_acq-S1_run-2_recording-rate1"),
    ],
)
def test_labels_stand_in_the_order_of_the_standard(name: RecordingName, stem: str) -> None:
    assert name.stem == stem
    assert name.path(Path("data")) == Path(f"data/sub-P01/emg/{stem}_emg.bdf")
    assert beside(name.path(Path("data")), "_events.tsv") == Path(f"data/sub-P01/emg/{stem}_events.tsv")


@pytest.mark.parametrize(("text", "label"), [("anna_k", "annak"), ("S1", "S1"), ("é", ""), ("1-2", "12"), ("²", "")])
def test_a_label_has_letters_and_digits_only(text: str, label: str) -> None:
    assert label_of(text) == label
    assert is_label(text) == (text == label)


def test_a_recording_goes_with_all_of_its_files_and_no_other(tmp_path: Path) -> None:
    endings = ("_emg.bdf", "_emg.json", "_channels.tsv", "_events.tsv", "_events.json", "_run-2_emg.bdf")
    for ending in endings:
        (tmp_path / f"sub-P01_task-press{ending}").touch()
    remove_recording(tmp_path / "sub-P01_task-press_emg.bdf")
    assert [path.name for path in tmp_path.iterdir()] == ["sub-P01_task-press_run-2_emg.bdf"]
