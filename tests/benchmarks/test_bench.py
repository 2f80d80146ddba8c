"""``emg2vsa tools bench``: an area is measured and kept, and bad input is refused before anything runs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks.bench.run import read_area
from benchmarks.bench.tables import tables
from casr import command_line
from emg2vsa.cli import main


def test_an_area_is_measured_in_a_child_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["tools", "bench", "calibration", "--smoke", "--repeats", "1", "--only", "intervals"]
    assert main([*words, "--out", str(tmp_path), "--json", str(tmp_path / "all.json")]) == 0
    assert "points of coverage off 95 %" in capsys.readouterr().out
    (area,) = json.loads((tmp_path / "all.json").read_text())
    assert [case["name"] for case in area["cases"]] == ["intervals of kappa, 20 calibrations"]
    assert "[calibration](calibration.md)" in (tmp_path / "README.md").read_text()
    assert (tmp_path / "calibration.md").read_text().endswith("<!-- tables: calibration.json -->\n")
    assert "## intervals of kappa, 20 calibrations" in tables(read_area(tmp_path / "calibration.json"), {})


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["condtioning"], "Did you mean conditioning?"),
        (["--smoke", "weather"], "Choose one of these."),
        (["--compare", "no-such-revision", "records"], "a revision of this checkout"),
        (["--compare", "--repeats"], "expected one argument"),
        (["--repeats", "0"], "a whole number from 1"),
        (["records", "--smoke", "--out", "{file}/x"], "--out {file}/x: expected a folder to write to"),
        (["records", "--smoke", "--json", "{file}/x"], "--json {file}: expected a folder to write to"),
        (["stress", "pins"], "bench stress: expected no other area, but found stress pins"),
        (["stress", "--only", "filters"], "bench stress, --only: expected no such option"),
    ],
)
def test_bad_words_are_one_clear_error(
    words: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "file"
    file.touch()
    try:
        status = main(["tools", "bench", *(word.format(file=file) for word in words)])
    except SystemExit as end:
        status = int(end.code or 0)
    assert status == 2
    said = capsys.readouterr().err
    assert complaint.format(file=file) in said
    assert "Traceback" not in said


def test_without_a_checkout_it_says_where_the_benchmarks_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command_line, "SOURCE", tmp_path)
    assert main(["tools", "bench"]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "benchmarks/ beside" in complaint
    assert "Get the sources of emg2vsa" in complaint


def test_areas_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "bench", "--list"]) == 0
    assert "conditioning" in capsys.readouterr().out
