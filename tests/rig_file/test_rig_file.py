"""From a rig file to a rig: defaults, paths, and the rig that comes with the program."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import pytest

from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import SettingError
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.rig_file import RigFile, load_rig
from emg2vsa.rig_file.older_keys import spelled
from emg2vsa.rig_file.plans import chosen_runs

ROOT = Path(__file__).resolve().parents[2]
Load = Callable[[str], RigFile]


def test_what_is_left_out_has_its_default(small: str, load: Load) -> None:
    file = load(small)
    assert file.rig == RigSettings()
    assert file.experiment == ExperimentSettings(specimens=("S1", "S3"))
    assert type(file.experiment) is ExperimentSettings
    assert file.devices.force == NetFtSettings(host="192.168.1.1")
    assert file.devices.camera is None
    assert load(small.replace("[emulated]", "")).emulated is None


def test_the_emulated_springs_are_those_of_the_actuator(small: str, load: Load) -> None:
    advanced = small.replace("[actuator]\n", '[actuator]\nmodel = "advanced"\n')
    assert advanced != small
    for text, springs in ((small, "qbmove-maker-pro"), (advanced, "qbmove-advanced")):
        file = load(text)
        assert file.emulated is not None
        assert file.emulated.springs == file.devices.actuator.joint == springs


def test_what_is_said_is_kept(small: str, load: Load) -> None:
    file = load(
        f"""{small}
[rig]
push_sign = -1
push_axis = [0, -1, 0]
guards = {{ force_n = 9, late_s = 0.1 }}
[camera]
source = "http://camera/frames"
rate_hz = 30
"""
    )
    assert (file.rig.push_sign, file.rig.push_axis) == (-1, (0.0, -1.0, 0.0))
    assert file.rig.guards == GuardSettings(force_n=9.0, late_s=0.1)
    assert file.devices.camera is not None
    assert (file.devices.camera.source, file.devices.camera.rate_hz) == ("http://camera/frames", 30.0)


OLDER = """
[rig]
home_ticks = -300
position_ticks = [-12000, 11000]
max_preset_ticks = 2800
guards = { following_ticks = 120, following_ticks_per_s = 15000, current_ma = 1250 }
"""
TODAY = f"""
[rig]
home_deg = {-300 * DEG_PER_TICK}
position_deg = [{-12000 * DEG_PER_TICK}, {11000 * DEG_PER_TICK}]
full_preset = {2800 * DEG_PER_TICK}
guards = {{ following_deg = {120 * DEG_PER_TICK}, following_deg_per_s = {15000 * DEG_PER_TICK}, current_a = 1.25 }}
"""


def test_files_in_ticks_are_read_as_those_in_degrees(small: str, load: Load) -> None:
    older = load(small + OLDER)
    assert older == load(small + TODAY)
    assert (older.rig.home_deg, older.rig.full_preset) == (-3.2958984375, 30.76171875)
    mixed = load(small + OLDER.replace("home_ticks = -300", f"home_deg = {-300 * DEG_PER_TICK}"))
    assert mixed == older


def test_the_defaults_are_those_of_before(small: str, load: Load) -> None:
    before = """
