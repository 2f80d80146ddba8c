"""``emg2vsa new``: from a folder of recordings to a study that runs."""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.places import recordings_in
from emg2vsa.settings import SimulationSettings
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.recording import RecordingStream

PEOPLE, SPECIMENS = ("ama", "bob"), {"hard": 40e-6, "soft": 20e-6}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A newcomer's folder: a date first, mV, units glued or in brackets, pressing negative."""
    folder = tmp_path_factory.mktemp("lab")
    (folder / "raw").mkdir()
    for i, person in enumerate(PEOPLE):
        for j, (specimen, b_v) in enumerate(SPECIMENS.items()):
            made = RecordingStream(
                np.random.SeedSequence([i, j]), SimulationSettings(repetitions=3), a_v=2 * b_v, b_v=b_v,
                window_n=(0.5, 7),
            ).whole()  # fmt: skip
            time = np.arange(made.force_n.size) / 1000
            table = np.column_stack([time, 1e3 * made.emg_v["EDC"], 1e3 * made.emg_v["FDS"], -made.force_n])
            head = "time (s),Ch1 ExtDig (mV),FDS_mV,Fz [N]"
            name = f"2026-05-{10 * i + j:02d}_{person}_{specimen}_press.csv"
            np.savetxt(folder / "raw" / name, table, "%.9g", ",", header=head, comments="")
    (folder / "raw" / "notes.txt").write_text("bob was tired\nthat day\n")
    return folder


@pytest.fixture
def drafted(folder: Path, tmp_path: Path) -> Path:
    study = tmp_path / "study.toml"
    words = ["--out", str(study), "--stiffness", "hard=6", "--stiffness", "soft=1.5", "--name", "mine"]
    assert main(["new", str(folder), *words, "--no-questions"]) == 0
    return study


def test_the_draft_loads_and_finds_every_file(drafted: Path, folder: Path) -> None:
    study = load_study(drafted)
    assert study.participants == PEOPLE
    assert study.stiffness_n_per_mm == {"hard": 6.0, "soft": 1.5}
    assert [entry.emg_file.is_file() for entry in study.recordings] == [True] * 4
    channels = study.recordings[0].channels
    assert {role: channel.name for role, channel in channels.emg.items()} == {"EDC": "Ch1 ExtDig", "FDS": "FDS"}
    assert (channels.force.name, channels.force.sign) == ("Fz", -1)
    assert "notes.txt" in drafted.read_text()


