"""``casr kappa`` on simulated presses, and what it says of bad tables of specimens."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from casr.cli import main

HEAD = "press,specimen,stiffness_n_per_mm\n"


def _table(folder: Path, text: str) -> str:
    file = folder / "specimens.csv"
    file.write_text(text, encoding="utf-8")
    return str(file)


def test_kappa_of_an_unknown_specimen(presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = _table(tmp_path, f"{HEAD}S1_00deg_01,S1,7.63\nS5_00deg_01,S5,\n")
    assert main(["kappa", str(presses), "--specimens", table, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    soft = found["specimens"]["S5"]
    assert soft["low"] < 1.11 < soft["high"]
    assert soft["kappa_n_per_mm"] == pytest.approx(1.11, rel=0.35)
    assert list(found["specimens"]) == ["S5"]
    assert "S1 " not in json.dumps(found["notes"])


def test_its_page_shows_each_specimen_and_says_what_the_console_says(
    presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = _table(tmp_path, f"{HEAD}S1_00deg_01,S1,7.63\nS5_00deg_01,S5,\n")
    page = tmp_path / "kappa.html"
    assert main(["kappa", str(presses), "--specimens", table, "--page", str(page)]) == 0
    cells, text = capsys.readouterr().out.splitlines()[1].split(), page.read_text(encoding="utf-8")
    assert text.count("<figure>") == 1
    assert f"S5: {cells[1]} N/mm" in text
    assert f">{cells[5]}<" in text  # whether determined
    assert "pins alone" in text
    assert "1 specimen of known stiffness" in text


def test_travel_in_the_force_log_is_a_cue(presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The indenter goes in as into springs in series; of one press backwards."""
    folder = tmp_path / "presses"
    shutil.copytree(presses, folder)
    for press, mm_per_n in (("S1_00deg_01", 0.25), ("S1_00deg_02", 0.25), ("S5_00deg_01", 0.6), ("S5_00deg_02", -0.6)):
        head, *rows = (folder / press / "force.csv").read_text(encoding="utf-8").split()
        travels = [f"{row},{50 + mm_per_n * float(row.split(',')[1]):.4f}" for row in rows]
        (folder / press / "force.csv").write_text("\n".join([f"{head},travel_mm", *travels]), encoding="utf-8")
    known = "S1_00deg_01,S1,7.63\nS1_00deg_02,S1,7.63\n"
    table = _table(tmp_path, f"{HEAD}{known}S5_00deg_01,S5,\nS5_00deg_02,S5,\n")
    assert main(["kappa", str(folder), "--specimens", table, "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)["specimens"]["S5"]["by_cue"]) >= {"pins", "travel"}
    assert main(["score", str(folder / "S5_00deg_02"), "--json"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out)["travel_mm_per_n"] is None
    assert "travel_mm is not used" in told.err
    assert main(["score", str(folder / "S5_00deg_01"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["travel_mm_per_n"] == pytest.approx(0.6, rel=0.02)


def test_a_file_in_place_of_a_folder_is_told(presses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = next(path for path in presses.rglob("*") if path.is_file())
    assert main(["kappa", str(file)]) == 2
    assert "expected a folder of presses, but found a file" in capsys.readouterr().err


def test_a_page_among_the_presses_is_refused(presses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kappa", str(presses), "--page", str(presses / "kappa.html")]) == 2
    assert "--page" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("press,specimen\n", "no stiffness_n_per_mm"),
        (f"{HEAD}S9_00deg_01,S9,\n", "'S9_00deg_01'"),
        (f"{HEAD}S1_00deg_01,S1,7\nS1_00deg_01,S1,7\n", "each once"),
        (f"{HEAD}S1_00deg_01,S1,soft\n", "'soft'"),
        (f"{HEAD}S1_00deg_01,S1,-2\n", "a number from 0.01 to 10000"),
        (f"{HEAD}S1_00deg_01,S1,7,63\n", "decimal points, not commas"),
        (HEAD, "no press"),
    ],
)
def test_a_bad_table_is_refused(
    text: str, words: str, presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["kappa", str(presses), "--specimens", _table(tmp_path, text)]) == 2
    assert words in capsys.readouterr().err


def test_a_table_that_is_not_there_is_asked_for(presses: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["kappa", str(presses)]) == 2
    assert "specimens.csv" in capsys.readouterr().err
