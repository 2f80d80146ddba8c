"""The schedules of a study and the rig that presses with them are of one actuator, or nothing begins; the controls."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from emg2vsa.claims import paper
from emg2vsa.cli import main
from emg2vsa.pipeline.campaign import campaign
from emg2vsa.pipeline.fingerprint import Values
from emg2vsa.pipeline.stage_order import stage
from emg2vsa.study_file import load_study

CONTROLS = Path(__file__).resolve().parents[2] / "studies" / "controls"


def studied(folder: Path, actuator: str, angles_deg: str = "modular = [0]\n") -> Path:
    text = small_study(tables=WITH_A_RIG)
    study = folder / "study.toml"
    study.write_text(text.replace('actuator = "qbmove-maker-pro"', f'actuator = "{actuator}"'))
    (folder / "rig.toml").write_text(small_rig(angles_deg))
    return study


@pytest.mark.parametrize("words", [["check"], ["run"], ["run", "--only", "emulation"]])
def test_schedules_for_another_actuator_are_refused_before_anything_begins(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study = studied(tmp_path, "qbmove-advanced")
    assert main([words[0], str(study), *words[1:]]) == 2
    wanted = f"expected qbmove-maker-pro, the actuator of {tmp_path / 'rig.toml'}, but found qbmove-advanced."
    said = f"{study}, schedule.actuator: {wanted} Set it to this one, or correct [actuator]."
    assert said in capsys.readouterr().err
    assert not [path for path in tmp_path.rglob("*") if path.suffix in (".result", ".csv", ".tif", ".html")]


def test_schedules_that_press_nothing_may_be_for_any_actuator(tmp_path: Path) -> None:
    assert campaign(load_study(studied(tmp_path, "qbmove-maker-pro"))).mountings
    assert campaign(load_study(studied(tmp_path, "qbmove-advanced", "high-stiffness = [0]\n"))).mountings


def test_a_rig_file_that_is_not_there_yet_stops_no_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = studied(tmp_path, "qbmove-advanced")
    (tmp_path / "rig.toml").unlink()
    assert main(["check", str(study)]) == 1
    assert "rig.toml" not in capsys.readouterr().err


@pytest.mark.parametrize("world", ["N1", "N2", "N3", "P1", "P2", "P3", "P4"])
def test_every_claim_on_the_rig_has_its_presses_in_every_control(world: str) -> None:
    rig = campaign(load_study(CONTROLS / f"{world}.toml")).rig
    assert rig is not None
    assert rig.emulated is not None
    assert rig.emulated.control == world
    pressed = {(run.condition, run.angle_deg) for run in rig.experiment.all_runs()}
    assert pressed == {*paper.CASR_WORST_P, *(("high-stiffness", angle) for angle in paper.AREA_SPECIMENS_P)}
    assert rig.experiment.mountings == 3


def test_the_order_of_the_muscles_is_in_the_key_of_trials(tmp_path: Path) -> None:
    digests = []
    for order in (("EDC", "FDS"), ("FDS", "EDC")):
        folder = tmp_path / order[0]
        folder.mkdir()
        path = folder / "study.toml"
        path.write_text(small_study(muscles=order))
        found = campaign(load_study(path))
        digests.append(Values().part(stage("trials").settings(found, "P01/S1"))[0].digest)
    assert digests[0] != digests[1]