[rig]
home_ticks = 0
position_ticks = [-12000, 12000]
max_preset_ticks = 3000
[rig.guards]
following_ticks = 100
following_ticks_per_s = 12000
current_ma = 1500
"""
    assert load(small + before) == load(small)


def test_a_value_goes_back_into_the_file_in_its_own_unit(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    values = {
        ("rig", "home_deg"): -3.3, ("rig", "push_sign"): -1, ("rig", "position_deg"): (-131.8359375, 11.0),
        ("rig", "guards", "current_a"): 1.2,
    }  # fmt: skip
    path.write_text("[rig]\nhome_deg = 1.0\n")
    assert spelled(path, values) == values
    path.write_text("[rig]\nhome_ticks = 3\nposition_ticks = [-1, 1]\nguards = { current_ma = 1500 }\n")
    assert spelled(path, values) == {
        ("rig", "home_ticks"): -300, ("rig", "push_sign"): -1, ("rig", "position_ticks"): (-12000, 1001),
        ("rig", "guards", "current_ma"): 1200.0,
    }  # fmt: skip


def test_paths_start_at_the_folder_of_the_rig_file(small: str, load: Load, tmp_path: Path) -> None:
    folder = tmp_path / "studies" / "small"
    file = load(small)
    assert file.path == folder / "rig.toml"
    assert file.schedules == tmp_path / "reports" / "small" / "schedules"
    assert file.runs == folder / "runs"
    table = small.replace("[experiment]", f'[experiment]\nschedules = "../s"\nruns = "{tmp_path}/r"')
    daq = 'kind = "ni-daq"\nchannels = "Dev1/ai0:5"\ncal_file = "../FT1.cal"\nbias = true\n'
    file = load(table.replace('kind = "net-ft"\nhost = "192.168.1.1"\n', daq))
    assert file.schedules == tmp_path / "studies" / "s"
    assert file.runs == tmp_path / "r"
    assert file.devices.force.cal_file == str(tmp_path / "studies" / "FT1.cal")


def test_outside_studies_the_schedules_lie_beside_the_rig_file(small: str, tmp_path: Path) -> None:
    path = tmp_path / "lab" / "rig.toml"
    path.parent.mkdir()
    path.write_text(small, encoding="utf-8")
    assert load_rig(path).schedules == tmp_path / "lab" / "reports" / "lab" / "schedules"


def test_the_rig_that_comes_with_the_program_says_the_defaults() -> None:
    file = load_rig(ROOT / "studies" / "palpation" / "rig.toml")
    assert file.rig == RigSettings()
    usual = ExperimentSettings(specimens=("S1", "S3", "S5", "S_new"))
    assert file.experiment == replace(usual, mountings=3, repetitions=3)
    assert len(file.experiment.all_runs()) == 3 * 4 * (3 + 3 + 1 + 1 + 1)
    assert file.schedules == ROOT / "reports" / "palpation" / "schedules"
    assert file.emulated is not None
    assert set(file.experiment.specimens) <= set(file.emulated.stiffness_n_per_mm)


def test_every_mounting_is_a_run_of_its_own(load: Load, small: str) -> None:
    text = small.replace('["S1", "S3"]', '["S1", "S3"]\nangles_deg = { modular = [0] }\nmountings = 2')
    runs = load(text).experiment.all_runs()
    names = ["S1_0_modular", "S3_0_modular", "S1_0_modular_mounting-2", "S3_0_modular_mounting-2"]
    assert [run.name for run in runs] == names
    assert [run.mounting for run in chosen_runs(load(text), ["S3"], mountings=[2])] == [2]
    with pytest.raises(SettingError, match="mounting: expected 1, 2, but found 3"):
        chosen_runs(load(text), mountings=[3])


def test_it_names_no_address() -> None:
    """No command sends a byte to a port or host that its user did not write."""
    devices = load_rig(ROOT / "studies" / "palpation" / "rig.toml").devices
    assert devices.motor is not None
    assert (devices.actuator.port, devices.motor.port, devices.force.host) == (None, None, None)


def test_it_shows_every_guard() -> None:
    text = (ROOT / "studies" / "palpation" / "rig.toml").read_text(encoding="utf-8")
    assert [each.name for each in fields(GuardSettings) if f"\n{each.name} = " not in text] == []


def test_reading_a_rig_file_loads_no_heavy_library() -> None:
    code = (
        "import sys; from emg2vsa.rig_file import load_rig; load_rig(sys.argv[1]);"
        "heavy = {'numpy', 'scipy', 'cv2', 'pandas', 'serial', 'emg2vsa.worlds.tactile'};"
        "heavy |= {'emg2vsa.devices.qbmove.driver'};"
        "print(*heavy & {*sys.modules})"
    )
    command = [sys.executable, "-c", code, str(ROOT / "studies" / "palpation" / "rig.toml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "\n"


def test_emulated_runs_go_to_folders_beside_the_others(small: str, load: Load, tmp_path: Path) -> None:
    file = load(small.replace('["S1", "S3"]', '["S1", "S3"]\nruns = "../all/measured"'))
    assert file.virtual_runs.resolve() == tmp_path / "studies" / "all" / "measured-virtual"
    assert file.emulated_runs.resolve() == tmp_path / "studies" / "all" / "measured-emulated"
