"""A run that forgives a busy machine: ``python -m benchmarks.rig.patient FOLDER``, the devices as JSON on its input.

For what is not about time, such as a run that is killed: the guards are set wide.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from benchmarks.rig.plans import modular_plan
from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.opencv_camera.driver import OpenCvCamera
from emg2vsa.devices.protocols import Devices
from emg2vsa.devices.qbmove import BAUD
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.registry import Around, kinds, known
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.rig_settings import DeviceSettings, GuardSettings, RigSettings

LONG_S = 2.0
REPLY_S, WATCHDOG_S = 0.5, 5.0
"""Three attempts of a question are over before the watchdog is."""
F_MAX_N, MOST_N = 5.0, 100.0


def patient_run(settings: DeviceSettings, folder: Path) -> None:
    """One light press, recorded in ``folder``."""
    clock = WallClock()
    line = SerialLine(settings.actuator.port or "", BAUD)
    force = known("force", settings.force).opened(settings.force, Around(clock, LONG_S))  # fmt: skip
    assert settings.camera is not None
    camera = OpenCvCamera(settings.camera.source, clock)
    # a turn that comes late goes the further, and so finds a larger force
    guards = GuardSettings(force_n=MOST_N, force_rate_n_per_s=1e6, stale_s=LONG_S, camera_s=LONG_S, late_s=LONG_S)
    try:
        force.start()
        camera.start()
        devices = Devices(Qbmove(line, 1, clock=clock, watchdog_s=WATCHDOG_S, reply_s=REPLY_S), force, camera)
        plan = modular_plan(1, f_max_n=F_MAX_N, pause_s=0.0)
        execute(plan, RigSettings(guards=guards), devices, folder, clock, started=datetime.now(UTC), background=True)
    finally:
        camera.close()
        force.close()
        line.close()


def as_json(settings: DeviceSettings) -> str:
    """As `main` reads it."""
    return json.dumps(asdict(settings))


def main() -> None:
    """Run once."""
    devices = {role: table for role, table in json.load(sys.stdin).items() if table}
    settings = DeviceSettings(**{role: kinds(role)[table["kind"]].settings(**table) for role, table in devices.items()})
    patient_run(settings, Path(sys.argv[1]))


if __name__ == "__main__":
    main()
