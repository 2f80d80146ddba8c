"""The side files of BIDS-EMG: which ones apply, and what they say about unit, rate and quality.

Presses that a session put aside do not count, and are missing to nobody.
"""

from __future__ import annotations

import json
import os
import time
from dataclasses import replace
from pathlib import Path

import edfio
import numpy as np
import pytest

from emg2vsa.errors import RecordingError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.extraction.remedies import remedy_of
from emg2vsa.readers.bids_sidecars import SideFileIndex, equipment, side_file_paths, side_files
from emg2vsa.readers.front_door import inspect, read
from emg2vsa.readers.session_events import SessionPress, only_counted
from emg2vsa.recordings import Channel
from emg2vsa.session_verdict import judge_session
from emg2vsa.settings import CocontractionSettings, FilterSettings, ForceChannelSettings, WindowSettings

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
    assert side_file_paths(tmp_path / OWN) == tuple(str(tmp_path / name) for name in kept)


def test_the_nearest_channels_table_is_the_one_that_counts(tmp_path: Path) -> None:
    make(tmp_path, "dataset_description.json", "task-press_channels.tsv", OWN)
    assert side_file_paths(tmp_path / OWN) == (str(tmp_path / "task-press_channels.tsv"),)
    near = OWN.replace("emg.bdf", "channels.tsv")
    make(tmp_path, near)
    assert side_file_paths(tmp_path / OWN) == (str(tmp_path / near),)


def test_without_a_root_only_the_own_folder_counts(tmp_path: Path) -> None:
    make(tmp_path, "task-press_emg.json", OWN, own := OWN.replace(".bdf", ".json"))
    assert side_file_paths(tmp_path / OWN) == (str(tmp_path / own),)


def test_a_relative_path_finds_the_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "dataset_description.json", "task-press_emg.json", OWN)
    monkeypatch.chdir((tmp_path / OWN).parent)
    assert side_file_paths(Path(Path(OWN).name)) == (str(tmp_path / "task-press_emg.json"),)


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
    assert sorted(map(str, opened)) == sorted(side_file_paths(path))


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
    assert [Path(p).name for p in side_file_paths(path)] == [
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
    assert [Path(path).name for path in alone[7]] == [
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


@pytest.fixture(scope="module")
def trials() -> Trials:
    """Four presses, at 3, 8, 13 and 18 s, each from 0.5 to 7 N within two seconds."""
    rng = np.random.default_rng(2)
    time_s = np.arange(0, 24, 1e-3)
    force_n = np.zeros(time_s.size)
    for start_s in (3.0, 8.0, 13.0, 18.0):
        x = time_s - start_s
        force_n = np.maximum(force_n, np.clip(x / 2, 0, 1) * 7.5 * np.clip((3.0 - x) / 0.4, 0, 1))
    level_v = 20e-6 + 10e-6 * np.log(np.maximum(force_n, 0.4))
    emg = {"EDC": Channel("EDC", rng.normal(size=time_s.size) * level_v, "V", 1000.0, 0.0, "")}
    force = Channel("Fz", force_n + 0.01 * rng.normal(size=time_s.size), "N", 1000.0, 0.0, "")
    made = extract_trials(
        emg, force, participant="P01", specimen="S1", filters=FilterSettings(), cocontraction=CocontractionSettings(),
        window=WindowSettings(), force_channel=ForceChannelSettings(name="Fz"),
    )  # fmt: skip
    assert made.repetition.size == 4
    return replace(made, verdict=np.array(["ok"] * 4), reasons=("",) * 4, remarks=())


def test_presses_by_the_attempt_that_they_lie_in(trials):
    presses = [
        SessionPress(2.9, 6.0, True, ""),
        SessionPress(7.9, 11.0, False, "operator: repeat: too fast; dips"),
        SessionPress(17.9, np.inf, False, "interrupted"),
    ]
    counted = only_counted(trials, presses)
    assert counted.verdict.tolist() == ["ok", "rejected", "rejected", "rejected"]
    assert counted.reasons == (
        "", "operator: repeat: too fast, dips", "session: not a press that the screen asked for",
        "session: interrupted",
    )  # fmt: skip
    said = replace(trials, reasons=("too silent",) * 4)
    assert only_counted(said, presses).reasons[1] == "operator: repeat: too fast, dips; too silent"
    assert only_counted(said, presses).reasons[0] == "too silent"
    said = replace(trials, reasons=("too fast; dips",) * 4)
    assert only_counted(said, presses).reasons[1] == "operator: repeat: too fast, dips"


def test_the_larger_share_of_a_press_decides(trials):
    first = trials.start_s[0]
    long, short = SessionPress(first - 1, first + 1.2, False, "aborted"), SessionPress(first + 1.2, first + 5, True, "")
    assert only_counted(trials, [long, short]).verdict[0] == "rejected"
    assert only_counted(trials, [long._replace(counts=True), short._replace(counts=False)]).verdict[0] == "ok"


def test_a_repeated_press_is_missing_to_nobody(trials):
    presses = [SessionPress(start_s - 0.2, start_s + 3, True, "") for start_s in (3.0, 8.0, 13.0)]
    presses.append(SessionPress(17.8, 21.0, False, "operator: repeat: too fast"))
    found = judge_session("P01", [only_counted(trials, presses)], {}, {"S1": 3}, {})
    assert found.verdict == "good"
    (own,) = found.specimens
    assert (own.found, own.ok, own.rejected) == (3, 3, 0)
    assert own.problems == ("press 4 rejected: operator: repeat: too fast",)
    one_short = judge_session("P01", [only_counted(trials, presses)], {}, {"S1": 4}, {})
    assert one_short.verdict == "repeat" or "3 presses found, 4 wanted" in one_short.specimens[0].problems


def test_nothing_is_to_be_done_about_a_press_that_was_put_aside():
    assert remedy_of("press 4 rejected: operator: repeat: lasted 0.3 s, shorter than 0.5 s") == ""


def test_electrodes_and_amplifier_are_told_as_far_as_the_side_file_states_them(tmp_path: Path) -> None:
    stated = {"ElectrodeType": " wet \n gel", "InterelectrodeDistance": 10, "EMGGround": "n/a (simulated)", "Other": 1}
    path = bids(tmp_path, HEAD, **stated)
    assert equipment(path) == ("ElectrodeType: wet gel", "InterelectrodeDistance: 10")
    assert equipment(tmp_path / "press.csv") == ()
