"""The tables of a rig file, as dataclasses; most are the settings of the drivers and of the executor themselves.

`RigFile` is what they say, checked and with its paths resolved.
"""

from __future__ import annotations

from dataclasses import field
from pathlib import Path
from typing import Annotated

from emg2vsa.devices.device_settings import ActuatorSettings, CameraSettings, ForceSettings, Text
from emg2vsa.devices.qbmove import MotorSettings
from emg2vsa.errors import ScheduleError
from emg2vsa.rig.experiment import ExperimentSettings, PlateSettings
from emg2vsa.rig.rig_settings import DeviceSettings, RigSettings
from emg2vsa.settings import Tagged
from emg2vsa.settings_class import settings_class
from emg2vsa.worlds.bench.settings import EmulatedSettings


@settings_class
class ExperimentTable(ExperimentSettings):
    """What is pressed and how, and where its files are. Paths are relative to the folder of the rig file."""

    schedules: Text | None = None
    "Folder of the schedules; omitted: schedules/ in the report of a study that is named as the rig file's folder."
    runs: Text = "runs"
    "Folder in which each run gets a folder of its own."


@settings_class
class RigTables:
    """A whole rig file."""

    rig: RigSettings = field(default_factory=RigSettings)
    "Mechanics, limits and control loop."
    actuator: Annotated[ActuatorSettings, Tagged("actuator")]
    "The actuator."
    motor: MotorSettings | None = None
    "The rigid motor that the condition high-stiffness needs."
    force: Annotated[ForceSettings, Tagged("force")]
    "The force sensor."
    camera: Annotated[CameraSettings, Tagged("camera")] | None = None
    "The tactile camera; without it no frames are kept."
    experiment: ExperimentTable
    "What is pressed, and how."
    plate: PlateSettings = field(default_factory=PlateSettings)
    "Indentation of the specimens by a flat plate (emg2vsa rig run --plate)."
    emulated: EmulatedSettings | None = None
    "The bench that emg2vsa rig emulate and emg2vsa rig run --virtual put in place of a real one."


@settings_class
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
    plate: PlateSettings = field(default_factory=PlateSettings)

    def check_actuator(self, named: str, where: str, do: str) -> None:
        """ScheduleError where schedules were made for another actuator: the same presets are another stiffness there
        (decision 13). The emulated springs are those of [actuator], so this holds for every way of pressing.

        named : actuator of the schedules. where : they name it. do : what puts it right there.
        """
        own = self.devices.actuator.joint
        if named != own:
            wanted = f"{own}, the actuator of {self.path}"
            raise ScheduleError(where, wanted=wanted, found=named, do=f"{do}, or correct [actuator].")

    @property
    def virtual_runs(self) -> Path:
        """Folder of the runs of emg2vsa rig run --virtual, beside ``runs``."""
        return self.runs.with_name(f"{self.runs.name}-virtual")

    @property
    def emulated_runs(self) -> Path:
        """Folder of the runs on the ports of emg2vsa rig emulate, beside ``runs``."""
        return self.runs.with_name(f"{self.runs.name}-emulated")

    @property
    def leads_to_emulated(self) -> bool:
        """Did emg2vsa rig emulate write this file?"""
        return self.emulated is not None and self.emulated.behind_ports
