"""What a rig file says, checked and with its paths resolved."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from emg2vsa.rig.device_settings import DeviceSettings
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import RigSettings


@dataclass(frozen=True)
class RigFile:
    """One rig and its experiment."""

    path: Path
    rig: RigSettings
    devices: DeviceSettings
    experiment: ExperimentSettings
    schedules: Path
    "Folder of the schedules."
    runs: Path
    "Folder of the runs."
    emulated: EmulatedSettings | None
