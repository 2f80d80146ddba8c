"""``emg2vsa tools stiffness`` on logs as people export them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from emg2vsa.cli import main


def write_log(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def rows(kappa: float, prefix: str = "", separator: str = ",", decimal: str = ".") -> str:
    depth = np.linspace(-0.2, 1.5, 120)
    lines = (f"{prefix}{x:.4f}{separator}{kappa * max(x, 0):.5f}" for x in depth)
    return "\n".join(line.replace(".", decimal) for line in lines) + "\n"


def test_a_file_for_each_specimen(tmp_path, capsys):
    for name, kappa in (("S1", 7.63), ("S5", 1.11)):
        write_log(tmp_path / f"{name}.csv", "indentation_mm,force_n\n" + rows(kappa))
    assert main(["tools", "stiffness", str(tmp_path / "S1.csv"), str(tmp_path / "S5.csv")]) == 0
    said = capsys.readouterr().out
    assert 'name = "S1"\nstiffness_n_per_mm = 7.6' in said
    assert "worst adjusted R2 1.0000" in said


def test_many_trials_in_one_table_with_decimal_commas(tmp_path, capsys):
    text = "specimen;trial;indentation_mm;force_n\n"
    text += rows(3.30, "S3;1;", ";", ",") + rows(3.40, "S3;2;", ";", ",")
    assert main(["tools", "stiffness", "--json", str(write_log(tmp_path / "plate.csv", text))]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [(row["specimen"], row["trial"]) for row in found] == [("S3", "1"), ("S3", "2")]
    np.testing.assert_allclose([row["stiffness_n_per_mm"] for row in found], [3.30, 3.40], rtol=1e-3)


def test_a_force_of_the_wrong_sign_is_said_and_fails(tmp_path, capsys):
    path = write_log(tmp_path / "S1.csv", "indentation_mm,force_n\n" + rows(-7.63))
    assert main(["tools", "stiffness", str(path)]) == 1
    assert "is its sign right?" in capsys.readouterr().out