def test_an_existing_study_file_is_never_replaced(
    drafted: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = drafted.read_text()
    assert main(["new", str(folder), "--out", str(drafted)]) == 2
    assert "expected a new file, but found an existing one" in capsys.readouterr().err
    assert drafted.read_text() == before


def test_what_no_file_tells_is_asked_on_a_terminal(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr("sys.stdin", Terminal("\n\nsix\n6,5\n\n\n"))
    assert main(["new", str(folder), "--out", str(tmp_path / "s.toml")]) == 0
    assert load_study(tmp_path / "s.toml").stiffness_n_per_mm == {"hard": 6.5}


def test_lines_to_fill_are_counted(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "s.toml"
    assert main(["new", str(folder), "--out", str(out), "--json"]) == 0
    lines = json.loads(capsys.readouterr().out)["fill_in_lines"]
    text = out.read_text().splitlines()
    assert [("stiffness" in text[n - 1], "expected_trials" in text[n - 1]) for n in lines] == [
        (True, False), (True, False), (False, True),
    ]  # fmt: skip


def test_force_in_files_of_its_own(folder: Path, tmp_path: Path) -> None:
    for path in (folder / "raw").glob("*.csv"):
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        person, specimen = path.stem.split("_")[1:3]
        for kind, columns, head in (("emg", [0, 1, 2], "time (s),EDC (mV),FDS (mV)"), ("force", [0, 3], "time (s),F")):
            name = tmp_path / f"{person}_{specimen}_{kind}.csv"
            np.savetxt(name, table[:, columns], "%.7g", ",", header=head, comments="")
    assert main(["new", str(tmp_path), "--json"]) == 0
    study = load_study(tmp_path / "study.toml")
    assert [entry.key for entry in study.recordings] == ["ama/hard", "ama/soft", "bob/hard", "bob/soft"]
    assert all(path.is_file() for entry in study.recordings for path in entry.files)
    assert study.recordings[0].force_file == tmp_path / "ama_hard_force.csv"
    force = study.recordings[0].channels.force
    assert (force.name, force.unit, force.sign) == ("F", "N", -1)  # the unit is a guess, and marked


def test_one_name_in_the_files_of_emg_and_of_force(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (folder / "raw").glob("*.csv"):
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        person, specimen = path.stem.split("_")[1:3]
        for kind, columns, head in (("emg", [0, 1, 2], "time (s),Channel 1 (mV),Channel 2 (mV)"),
                                    ("force", [0, 3], "time (s),Channel 1 (N)")):  # fmt: skip
            name = tmp_path / f"{person}_{specimen}_{kind}.csv"
            np.savetxt(name, table[:, columns], "%.7g", ",", header=head, comments="")
    assert main(["new", str(tmp_path), "--json"]) == 0
    study = load_study(tmp_path / "study.toml")
    channels = study.recordings[0].channels
    assert {channel.name for channel in channels.emg.values()} == {"Channel 1", "Channel 2"}
    assert channels.force.name == "Channel 1"
    capsys.readouterr()
    main(["check", str(tmp_path / "study.toml"), "--json"])
    judged = json.loads(capsys.readouterr().out)
    assert [[each["found"] for each in judged[person]["specimens"]] for person in PEOPLE] == [[3, 3], [3, 3]]


def test_channels_of_unknown_rate_are_told_with_what_to_do(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As the single file view has it; with a rate they are known."""
    for path in (folder / "raw").glob("*.csv"):
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        name = tmp_path / "_".join(path.stem.split("_")[1:3])
        np.savetxt(f"{name}.csv", table[:, [3, 1, 2]], "%.7g", ",", header="Fz,emg0,emg1", comments="")
    hint = "Fz, emg0, emg1: rate not known: state it with --fs"
    assert main(["inspect", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count(hint) == 1
    out = tmp_path / "study.toml"
    assert main(["new", str(tmp_path)]) == 0
    assert hint in capsys.readouterr().out
    assert hint in out.read_text()
    out.unlink()
    assert main(["new", str(tmp_path), "--fs", "1000"]) == 0
    assert "--fs" not in capsys.readouterr().out
    assert [*load_study(out).recordings[0].channels.emg] == ["emg0", "emg1"]


def test_a_stiffness_tells_which_part_of_a_name_is_the_specimen(folder: Path, tmp_path: Path) -> None:
    for path in (folder / "raw").glob("*.csv"):
        person, specimen = path.stem.split("_")[1:3]
        (tmp_path / "turned").mkdir(exist_ok=True)
        (tmp_path / "turned" / f"{specimen}_{person}.csv").write_bytes(path.read_bytes())
        if person == "ama":
            (tmp_path / "alone").mkdir(exist_ok=True)
            (tmp_path / "alone" / f"{specimen}.csv").write_bytes(path.read_bytes())
    for name, people in (("turned", ("ama", "bob")), ("alone", ("P01",))):
        assert main(["new", str(tmp_path / name), "--stiffness", "hard=6", "--stiffness", "soft=1.5", "--json"]) == 0
        study = load_study(tmp_path / name / "study.toml")
        assert (study.participants, set(study.stiffness_n_per_mm)) == (people, {"hard", "soft"})


def test_the_end_of_a_specimens_name_is_enough_for_its_stiffness(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "s.toml"
    assert main(["new", str(folder), "--out", str(out), "--stiffness", "ard=6"]) == 0
    assert load_study(out).stiffness_n_per_mm == {"hard": 6.0}


def test_one_table_of_everything_is_to_be_parted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [f"{s},{o},{i / 1000},{i % 7},{i % 5}" for s in ("s1", "s2") for o in ("soft", "hard") for i in range(500)]
    (tmp_path / "all.csv").write_text("\n".join(["subject,object,time_s,EDC_mV,Fz_N", *rows]) + "\n")
    assert main(["new", str(tmp_path), "--stiffness", "soft=1"]) == 2
    told = capsys.readouterr().err
    wanted = "all.csv: expected a recording of one person on one object, but found one with words in subject, object"
    assert wanted in told
    assert "Save one file for each of their values" in told
    assert [path.name for path in tmp_path.iterdir()] == ["all.csv"]


def test_tables_of_bids_are_no_recordings_and_other_tsv_are(tmp_path: Path) -> None:
    names = ("P01_a.tsv", "participants.tsv", "sub-1_events.tsv", "sub-1_channels.tsv", "notes.md")
    for name in names:
        (tmp_path / name).touch()
    assert recordings_in([tmp_path]) == [tmp_path / "P01_a.tsv"]


@pytest.mark.slow
def test_from_a_folder_to_schedules_with_three_lines_edited(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = tmp_path / "study.toml"
    assert main(["new", str(folder), "--out", str(study)]) == 0
    text, edited = study.read_text(), 0
    for value in ("6.0", "1.5"):
        text, n = re.subn(r"# stiffness_n_per_mm = .*", f"stiffness_n_per_mm = {value}", text, count=1)
        edited += n
    text, n = re.subn(r"# expected_trials = 10.*", "expected_trials = 3", text)
    study.write_text(text)
    assert edited + n == 3
    assert main(["run", str(study), "--jobs", "2"]) == 0
    assert main(["schedule", str(study), "--out", str(tmp_path / "schedules")]) == 0
    names = {path.stem for path in (tmp_path / "schedules").glob("*.csv")}
    assert {"hard_modular", "soft_modular"} <= names
