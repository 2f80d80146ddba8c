"""``casr sensor`` on simulated presses, and what it says of bad input."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from casr.cli import main

HEAD = "press,specimen,stiffness_n_per_mm\n"
KNOWN = f"{HEAD}S1_00deg_01,S1,7.63\nS1_00deg_02,S1,7.63\nS5_00deg_01,S5,1.11\n"


def _table(folder: Path, text: str) -> str:
    file = folder / "specimens.csv"
    file.write_text(text, encoding="utf-8")
    return str(file)


def test_a_sensor_is_identified_and_its_file_read_back(
    presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, table = tmp_path / "sensor.toml", _table(tmp_path, KNOWN)
    assert main(["sensor", str(presses), "--specimens", table, "-o", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    found = said["quantities"]
    truth = {
        "pole_x_px": 149.5, "pole_y_px": 149.5, "pin_length_mm": 3.0, "depth_mm": 50.0, "gel_over_skin": 0.03 / 0.8,
        "skin_modulus_mpa": 0.8, "gel_modulus_mpa": 0.03,
    }  # fmt: skip
    for name, true in truth.items():
        assert abs(found[name]["value"] - true) < 2.5 * found[name]["sd"], name
        assert found[name]["told"], name
    assert said["misfit"] < 0.01 < said["misfit_before"]
    for command in (
        ["score", str(presses / "S1_00deg_01"), "--camera", str(out)],
        ["kappa", str(presses), "--specimens", table, "--camera", str(out)],
    ):
        assert main([*command, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)
    assert main(["sensor", str(presses), "--specimens", table, "-o", str(out)]) == 2
    assert "--overwrite" in capsys.readouterr().err


def test_the_table_says_what_is_told(presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "sensor.toml"
    out.write_text("old", encoding="utf-8")
    table = _table(tmp_path, f"{HEAD}S1_00deg_01,S1,rigid\n")
    assert main(["sensor", str(presses), "--specimens", table, "-o", str(out), "--overwrite"]) in (0, 1)
    said = capsys.readouterr().out
    assert "told by the presses" in said
    assert "left over of the pins' motion" in said
    assert "On a rigid plate alone" in said
    assert out.read_text(encoding="utf-8").startswith("[camera]")


def test_a_press_that_cannot_be_read_is_named(
    presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("S1_00deg_01", "S5_00deg_01"):
        shutil.copytree(presses / name, tmp_path / name)
    (tmp_path / "S5_00deg_01" / "force.csv").write_text("nothing\n", encoding="utf-8")
    _table(tmp_path, f"{HEAD}S1_00deg_01,S1,7.63\nS5_00deg_01,S5,1.11\n")
    assert main(["sensor", str(tmp_path), "-o", str(tmp_path / "sensor.toml")]) == 1
    assert "not used: S5_00deg_01" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"{HEAD}S1_00deg_01,S1,\n", "a known specimen, or a rigid plate"),
        (f"{HEAD}S9_00deg_01,S9,7\n", "'S9_00deg_01'"),
        (f"{HEAD}S1_00deg_01,S1,rigit\n", "a number from 0.01 to 10000, rigid, or nothing"),
    ],
)
def test_a_bad_table_is_refused(
    text: str, words: str, presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "sensor.toml"
    assert main(["sensor", str(presses), "--specimens", _table(tmp_path, text), "-o", str(out)]) == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


def test_a_folder_is_no_file_to_write(presses: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sensor", str(presses), "-o", str(tmp_path), "--overwrite"]) == 2
    assert "--out" in capsys.readouterr().err
