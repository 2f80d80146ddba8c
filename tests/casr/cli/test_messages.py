"""What the command line refuses, and in which words: one row for each."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from casr.cli import main

OF_PINS = ("score {five}", "area {five}", "flow {five} --frames 10,14")
UNUSABLE = [
    ("score {all}/absent", "absent"),
    ("score {one} --start-n 3 --stop-n 2", "--stop-n"),
    ("score {one} --start-n 8", "--stop-n"),
    ("score {one} --start-n 20 --stop-n 30", "S1_00deg_01, force: expected contact, a force of 20 N"),
    ("score {one} --stop-n 9", "S1_00deg_01, force: expected a load up to stop_n (--stop-n), 9 N"),
    ("score {one} --region 1,2", "region"),
    ("score {one} --region image", "a dense engine"),
    ("score {one} --region 150,150,140", "at most the area of the pin array"),
    ("score {five} --region 150,150,2", "region: expected 3 or more pins inside it, but found 1 "),
    ("score {one} --force {all}/none.csv", "none.csv"),
    ("score {one} --camera-lag 60", "camera_lag_s: expected seconds from -10 to 10"),
    ("score {one} --force-rule mean --camera-lag 0.05", "expected a force log with time_s"),
    ("score {one} --force-rule mean --correct-lag", "a force log without times"),
    ("score {all} --force {one}/force.csv", "one press"),
    ("score {one} --domes {all}", "tables of domes"),
    ("score {one} --pins {one}/p.csv", "--pins: expected a place outside"),
    ("score {one} --frames {one}/new/p.csv", "--frames: expected a place outside"),
    ("score {all} --page {all}/p.html", "--page: expected a place outside"),
    ("score {one} --figures {one}", "--figures: expected a place outside"),
    ("score {all} --pins p.csv", "--pins: expected one press, but found 4 presses"),
    ("score {one} --pins p.csv --frames p.csv", "expected two files"),
    ("flow {five} --frames 0,900", "900"),
    ("flow {five} --frames 10,12 --region 150,150,2", "region: expected 3 or more pins inside it, but found 1 "),
    ("flow {five} --frames 9,11 --engine dis --region 150,150,0.1", "region: expected 3 or more rows"),
    ("flow {five} --frames 9,11 --engine horn-schunck --region 150,150,0.1", "region: expected 3 or more rows"),
    *((f"{command} {option}", "--contrast") for command in OF_PINS for option in ("--contrast 220", "--min-area 4000")),
    *((f"{command} {option}", "PinSettings.") for command in OF_PINS
      for option in ("--contrast 300", "--pitch 1", "--expect-pins 2")),
    *((f"{command} --expect-pins 331", "expected 331 pins (--expect-pins), but found 127") for command in OF_PINS),
    ("simulate p --specimens S9", "S9"),
    ("simulate p --angles 95", "--angles"),
    ("simulate p --force-max-n 0.1", "0.5 N"),
    ("simulate p --stick-force-n 1", "--world stick"),
    ("simulate p --world front --stick-force-n 1", "--world stick"),
    ("calibrate --charuco 9x7", "PICTURES: expected a value for a calibration from pictures, but found none. Add"),
    ("calibrate board.png --charuco 9x7 -o c.toml --depth-mm 50",
     "--square-mm: expected a value for a calibration from pictures"),
    ("calibrate board.png --charuco 9x7 -o c.toml --square-mm 5", "--depth-mm or --depth-from"),
    ("bench presses --world tabulated,moon", "'moon'"),
    ("bench numerics --world tabulated", "with presses"),
]  # fmt: skip
NO_SUCH_WORD = [
    ("area x --frames 3", "2 numbers with commas"),
    ("area x --frames 3,3", "two different frame numbers"),
    ("area x --frames -1,3", "--frames"),
    ("area x --threshold-px 0", "above 0"),
    ("area x --contrast -1", "above 0"),
    ("score x --start-n nan", "expected 1 number"),
    ("score x --engine lucas-kanade", "pin-affine"),
    ("score x --pitch 0", "above 0"),
    ("score x --pins p.txt", "p.txt"),
    ("score x --frames p", "'p'"),
    ("score x --quantity both", "both"),
    ("flow x --min-area big", "1 numbers"),
    ("flow x --expect-pins 0", "whole number from 1"),
    ("simulate x --repetitions 0", "whole number from 1"),
    ("simulate x --angles 0;30", "commas"),
    ("simulate x --world moon", "--world"),
    ("simulate x --scatter some", "--scatter"),
    ("simulate x --mounting -1", "--mounting"),
    ("simulate x --world stick --stick-force-n 0", "--stick-force-n"),
    ("calibrate x --charuco 7by5", "expected columns and rows such as 9x7, but found '7by5'"),
    ("calibrate x --charuco 7x5 --chessboard 7x5", "not allowed with"),
    ("calibrate x --square-mm 6", "one of the arguments --charuco --chessboard is required"),
    ("calibrate x --charuco 7x5 --square-mm 0", "above 0"),
    ("calibrate x --charuco 7x5 --square-mm 6 --depth-mm -3", "above 0"),
    ("calibrate x --charuco 7x5 --square-mm 6 --depth-mm 3 --distortion 3", "expected one of"),
    ("calibrate x --charuco 7x5 --square-mm 6 --depth-mm 3 --frame-rate-hz nan", "expected 1 number"),
    ("bench weather", "numerics"),
]


@pytest.fixture
def of(presses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Path]:
    """Places that rows name; the working folder is empty."""
    monkeypatch.chdir(tmp_path)
    return {"all": presses, "one": presses / "S1_00deg_01", "five": presses / "S5_00deg_01"}


@pytest.mark.parametrize(("words", "said"), UNUSABLE)
def test_unusable_input_is_said_in_one_line(
    words: str, said: str, of: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(shlex.split(words.format(**of))) == 2
    error = capsys.readouterr().err
    assert error.startswith("casr: ")
    assert said in error
    assert len(error.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("words", "said"), NO_SUCH_WORD)
def test_words_that_no_option_knows(words: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(shlex.split(words))
    assert stopped.value.code == 2
    assert said in capsys.readouterr().err
