"""``emg2vsa inspect``: one file, a folder, JSON, page, and what it refuses."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.cli import main

TIME = np.arange(4000) / 1000


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    emg = np.random.default_rng(0).normal(0, 1e-4, TIME.size)
    force = 3 - 3 * np.cos(np.pi * TIME)
    table = np.column_stack([TIME, emg, force])
    for name in ("a b.csv", "b.csv"):
        np.savetxt(tmp_path / name, table, "%.7g", ",", header="time (s),EDC (V),F<z> (N)", comments="")
    (tmp_path / "notes.json").write_text("{}")
    for name in (".hidden.csv", "README.txt", "licence-of-data.md", "LICENSE", "sources.csv"):
        (tmp_path / name).write_text("x")
    return tmp_path


def test_one_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(folder / "a b.csv")]) == 0
    out = capsys.readouterr().out
    assert "looks like EMG, by its unit (V) and spectrum" in out
    assert "looks like the force: 0 to 6 N" in out
    assert f"To fit: emg2vsa fit '{folder / 'a b.csv'}' --emg EDC --force 'F<z>'" in out


def test_a_folder_has_a_line_a_file_and_bad_ones_are_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", str(folder)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split("  ")[0] for line in lines[1:]] == [
        str(folder / "a b.csv"),
        str(folder / "b.csv"),
        "2 of 2 files read",
    ]
    (folder / "c.csv").write_text("")
    assert main(["inspect", str(folder), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert len(found["files"]) == 2
    assert found["refused"][0]["found"] == "an empty file"


def test_the_page_has_pictures_and_escapes_names(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = folder / "out" / "look.html"
    assert main(["inspect", str(folder / "b.csv"), "--page", str(page), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert [channel["role"] for channel in facts["channels"]] == ["EMG", "force"]
    text = page.read_text()
    assert text.count("<svg") == 3
    assert "F&lt;z&gt;" in text
    assert "F<z>" not in text


def test_fit_takes_the_rate_of_a_file_without_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    emg = np.random.default_rng(0).normal(0, 1e-4, TIME.size)
    path = tmp_path / "a.csv"
    table = np.column_stack([emg, 4 - 4 * np.cos(np.pi * TIME / 2)])
    np.savetxt(path, table, "%.7g", ",", header="EDC_V,Fz_N", comments="")
    words = ["fit", str(path), "--emg", "EDC", "--force", "Fz"]
    assert main(words) == 2
    assert "expected a sampling rate" in capsys.readouterr().err
    assert main([*words, "--fs", "1000", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found["trials"]) == 1
    assert "EDC: the file states no sampling rate; 1000 Hz as the study states." in found["notes"]
    assert main([*words, "--fs", "0"]) == 2
    assert "channels.emg.EDC.fs_hz: expected a number > 0" in capsys.readouterr().err


def test_what_the_program_made_itself_is_no_recording(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for made, marker in (("reports/x", ".study.json"), ("work", "ledger.jsonl")):
        (folder / made / "tables").mkdir(parents=True)
        (folder / made / marker).write_text("{}")
        (folder / made / "tables" / "fits.csv").write_text("participant,b\nP1,2\n")
    for name in ("a.svg", "a.tex", "a.PNG", "a.html"):
        (folder / name).write_text("x")
    assert main(["inspect", str(folder)]) == 0
    assert capsys.readouterr().out.endswith("2 of 2 files read\n")
    assert main(["inspect", str(folder / "work"), "--json"]) == 1  # asked for by name; the ledger is refused
    assert "fits.csv" in capsys.readouterr().out


def test_a_link_to_nothing_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "c.csv").symlink_to(folder / "annex" / "c.csv")
    assert main(["inspect", str(folder)]) == 1
    said = capsys.readouterr().out
    assert re.search(r"c\.csv +not read", said)
    assert "2 of 3 files read" in said
