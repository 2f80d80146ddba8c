"""Tables of the sensor's own dome, and the thickness of specimens, in a study."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.small_study import small_rig
from casr.errors import SettingError
from emg2vsa.errors import DataError
from emg2vsa.pipeline.campaign import Campaign, campaign
from emg2vsa.pipeline.stage import Given, value_of
from emg2vsa.pipeline.stage_order import items
from emg2vsa.pipeline.stages import calibration, emulation, kappa, runs
from emg2vsa.rig_file import load_rig
from emg2vsa.study import RunEntry, Study
from emg2vsa.study_file import load_study

STUDY = """
[study]
name = "thin"
[[specimens]]
name = "S1"
stiffness_n_per_mm = 5.3
height_mm = 12
[[specimens]]
name = "S2"
stiffness_n_per_mm = 3
[runs]
domes = "mine"
"""


def thin(folder: Path, text: str = STUDY) -> Study:
    (folder / "mine").mkdir(exist_ok=True)
    (folder / "study.toml").write_text(text)
    entries = tuple(RunEntry(name, 0.0, "modular", (folder / name,)) for name in ("S1", "S2"))
    return replace(load_study(folder / "study.toml"), runs=entries)


def test_a_run_is_scored_by_the_tables_of_its_specimens_height(tmp_path: Path) -> None:
    study = thin(tmp_path)
    table = tmp_path / "mine" / "mine_k5.3_h10_stick.npz"
    table.touch()
    of = {entry.specimen: runs.settings(Campaign(study), entry.key) for entry in study.runs}
    assert value_of(of["S1"]["domes"]) == str(tmp_path / "mine")
    assert (of["S1"]["specimen_height_mm"], of["S2"]["specimen_height_mm"]) == (12, None)
    assert runs.files(Campaign(study), study.runs[0].key)["domes"] == [table]


def test_without_tables_of_its_own_the_height_is_told_alone(tmp_path: Path) -> None:
    study = thin(tmp_path, STUDY.replace('domes = "mine"', ""))
    used = runs.settings(Campaign(study), study.runs[0].key)
    assert "domes" not in used
    assert used["specimen_height_mm"] == 12


def test_the_new_specimen_has_a_height_too(tmp_path: Path) -> None:
    new = '[profile]\nnew_specimen = "N"\nnew_stiffness_n_per_mm = 4\nnew_height_mm = 10\n[runs]'
    study = thin(tmp_path, STUDY.replace("[runs]", new))
    study = replace(study, runs=(RunEntry("N", 0.0, "modular", (tmp_path / "N",)),))
    assert runs.settings(Campaign(study), study.runs[0].key)["specimen_height_mm"] == 10
    assert calibration.settings(Campaign(study), "")["heights_mm"] == {"S1": 12, "S2": None, "N": 10}


def test_kappa_of_a_design_hangs_on_its_own_runs_and_specimens(tmp_path: Path) -> None:
    new = '[profile]\nnew_specimen = "N"\nnew_stiffness_n_per_mm = 4\nnew_height_mm = 10\n[runs]'
    study = thin(tmp_path, STUDY.replace("[runs]", new))
    pressed = {"modular": ("S1", "S2", "N"), "fixed": ("S1", "N"), "rigid": ("S1", "S2")}
    entries = (
        RunEntry(one, 0.0, condition, (tmp_path / one,)) for condition, names in pressed.items() for one in names
    )
    whole = Campaign(replace(study, runs=tuple(entries)))
    assert items(whole, "kappa") == ("0_modular", "0_fixed")  # nobody asks for a new specimen that was not pressed
    assert kappa.STAGE.takes is not None
    assert kappa.STAGE.takes(whole, "0_fixed") == [("runs", "S1_0_fixed"), ("runs", "N_0_fixed")]
    used = kappa.settings(whole, "0_fixed")
    assert used["specimens"] == {"S1": 5.3}  # the true stiffness of the new one enters its error alone
    assert used["heights_mm"] == {"S1": 12, "N": 10}
    assert value_of(used["domes"]) == str(tmp_path / "mine")
    with pytest.raises(DataError, match=r"0_fixed: expected one scored run or more, but found none\. See why its runs"):
        kappa.run(Given("0_fixed", used))


def test_a_folder_without_tables_is_told_before_anything_is_scored(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"mine: expected tables of domes, .*, but found none"):
        campaign(thin(tmp_path))


def test_an_emulated_run_is_known_by_its_tables_and_not_by_where_they_lie(tmp_path: Path) -> None:
    study, table = thin(tmp_path), tmp_path / "mine" / "mine_k5.3_h10_stick.npz"
    table.touch()
    (tmp_path / "rig.toml").write_text(small_rig("high-stiffness = [0]\n") + 'domes = "mine"\n')
    pressed = Campaign(study, load_rig(tmp_path / "rig.toml"))
    item = next(iter(pressed.mountings))
    of_world = emulation.STAGE.settings(pressed, item)["emulated"]
    assert value_of(of_world).domes == str(tmp_path / "mine")
    assert of_world.key.domes is None
    assert emulation.STAGE.files(pressed, item) == {"emulated domes": [table]}
