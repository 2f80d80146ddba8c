"""``casr simulate``: what it writes, and that it never writes over anything unasked."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from casr.cli import main

SMALL = ["--specimens", "S3", "--angles", "30", "--repetitions", "1"]


def test_a_press_folder_holds_frames_force_camera_and_truth(presses: Path) -> None:
    names = [path.name for path in sorted(presses.iterdir())]
    assert names == ["S1_00deg_01", "S1_00deg_02", "S5_00deg_01", "S5_00deg_02"]
    files = sorted(path.name for path in (presses / names[0]).iterdir())
    assert files == ["camera.toml", "force.csv", "frames.tif", "truth.json"]


def test_softer_specimens_have_the_larger_rate(presses: Path) -> None:
    rate = {
        path.name: json.loads((path / "truth.json").read_text())["truth"]["casr_slope_mm2_per_n"]
        for path in presses.iterdir()
    }
    assert max(rate["S1_00deg_01"], rate["S1_00deg_02"]) < min(rate["S5_00deg_01"], rate["S5_00deg_02"])


def test_presses_that_are_there_are_kept_unless_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "p")
    assert main(["simulate", out, *SMALL]) == 0
    frames = tmp_path / "p" / "S3_30deg_01" / "frames.tif"
    before = frames.read_bytes()
    assert main(["simulate", out, *SMALL, "--seed", "5"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert frames.read_bytes() == before
    assert main(["simulate", out, *SMALL, "--seed", "5", "--overwrite"]) == 0
    assert frames.read_bytes() != before


def test_json_names_every_press(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(tmp_path / "p"), *SMALL, "--json"]) == 0
    (press,) = json.loads(capsys.readouterr().out)["presses"]
    assert press["press"] == "S3_30deg_01"
    assert press["casr_mm2_per_n"] > 0


@pytest.mark.parametrize(
    ("words", "complaint"),
    [(["--specimens", "S9"], "S9"), (["--angles", "95"], "--angles"), (["--force-max-n", "0.1"], "0.5 N")],
)
def test_what_cannot_be_simulated_is_said(
    words: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", str(tmp_path / "p"), *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith("casr: ")
    assert complaint in error
    assert not (tmp_path / "p").exists()
