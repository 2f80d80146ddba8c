"""A rig file with its schedules, an emulated rig behind real ports, and the command line."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.devices.clock import WallClock
from emg2vsa.profiles import Profile, Profiles
from emg2vsa.schedule_files import write_schedule
from emg2vsa.schedules import Schedule
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import ScheduleSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings

# a machine with other work must not trip the guards; held up for a second, the probe goes 8 mm on
RIG = """\
[rig.guards]
stale_s = 0.1
late_s = 0.1
camera_s = 5
force_n = 50
force_rate_n_per_s = 3000
following_ticks = 600
following_s = 0.2

[actuator]
port = "{port}"
watchdog_s = 5
reply_s = 2

[motor]
port = "{motor_port}"
watchdog_s = 5
reply_s = 2

[force]
kind = "net-ft"
host = "127.0.0.1"
rdt_port = {rdt_port}
http_port = {http_port}

[camera]
source = "{camera}"

[experiment]
specimens = ["S1", "S3"]
angles_deg = {{ high-stiffness = [0], modular = [0, 30] }}
repetitions = 2
f_max_n = 5
ramp_mm_per_s = 8
pause_s = 0.1
schedules = "schedules"

[emulated]
gap_mm = 2
"""
NOWHERE = {
    "port": "/dev/no-such-port", "motor_port": "/dev/no-such-motor", "rdt_port": 1, "http_port": 1,
    "camera": "/no/such/camera",
}  # fmt: skip


def make_schedules() -> tuple[Schedule, ...]:
    force = np.linspace(0.5, 7, 100)
    profiles = tuple(
        Profile(name, 7.63, a, b, force, a + b * np.log(force), "measured", 10, np.full(100, np.nan))
        for name, a, b in (("S1", 42e-6, 20e-6), ("S3", 28e-6, 13e-6))
    )
    whole = Profiles(
        profiles=profiles, new=None, weight_alpha=math.nan, bracket=None, new_measured=None, new_error=None,
        leave_one_out=(), participant="", unit="V", notes=(),
    )  # fmt: skip
    settings = ScheduleSettings(conditions=("modular",), probe_speed_mm_per_s=8.0, actuator="qbmove-maker-pro")
    return build_schedules(whole, settings, {"study": "palpation"})


@pytest.fixture
def rig_file(tmp_path: Path) -> Callable[..., Path]:
    """The rig file, its devices nowhere unless said; ``change`` is one piece of its text and what replaces it."""

    def write(change: tuple[str, str] = ("", ""), **where: Any) -> Path:
        for schedule in make_schedules():
            write_schedule(tmp_path / "schedules", schedule)
        path = tmp_path / "rig.toml"
        path.write_text(RIG.format(**NOWHERE | where).replace(*change, 1))
        return path

    return write


@pytest.fixture
def served(rig_file: Callable[..., Path]) -> Iterator[SimpleNamespace]:
    """S1 under the qbmove of an emulated rig; ``path`` of the rig file that leads to it, and ``bench``."""
    bench = EmulatedRig(EmulatedSettings(gap_mm=2.0), "S1", 0.0, False, WallClock())
    with EmulatedServers(bench) as servers:
        force = servers.force
        path = rig_file(
            port=servers.port, rdt_port=force.rdt_port, http_port=force.http_port, camera=servers.camera_url
        )
        yield SimpleNamespace(path=path, bench=bench, servers=servers)


@pytest.fixture
def served_rigid(rig_file: Callable[..., Path]) -> Iterator[SimpleNamespace]:
    """S3 under the rigid motor of an emulated rig whose bodies are elastic; as ``served``."""
    emulated = EmulatedSettings(gap_mm=2.0, world="elastic")
    bench = EmulatedRig(emulated, "S3", 0.0, True, WallClock())
    with EmulatedServers(bench) as servers:
        force = servers.force
        path = rig_file(
            ("gap_mm = 2", 'gap_mm = 2\nworld = "elastic"\nbehind_ports = true'),
            port=servers.idle_port, motor_port=servers.port, rdt_port=force.rdt_port, http_port=force.http_port,
            camera=servers.camera_url,
        )  # fmt: skip
        # slow enough for twenty frames, and a lost camera is lost while it presses
        path.write_text(path.read_text().replace("ramp_mm_per_s = 8", "ramp_mm_per_s = 2").replace("camera_s = 5", ""))
        yield SimpleNamespace(path=path, bench=bench, servers=servers)


@pytest.fixture
def rig(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    """Run ``emg2vsa rig ...``: exit status, output, error stream."""

    def run(*arguments: object) -> tuple[int, str, str]:
        status = main(["rig", *map(str, arguments)])
        said = capsys.readouterr()
        return status, said.out, said.err

    return run


MOTORS_OFF = bytes.fromhex("3a3a 01 03 81 00 81")


def motors(bench: Any) -> bytes:
    """What a qbmove answers to the question whether its motors are on."""
    return bytes(bench.answer(bytes.fromhex("3a3a 01 02 81 81")))


def ended_of(folder: Path) -> dict[str, Any]:
    """How a run ended."""
    found: dict[str, Any] = json.loads((folder / "ended.json").read_text())
    return found
