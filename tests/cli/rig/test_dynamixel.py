"""A run with a Dynamixel in several sittings, and devices that say what they can."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.lab.device_states import info
from emg2vsa.rig_file import load_rig
from emg2vsa.schedule_files import write_schedule
from emg2vsa.schedules.schedule import Limits
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings
from tests.cli.rig.conftest import make_schedules

Rig = Callable[..., tuple[int, str, str]]
ACTUATOR = """[actuator]
kind = "dynamixel"
d_gain = 1500
goal_current_a = 0.4
full_stiffness_nm_per_rad = 19.74
"""
ONE = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "modular")


@pytest.fixture
def path(rig_file: Callable[..., Path], tmp_path: Path) -> Path:
    path = rig_file(('[actuator]\nport = "/dev/no-such-port"\nwatchdog_s = 5\nreply_s = 2\n', ACTUATOR))
    # at 8 mm/s the gear's friction looks like a force that the sensor does not feel
    text = path.read_text().replace("ramp_mm_per_s = 8", "ramp_mm_per_s = 5")
    path.write_text("[rig]\ngear_mm_per_degree = 0.8\n" + text)
    full = 19.74
    limits = Limits((20, 80), full, "dynamixel", "preset")
    for made in make_schedules():
        ramp = replace(
            made.ramp, gear_mm_per_degree=0.8, speed_mm_per_s=5.0, speed_deg_per_s=6.25,
            duration_s=made.ramp.travel_mm / 5.0,
        )  # fmt: skip
        preset = made.stiffness_percent / 100
        write_schedule(
            tmp_path / "schedules",
            replace(made, limits=limits, preset=preset, stiffness_nm_per_rad=preset * full, ramp=ramp),
        )
    return path


def test_a_second_sitting_makes_the_presses_that_are_missing(path: Path, rig: Rig) -> None:
    assert rig("run", path, *ONE, "--repetitions", 1)[0] == 0
    assert rig("run", path, *ONE)[0] == 0
    ended = json.loads((path.parent / "runs-virtual" / "S3_0_modular-2" / "ended.json").read_text())
    assert (ended["how"], ended["repetitions_done"]) == ("completed", 1)


def test_presses_of_another_schedule_or_actuator_are_not_mixed(path: Path, rig: Rig) -> None:
    assert rig("run", path, *ONE, "--repetitions", 1)[0] == 0
    plan = path.parent / "runs-virtual" / "S3_0_modular" / "plan.json"
    whole = plan.read_text()
    for change in ("actuator", "preset_nm_per_rad"):
        document = json.loads(whole)
        schedule = document["plan"]["schedule"]
        if change == "actuator":
            schedule["limits"]["actuator"] = "qbmove-advanced"
        else:
            schedule["steps"][0][change] += 1.0
        plan.write_text(json.dumps(document))
        status, _, err = rig("run", path, *ONE)
        assert (status, f"plan.json: expected {change} of the schedule = " in err) == (2, True)


def test_the_share_of_a_stiffness_that_nobody_has_measured_is_not_narrowed(path: Path) -> None:
    """The default of [rig] full_preset is a qbmove's, in degrees."""
    path.write_text(path.read_text().replace("full_stiffness_nm_per_rad = 19.74\n", ""))
    file = load_rig(path)
    bench = EmulatedRig(EmulatedSettings(), "S3", 0.0, False, WallClock(), rig=file.rig, actuator=file.devices.actuator)
    with EmulatedServers(bench) as servers:
        path.write_text(path.read_text().replace('kind = "dynamixel"', f'kind = "dynamixel"\nport = "{servers.port}"'))
        (actuator, *_) = info(load_rig(path))
    assert actuator.usable
    assert "full stiffness not commissioned: no schedules" in actuator.lines
    assert "a run may use: positions -131.836 to 131.836 degrees, 20 to 80 % of full stiffness" in actuator.lines
