"""One press a file: joined, judged as one, and a bad file costs its own presses only."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.settings import SimulationSettings
from emg2vsa.worlds.people.recording import RecordingStream
from tests.small import study_of_files

STUDY = study_of_files(
    "raw/*_{participant}_{specimen}_{repetition}.csv", name="pieces", participants=["ama"], specimens=["foam"],
    emg='[channels.emg]\nEDC.name = "EDC"\nFDS.name = "FDS"\n',
)  # fmt: skip


def write(path: Path, seed: int) -> None:
    settings = SimulationSettings(repetitions=1, seed=seed)
    made = RecordingStream(np.random.SeedSequence(seed), settings, a_v=40e-6, b_v=20e-6, window_n=(0.5, 7)).whole()
    time_s = np.arange(made.force_n.size) / made.fs_hz
    table = np.column_stack([time_s, made.emg_v["EDC"], made.emg_v["FDS"], made.force_n])
    np.savetxt(path, table, "%.9g", ",", header="time (s),EDC (V),FDS (V),Fz (N)", comments="")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pieces")
    (folder / "raw").mkdir()
    for n in (1, 2, 10):
        write(folder / "raw" / f"2026-05-0{n % 9}_ama_foam_{n}.csv", n)
    (folder / "study.toml").write_text(STUDY)
    return folder


def verdict(folder: Path, capsys: pytest.CaptureFixture[str]) -> dict:
    main(["check", str(folder / "study.toml"), "--json", "--jobs", "1"])
    return json.loads(capsys.readouterr().out)["ama"]


def test_three_files_are_three_presses(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = verdict(folder, capsys)
    assert (found["verdict"], found["specimens"][0]["ok"], found["specimens"][0]["found"]) == ("good", 3, 3)


def test_a_bad_file_a_second_match_and_a_new_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = folder / "raw" / "2026-05-01_ama_foam_10.csv"
    kept = good.read_text()
    good.write_text(kept[:60])
    found = verdict(folder, capsys)
    assert (found["verdict"], found["specimens"][0]["found"]) == ("usable", 2)
    assert any(
        "recording not used: " in line["text"] and "_ama_foam_10.csv" in line["text"] for line in found["advice"]
    )
    good.write_text(kept)
    assert verdict(folder, capsys)["verdict"] == "good"
    copy = folder / "raw" / "copy_ama_foam_2.csv"
    copy.write_text(kept)
    found = verdict(folder, capsys)
    assert found["specimens"][0]["found"] == 2
    assert any("2 files, 2026-05-02_ama_foam_2.csv, copy_ama_foam_2.csv" in line["text"] for line in found["advice"])
    copy.rename(folder / "raw" / "x_ama_foam_11.csv")
    found = verdict(folder, capsys)
    assert found["specimens"][0]["found"] == 3
    said = (
        "x_ama_foam_11.csv: expected a recording of its own, but found the same recording as 2026-05-01_ama_foam_10.csv"
    )
    assert any("recording not used: " in line["text"] and said in line["text"] for line in found["advice"])
    write(folder / "raw" / "x_ama_foam_11.csv", 11)
    assert verdict(folder, capsys)["specimens"][0]["found"] == 4
