"""``emg2vsa rig run --plate``: from plate indentations on the emulated rig to the stiffness in a study file."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.cli import main

Rig = Callable[..., tuple[int, str, str]]
TRUE = {"S1": 7.63, "S3": 3.35}
STUDY = """\
[[specimens]]
name = "S1" # the hard one
stiffness_n_per_mm = 7 # by hand

[[specimens]]
name = "S3"
"""


FAST = "[emulated]", '[plate]\nramp_mm_per_s = 5\npause_s = 0.1\n\n[emulated]\nworld = "elastic"'


@pytest.fixture
def plates(rig: Rig, rig_file: Callable[..., Path], tmp_path: Path) -> Path:
    status, out, err = rig("run", rig_file(FAST), "--virtual", "--plate", "S1", "--plate", "S3")
    assert status == 0, err
    folder = tmp_path / "runs-virtual-plate"
    assert out == f"emg2vsa tools stiffness {folder}/*\n"
    return folder


def test_plate_runs_give_the_stiffness_of_the_emulated_specimens(
    plates: Path, capsys: pytest.CaptureFixture[str], rig: Rig, tmp_path: Path
) -> None:
    assert main(["tools", "stiffness", str(plates / "S1"), str(plates / "S3"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["trials"]) == 10
    assert min(row["adjusted_r2"] for row in told["trials"]) > 0.99
    for row in told["specimens"]:
        assert (row["presses"], row["mountings"], row["holds_for_further"]) == (5, 1, "mountings")
        assert row["low"] < TRUE[row["specimen"]] < row["high"]
        stated, speed = row["notes"]
        assert stated == "one mounting: a stated SD of 2.0 % between mountings enters, --mountings says otherwise"
        assert float(speed.split()[2]) == pytest.approx(
            5, rel=0.1
        )  # mm/s of this rig file, less what the specimen resists

    study = tmp_path / "study.toml"
    study.write_text(STUDY)
    assert main(["tools", "stiffness", str(plates / "S1"), str(plates / "S3"), "--write", str(study)]) == 0
    capsys.readouterr()
    assert study.read_text().startswith("[[specimens]]\n")
    assert 'name = "S1" # the hard one\n' in study.read_text()
    for table in tomllib.loads(study.read_text())["specimens"]:
        found, error = table["stiffness_n_per_mm"], table["stiffness_se_n_per_mm"]
        assert 0.02 * found < error < 0.03 * found  # mountings differ by 2 %, presses by 1 %, one and five of them
        assert found == pytest.approx(TRUE[table["name"]], abs=3 * error)
        assert table["plate_adjusted_r2"] > 0.99

    assert list(plates.glob("*/press-*")) == []  # no tactile sensor, no frames
    _, _, err = rig("run", tmp_path / "rig.toml", "--virtual", "--plate", "S1")
    assert err == "S1: done before\n"


def test_the_emulated_rig_indents_specimens_that_its_world_has_and_no_run_presses(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rig_file(FAST)
    assert rig("run", path, "--virtual", "--plate", "S4")[0] == 0
    assert main(["tools", "stiffness", str(tmp_path / "runs-virtual-plate" / "S4"), "--json"]) == 0
    kappa = [row["stiffness_n_per_mm"] for row in json.loads(capsys.readouterr().out)["trials"]]
    assert sum(kappa) / len(kappa) == pytest.approx(3.12, rel=0.05)
    status, _, err = rig("run", path, "--plate", "S4")  # the bench of a laboratory has what its rig file names
    assert status == 2
    assert "--plate: expected S1, S3, but found S4." in err


def test_trials_go_where_out_says(rig: Rig, rig_file: Callable[..., Path], tmp_path: Path) -> None:
    status, out, err = rig("run", rig_file(FAST), "--virtual", "--plate", "S1", "--out", tmp_path / "mine")
    assert status == 0, err
    assert out == f"emg2vsa tools stiffness {tmp_path / 'mine'}/*\n"
    assert (tmp_path / "mine" / "S1" / "log.csv").is_file()
    assert not (tmp_path / "mine-plate").exists()


def test_what_is_no_plate_run_is_refused(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = rig_file()
    run = ("run", path, "--virtual")
    assert rig(*run, "--specimen", "S3", "--angle", 0, "--condition", "modular", "--repetitions", 1)[0] == 0
    assert main(["tools", "stiffness", str(tmp_path / "runs-virtual" / "S3_0_modular")]) == 2
    said = "S3_0_modular: expected the folder of a plate indentation, but found a run of modular with the tactile"
    assert said in capsys.readouterr().err
    assert main(["tools", "stiffness", str(tmp_path)]) == 2
    assert "expected the folder of a plate indentation, but found " in capsys.readouterr().err


def test_a_specimen_that_the_study_has_not_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study, log = tmp_path / "study.toml", tmp_path / "S3.csv"
    log.write_text("indentation_mm,force_n\n" + "".join(f"{k / 10},{max(0.0, k / 3 - 3)}\n" for k in range(40)))
    study.write_text('[[specimens]]\nname = "S1"\n')
    assert main(["tools", "stiffness", str(log), "--write", str(study)]) == 2
    assert "study.toml, specimens: expected a specimen S3, but found S1." in capsys.readouterr().err
    assert study.read_text() == '[[specimens]]\nname = "S1"\n'
