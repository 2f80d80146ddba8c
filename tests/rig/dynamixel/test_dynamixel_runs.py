"""Whole runs with an emulated Dynamixel in virtual time, from the rig file to what is read back of their folders."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from casr.frame_files import open_frames
from casr.specimens import SPECIMENS
from emg2vsa import rig
from emg2vsa.errors import DataError, ScheduleError, SettingError
from emg2vsa.lab.pressed import Pressed
from emg2vsa.rig_file.plans import plans_of
from emg2vsa.run_folders.find import find_runs
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.schedule_files import read_csv, read_json, write_schedule
from tests.rig.dynamixel.conftest import FULL, GEAR, Files, make_schedules

HEAD = (
    "time_s,repetition,phase,force_time_s,force_n,filtered_n,position_deg,preset,motor_1_deg,motor_2_deg,shaft_deg,"
    "current_1_a,current_2_a,"
)


@pytest.mark.parametrize("specimen", ["S1", "S3", "S5"])
def test_a_run_is_whole_and_read_back(specimen: str, rig_file: Files, tmp_path: Path) -> None:
    run = rig.press(rig.load(rig_file()), specimen, 0, "modular", virtual=True, folder=tmp_path / "runs")
    assert (run.ended.how, run.ended.cause, run.ended.repetitions_done, run.ended.notes) == ("completed", "", 2, ())
    assert run.left_safe
    assert run.ended.peak_force_n is not None
    assert 7.0 < run.ended.peak_force_n < 8.2
    _check_files(run, specimen)
    _check_log(run, specimen)
    (found,) = find_runs(tmp_path / "runs", SPECIMENS)
    assert (found.specimen, found.angle_deg, found.condition) == (specimen, 0.0, "modular")
    presses = list(read_presses(found.folders))
    assert [press.repetition for press in presses] == [1, 2]


def _check_files(run: Pressed, specimen: str) -> None:
    with (run.folder / "presses.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert [row["verdict"] for row in rows] == ["ok", "ok"]
    assert all(7.0 < float(row["peak_force_n"]) < 8.2 for row in rows)
    assert (run.folder / "log.csv").read_text().startswith(HEAD)
    told = json.loads((run.folder / "plan.json").read_text())
    assert told["plan"]["specimen"] == specimen
    assert (told["rig"]["gear_mm_per_degree"], told["rig"]["full_preset"]) == (GEAR, FULL)
    assert all(len(open_frames(press)) > 10 for press in sorted(run.folder.glob("press-*")))


def _check_log(run: Pressed, specimen: str) -> None:
    log = run.log
    load = log[log["phase"] == "load"]
    # a stiffer specimen is pressed less deep; the probe begins 2 mm above it, or more
    assert load["depth_mm"].to_numpy() == pytest.approx(GEAR * load["shaft_deg"].to_numpy())
    assert {"S1": 4, "S3": 5, "S5": 8}[specimen] > load["depth_mm"].max() - load["depth_mm"].min() > 0.5
    assert log["depth_mm"].dropna().iloc[-1] == pytest.approx(0, abs=0.3)
    # the joint bears the force that is felt, but for friction and the motion of the shaft
    torque_nm = load["preset"] * np.radians(load["position_deg"] - load["shaft_deg"])
    lever_m = np.degrees(GEAR) / 1000
    assert np.polyfit(load["force_n"], torque_nm / lever_m, 1)[0] == pytest.approx(1.1, abs=0.2)
    assert load["current_1_a"].max() < 0.4
    assert log["preset"].dropna().max() == pytest.approx(0.8 * FULL, abs=1e-6)
    assert log["motor_2_deg"].isna().all()


def test_the_same_inputs_give_the_same_bytes(rig_file: Files, tmp_path: Path) -> None:
    file, found = rig.load(rig_file()), []
    for name in ("one", "two"):
        run = rig.press(file, "S3", presses=1, virtual=True, folder=tmp_path / name)
        files = (path for path in sorted(run.folder.rglob("*")) if path.is_file() and path.name != "ended.json")
        found.append({path.name: path.read_bytes() for path in files if path.name != "plan.json"})
    assert found[0] == found[1]


def test_a_schedule_file_is_written_and_read(tmp_path: Path) -> None:
    (written,) = (each for each in make_schedules() if each.specimen == "S3")
    paths = write_schedule(tmp_path, written)
    for path, read in zip(paths, (read_csv, read_json), strict=True):
        assert "preset_nm_per_rad" in path.read_text()
        assert "full_stiffness_nm_per_rad" in path.read_text()
        found = read(path)
        assert found.preset == pytest.approx(written.preset, rel=1e-12)
        assert found.stiffness_nm_per_rad == pytest.approx(written.preset * FULL, rel=1e-12)
        assert found.limits == written.limits


def test_a_dry_run_tells_what_would_be_sent(rig_file: Files) -> None:
    told = rig.dry_run(rig.load(rig_file()))
    assert [run.specimen for run in told] == ["S1", "S3", "S5"] or len(told) == 3
    for trial in told.values():
        assert not isinstance(trial, str), trial


def test_a_schedule_of_another_joint_is_refused(rig_file: Files) -> None:
    file = rig.load(rig_file(schedules=make_schedules("qbmove-maker-pro")))
    with pytest.raises(ScheduleError, match=r"actuator: expected .*dynamixel.*but found .*qbmove-maker-pro"):
        rig.press(file, "S1", virtual=True)


def test_a_schedule_of_another_full_stiffness_is_refused(rig_file: Files) -> None:
    file = rig.load(rig_file(schedules=make_schedules(full=2 * FULL)))
    with pytest.raises(ScheduleError, match=r"expected .* but found .*"):
        rig.press(file, "S1", virtual=True)


def test_a_stiffness_that_nobody_has_measured_runs_no_schedule(rig_file: Files, tmp_path: Path) -> None:
    file = rig.load(rig_file((f"full_stiffness_nm_per_rad = {FULL}\n", "")))
    told = r"actuator.full_stiffness_nm_per_rad: expected .*, but found .*rig commission"
    with pytest.raises(SettingError, match=told):
        rig.press(file, "S1", virtual=True, folder=tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


def test_a_run_that_is_done_is_not_done_again(rig_file: Files, tmp_path: Path) -> None:
    file = rig.load(rig_file(("repetitions = 2", "repetitions = 1")))
    rig.press(file, "S5", virtual=True, folder=tmp_path / "runs")
    with pytest.raises(DataError, match="expected a run that is still to do"):
        rig.press(file, "S5", virtual=True, folder=tmp_path / "runs")


def test_a_plan_keeps_the_presets_of_its_schedule(rig_file: Files) -> None:
    file = rig.load(rig_file())
    plans = plans_of(file, file.experiment.all_runs())
    presets = [plan.presets(FULL) for plan in plans]
    for plan, own in zip(plans, presets, strict=True):
        assert plan.schedule is not None
        assert own == pytest.approx(plan.schedule.preset)
    assert (min(map(min, presets)), max(map(max, presets))) == pytest.approx((0.2, 0.8))
