"""``casr simulate``: what it writes, and that it never writes over anything unasked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

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
    [
        (["--specimens", "S9"], "S9"),
        (["--angles", "95"], "--angles"),
        (["--force-max-n", "0.1"], "0.5 N"),
        (["--stick-force-n", "1"], "--world stick"),
        (["--world", "front", "--stick-force-n", "1"], "--world stick"),
    ],
)
def test_what_cannot_be_simulated_is_said(
    words: list[str], complaint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", str(tmp_path / "p"), *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith("casr: ")
    assert complaint in error
    assert not (tmp_path / "p").exists()


@pytest.mark.parametrize(
    "words",
    [["--world", "moon"], ["--scatter", "some"], ["--mounting", "-1"], ["--world", "stick", "--stick-force-n", "0"]],
)
def test_words_that_no_option_knows(words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["simulate", str(tmp_path / "p"), *words])
    assert words[-2] in capsys.readouterr().err


def truth(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "S3_30deg_01" / "truth.json").read_text())
    return found


@pytest.mark.parametrize(
    ("words", "world"),
    [
        ([], "tabulated, stick"),
        (["--world", "tabulated-frictionless"], "tabulated, frictionless"),
        (["--world", "stick"], "stick from 0.43 N"),
        (["--world", "stick", "--stick-force-n", "2"], "stick from 2 N"),
        (["--world", "front", "--force-max-n", "5"], "stick from 5 N"),
    ],
)
def test_the_world_is_the_one_asked_for(words: list[str], world: str, tmp_path: Path) -> None:
    assert main(["simulate", str(tmp_path), *SMALL, *words]) == 0
    assert truth(tmp_path)["truth"]["world"] == world


def test_scatter_is_realistic_unless_there_is_none(tmp_path: Path) -> None:
    for name, words in (("usual", []), ("other", ["--mounting", "3"]), ("none", ["--scatter", "none"])):
        assert main(["simulate", str(tmp_path / name), *SMALL, *words]) == 0
    usual, other, none = (truth(tmp_path / name)["truth"]["drawn"] for name in ("usual", "other", "none"))
    assert set(none.values()) == {0.0, 1.0}
    assert 0 < abs(usual["depth"] - 1) < 0.05
    assert usual["depth"] != other["depth"]
    assert usual["latency_s"] == other["latency_s"], "which belongs to the press"
