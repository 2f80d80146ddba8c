"""``emg2vsa rig run`` against an emulated rig behind real ports."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks.rig.fault_case import read_log
from casr.frame_files import open_frames
from tests.cli.rig.conftest import MOTORS_OFF, ended_of, motors

Rig = Callable[..., tuple[int, str, str]]
ONE = ("--specimen", "S1", "--angle", "0", "--condition", "modular")


@pytest.mark.realtime
def test_a_run_after_one_that_was_ended_is_completed_told_and_recorded(
    rig: Rig, served: SimpleNamespace, tmp_path: Path
) -> None:
    served.bench.box.faults.saturated = True
    status, out, _ = rig("run", served.path, *ONE)
    assert status == 1
    assert "\nguard: untrusted force in home (" in out
    assert "0 of 2 presses" in out
    assert ended_of(tmp_path / "runs" / "S1_0_modular")["cause"] == "untrusted force"

    served.bench.box.faults.saturated = False
    status, out, err = rig("run", served.path, *ONE)
    folder = tmp_path / "runs" / "S1_0_modular-2"
    assert status == 0, out + err
    assert "guard: rig.guards.force_n = 50 protects less than 10, the default" in out.splitlines()
    lines = [line for line in out.splitlines() if not line.startswith("guard: ")]
    assert lines[:4] == [
        f"folder: {folder}",
        "run: S1, 0 degrees, modular, 2 presses",
        "device: QBMMP v6.1.0, positions -131.8 to 131.8 degrees, full stiffness 7.78 N m/rad",
        "force: mean of 5 samples at 200 Hz: -3 dB at 18 Hz, delay 10 ms",
    ]
    unproven = "watchdog: the watchdog of this device (QBMMP v6.1.0) is not proven: emg2vsa rig prove-watchdog"
    assert lines[4] == unproven
    end = next(number for number, line in enumerate(lines) if line.startswith("completed: 2 of 2 presses, "))
    assert all(line.startswith("guard: rig.guards.") for line in lines[5:end])
    assert lines[end + 1] == "left: probe retracted, motors off"
    assert lines[-2].split() == ["control", "loop", "turns", "median", "99", "%", "99.9", "%", "largest", "overruns"]
    assert [line.partition(" at ")[0] for line in err.splitlines()][:1] == ["press 1 of 2 done"]
    assert ended_of(folder)["how"] == "completed"
    assert motors(served.bench) == MOTORS_OFF
    assert max(row.force_n or 0 for row in read_log(folder / "log.csv")) > 4.5
    assert [len(open_frames(press)) > 3 for press in sorted(folder.glob("press-*"))] == [True, True]

    status, _, err = rig("run", served.path, *ONE)
    assert status == 2
    first = tmp_path / "runs" / "S1_0_modular"
    assert f"{first}: expected a run that is still to do, but found one with all its presses." in err


def test_a_device_that_is_absent_is_told_and_nothing_is_recorded(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path
) -> None:
    status, out, err = rig("run", rig_file(), *ONE)
    assert (status, out) == (2, "")
    assert err.startswith("emg2vsa: /dev/no-such-port: expected a serial port, but found ")
    assert not (tmp_path / "runs").exists()


def test_a_schedule_beyond_the_device_moves_nothing(rig: Rig, served: SimpleNamespace, tmp_path: Path) -> None:
    served.bench.firmware._shadow.max_stiffness = 2 * 2000
    status, _, err = rig("run", served.path, *ONE)
    assert status == 2
    assert (
        "schedule of S1, modular, stiffness preset: expected 30 to 80 % of the device's maximum, but found 120 %" in err
    )
    assert not (tmp_path / "runs").exists()


def test_more_than_one_run_is_listed(rig: Rig, rig_file: Callable[..., Path], tmp_path: Path) -> None:
    path = rig_file()
    before = (("S1_0_modular", "completed", 2), ("S1_0_high-stiffness", "completed", 1), ("S3_0_modular", "guard", 0))
    for name, how, done in before:
        (tmp_path / "runs" / name).mkdir(parents=True)
        ended = json.dumps({"how": how, "repetitions_done": done})
        (tmp_path / "runs" / name / "ended.json").write_text(ended)
    status, out, err = rig("run", path, "--angle", 0)
    assert status == 0
    assert out.splitlines() == [
        "--specimen S1 --angle 0 --condition high-stiffness   # completed before, 1 of 2 presses",
        "--specimen S3 --angle 0 --condition high-stiffness",
        "--specimen S3 --angle 0 --condition modular   # guard before, 0 of 2 presses",
    ]
    assert "4 runs, 3 still to do. Name one as listed; --all leads through them; --virtual emulates them." in err
    status, out, _ = rig("run", path, "--angle", 0, "--json")
    assert json.loads(out)["to_do"][0] == {
        "specimen": "S1", "angle_deg": 0, "condition": "high-stiffness", "mounting": 1, "presses_left": 1,
    }  # fmt: skip


def test_runs_of_the_emulated_rig_are_told_and_do_not_count(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path
) -> None:
    path, runs = rig_file(), tmp_path / "runs"
    for name in ("S1_0_modular", "S3_0_modular"):
        (runs / name).mkdir(parents=True)
        for file in ("emulated.json", "plan.json"):
            (runs / name / file).write_text("{}")
        (runs / name / "ended.json").write_text(json.dumps({"how": "completed", "repetitions_done": 2}))
    status, out, err = rig("run", path, "--angle", 0, "--condition", "modular")
    assert status == 0
    assert len(out.splitlines()) == 2
    assert f"2 folders in {runs} were made by the emulated rig of version 0.1.0 and do not count as done; " in err
    assert "emg2vsa tools clean STUDY --move-virtual moves them away." in err

    for name in ("S1_0_modular", "S3_0_modular"):
        (runs / name / "emulated.json").unlink()
    status, out, err = rig("run", path, "--angle", 0, "--condition", "modular")
    assert (status, out) == (0, "")
    assert "2 runs, 0 still to do. To repeat one, move its folder away, or choose another" in err
    assert "0.1.0" not in err
