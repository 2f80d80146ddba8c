"""A program killed in the midst of a press, against the emulated rig in real time."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from benchmarks.rig.fault_case import read_log
from benchmarks.rig.patient import as_json
from benchmarks.rig.plans import SPECIMEN
from casr.frame_files import open_frames
from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.qbmove import QbmoveSettings
from emg2vsa.rig.rig_settings import DeviceSettings
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.settings import EmulatedSettings

PATIENCE_S = 60.0
ROOT = Path(__file__).parents[3]


@pytest.fixture
def servers() -> Iterator[EmulatedServers]:
    bench = EmulatedRig(EmulatedSettings(), SPECIMEN, 0.0, rigid=False, clock=WallClock())
    with EmulatedServers(bench) as serving:
        yield serving


@pytest.mark.slow
@pytest.mark.realtime
def test_kill_9_leaves_a_readable_run_and_motors_off(servers: EmulatedServers, tmp_path: Path) -> None:
    force = servers.force
    settings = DeviceSettings(
        actuator=QbmoveSettings(port=servers.port),
        force=NetFtSettings(host=force.host, rdt_port=force.rdt_port, http_port=force.http_port),
        camera=OpenCvSettings(source=servers.camera_url),
    )
    log = tmp_path / "run" / "log.csv"
    program = _start(settings, log.parent)
    _wait(lambda: program.poll() is not None or (log.exists() and ",load," in log.read_text()))
    assert servers.bench.firmware.state.on
    program.kill()
    program.wait()
    _wait(lambda: not servers.bench.firmware.state.on)  # nobody but the watchdog is left to switch them off

    rows = read_log(log)
    assert any(row.phase == "load" for row in rows)
    assert _ended(log.parent)["how"] == "killed"
    assert len(open_frames(log.parent / "press-001")) > max(row.frame_index for row in rows) > 0

    _start(settings, tmp_path / "next").wait(PATIENCE_S)
    again = _ended(tmp_path / "next")
    assert [again[key] for key in ("how", "why", "repetitions_done", "retracted", "deactivated")] == [
        "completed", "", 1, True, True,
    ]  # fmt: skip


def _start(settings: DeviceSettings, folder: Path) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "benchmarks.rig.patient", str(folder)]
    program = subprocess.Popen(command, stdin=subprocess.PIPE, text=True, cwd=ROOT)
    assert program.stdin is not None
    program.stdin.write(as_json(settings))
    program.stdin.close()
    return program


def _ended(folder: Path) -> dict[str, Any]:
    told: dict[str, Any] = json.loads((folder / "ended.json").read_text())
    return told


def _wait(until: Callable[[], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not until() and time.monotonic() < end_s:
        time.sleep(0.02)
    assert until()
