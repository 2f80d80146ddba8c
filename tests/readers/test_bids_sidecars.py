"""The side files of BIDS-EMG: which ones apply, and what they say about unit, rate and quality."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

import edfio
import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.readers.bids_sidecars import SideFileIndex, side_file_paths, side_files
from emg2vsa.readers.front_door import inspect, read

HEAD = "name\ttype\tunits\tsampling_frequency\tstatus\tstatus_description\n"


def bids(root: Path, rows: str, unit: str = "uV", **emg: object) -> Path:
    folder = root / "sub-01" / "emg"
    folder.mkdir(parents=True)
    (root / "dataset_description.json").write_text("{}")
    (root / "task-press_emg.json").write_text(json.dumps({"SamplingFrequency": 500, "TaskName": "press"}))
    (folder / "sub-01_task-press_channels.tsv").write_text(rows)
    if emg:
        (folder / "sub-01_task-press_emg.json").write_text(json.dumps(emg))
    path = folder / "sub-01_task-press_emg.bdf"
    x = np.random.default_rng(0).normal(size=3000)
    units = {"EDC": unit, "Fz": "N"}
    edfio.Bdf([edfio.BdfSignal(x, 1000, label=k, physical_dimension=u) for k, u in units.items()]).write(path)
    return path


def test_unit_counts_only_where_the_header_has_none(tmp_path: Path) -> None:
    recording = read(bids(tmp_path, HEAD + "EDC\tEMG\tmV\t1000\tgood\tn/a\n", unit="", SamplingFrequency=1000), ["EDC"])
    assert recording.channels[0].conversion == "mV x 0.001 = V"
    assert recording.notes == ()


def test_notes(tmp_path: Path) -> None:
    path = bids(tmp_path, HEAD + "EDC\tEMG\tV\t2000\tbad\tcable\nFz\tMISC\tN\t1000\tgood\tn/a\n")
    recording = read(path, ["EDC", "Fz"])
    assert recording.channel("EDC").conversion == "uV x 1e-06 = V"
    said = "\n".join(recording.notes)
    assert "_emg.json states 500 Hz, the file 1000 Hz" in said  # inherited from the root of the data set
    assert "header states uV, channels.tsv V; the header counts" in said
    assert "marks this channel bad (cable)" in said
    assert "channels.tsv states 2000 Hz" in said
    assert "Fz" not in said


@pytest.mark.parametrize(("stated", "told"), [(1000.9, False), (999.1, False), (1001.1, True), (998.9, True)])
def test_a_rate_that_is_a_thousandth_off_is_told(tmp_path: Path, stated: float, told: bool) -> None:
    notes = read(bids(tmp_path, HEAD, SamplingFrequency=stated), ["EDC"]).notes
    assert any("_emg.json states" in note for note in notes) is told


def test_voltage_against_force_leaves_the_unit_open(tmp_path: Path) -> None:
    recording = read(bids(tmp_path, HEAD + "EDC\tMISC\tN\tn/a\tgood\tn/a\n"), ["EDC"])
    assert recording.channels[0].unit == ""
    assert any("different quantities" in note for note in recording.notes)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("channel\tunits\nEDC\tV\n", "a column 'name'"),
        (HEAD + "EDC\tEMG\tV\tfast\n", "line 2, column 'sampling_frequency'"),
    ],
)
def test_damaged_side_files(tmp_path: Path, rows: str, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        inspect(bids(tmp_path, rows))


def make(root: Path, *names: str) -> None:
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("{}")


OWN = "sub-01/ses-a/emg/sub-01_ses-a_task-press_acq-S1_emg.bdf"


def test_inheritance_keeps_what_fits_and_puts_the_general_first(tmp_path: Path) -> None:
    kept = (
        "channels.tsv", "emg.json", "task-press_emg.json", "sub-01/sub-01_emg.json",
        "sub-01/ses-a/emg/sub-01_ses-a_task-press_acq-S1_emg.json",
    )  # fmt: skip
    make(
        tmp_path, *kept, "dataset_description.json", OWN, "task-grasp_emg.json", "acq-S2_channels.tsv", "myemg.json",
        "sub-01/sub-01_ses-b_emg.json", "sub-02/sub-02_emg.json", "sub-01/ses-a/emg/sub-01_ses-a_task-press_events.tsv",
    )  # fmt: skip
    assert side_file_paths(tmp_path / OWN) == tuple(tmp_path / name for name in kept)


def test_the_nearest_channels_table_is_the_one_that_counts(tmp_path: Path) -> None:
    make(tmp_path, "dataset_description.json", "task-press_channels.tsv", OWN)
    assert side_file_paths(tmp_path / OWN) == (tmp_path / "task-press_channels.tsv",)
    near = OWN.replace("emg.bdf", "channels.tsv")
    make(tmp_path, near)
    assert side_file_paths(tmp_path / OWN) == (tmp_path / near,)


def test_without_a_root_only_the_own_folder_counts(tmp_path: Path) -> None:
    make(tmp_path, "task-press_emg.json", OWN, own := OWN.replace(".bdf", ".json"))
    assert side_file_paths(tmp_path / OWN) == (tmp_path / own,)


def test_a_relative_path_finds_the_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "dataset_description.json", "task-press_emg.json", OWN)
    monkeypatch.chdir((tmp_path / OWN).parent)
    assert side_file_paths(Path(Path(OWN).name)) == (tmp_path / "task-press_emg.json",)


@pytest.mark.parametrize(
    "name", ["rec.bdf", "sub-01_task-press_emg.csv", "sub-01_task-press_eeg.bdf", "absent/sub-01_emg.bdf"]
)
def test_other_names_and_absent_folders_have_none(tmp_path: Path, name: str) -> None:
    make(tmp_path, "dataset_description.json", "emg.json", "channels.tsv")
    assert side_file_paths(tmp_path / name) == ()


def test_what_is_read_are_the_paths_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = bids(tmp_path, HEAD + "EDC\tEMG\tuV\t1000\tgood\tn/a\n", SamplingFrequency=1000)
    opened: list[Path] = []
    theirs = Path.open
    monkeypatch.setattr(Path, "open", lambda self, *args, **how: opened.append(self) or theirs(self, *args, **how))
    side_files(path)
    assert sorted(opened) == sorted(side_file_paths(path))


def test_real_example(shared_data) -> None:
    path = shared_data("emg/bids/emg_IndependentMod/sub-01/emg/sub-01_task-grasping_emg.edf")
    mne = pytest.importorskip("mne")
    assert [(c.name, c.unit, c.fs_hz, c.n_samples) for c in inspect(path)[1]] == [
        (f"EMG{i}", "uV", 2000.0, 2000) for i in range(1, 7)
    ]
    recording = read(path, ["EMG4"])
    theirs = mne.io.read_raw_edf(path, include=["EMG4"], verbose="error").get_data()[0]
    np.testing.assert_allclose(recording.channels[0].samples, theirs, rtol=1e-9, atol=1e-15)
    assert "channels.tsv V; the header counts" in recording.notes[0]
    assert [p.name for p in side_file_paths(path)] == [
        "sub-01_task-grasping_channels.tsv",
        "sub-01_task-grasping_emg.json",
    ]


def test_an_index_lists_each_folder_once_and_finds_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "dataset_description.json").touch()
    (tmp_path / "task-press_emg.json").touch()
    recordings = []
    for participant in range(40):
        folder = tmp_path / f"sub-{participant}" / "emg"
        folder.mkdir(parents=True)
        for run in range(5):
            stem = f"sub-{participant}_task-press_run-{run}"
            recordings.append(folder / f"{stem}_emg.edf")
            for ending in ("channels.tsv", "emg.json"):
                (folder / f"{stem}_{ending}").touch()
        (folder / f"sub-{participant}_channels.tsv").touch()
    alone = [side_file_paths(path) for path in recordings]
    assert [path.name for path in alone[7]] == [
        "sub-1_task-press_run-2_channels.tsv", "task-press_emg.json", "sub-1_task-press_run-2_emg.json"
    ]  # fmt: skip
    listed = []
    listdir = os.listdir
    monkeypatch.setattr(os, "listdir", lambda folder: listed.append(folder) or listdir(folder))
    index = SideFileIndex()
    assert [side_file_paths(path, index) for path in recordings] == alone
    assert len(listed) == len(set(listed)) == 40 * 2 + 1
    monkeypatch.chdir(recordings[0].parent)
    assert side_file_paths(Path(recordings[0].name), index) == alone[0]
    assert len(listed) == 81


def test_thousands_of_recordings_in_one_folder_take_no_more_than_their_number(tmp_path: Path) -> None:
    (tmp_path / "dataset_description.json").touch()
    recordings = [tmp_path / f"sub-{i // 50}_run-{i % 50}_emg.bdf" for i in range(2000)]
    for path in recordings:
        path.with_name(path.name.replace("emg.bdf", "channels.tsv")).touch()
    index = SideFileIndex()
    side_file_paths(recordings[0], index)
    start = time.process_time()
    assert all(len(side_file_paths(path, index)) == 1 for path in recordings)
    assert (time.process_time() - start) / len(recordings) < 2e-4  # 0.01 ms here; looking at every file takes 1 ms
