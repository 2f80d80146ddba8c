"""The tables of a rig file, as dataclasses; most are the settings of the drivers and of the executor themselves."""

from __future__ import annotations

from dataclasses import dataclass, field

from emg2vsa.rig.device_settings import ActuatorSettings, CameraSettings, ForceSettings, MotorSettings, Text
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.settings import FORBID_UNKNOWN_KEYS


@dataclass(frozen=True, kw_only=True)
class ExperimentTable(ExperimentSettings):
    """What is pressed and how, and where its files are. Paths are relative to the folder of the rig file."""

    schedules: Text | None = None
    "Folder of the schedules; omitted: ../../reports/<folder of the rig file>/schedules, where they are exported to."
    runs: Text = "runs"
    "Folder in which each run gets a folder of its own."


@dataclass(frozen=True, kw_only=True)
class RigTables:
    """A whole rig file."""

    __pydantic_config__ = FORBID_UNKNOWN_KEYS

    rig: RigSettings = field(default_factory=RigSettings)
    "Mechanics, limits and control loop."
    actuator: ActuatorSettings
    "The qbmove."
    motor: MotorSettings | None = None
    "The rigid motor that the condition high-stiffness needs."
    force: ForceSettings
    "The force sensor."
    camera: CameraSettings | None = None
    "The tactile camera; without it no frames are kept."
    experiment: ExperimentTable
    "What is pressed, and how."
    emulated: EmulatedSettings | None = None
    "The bench that emg2vsa rig emulate and emg2vsa rig run --virtual put in place of a real one."
