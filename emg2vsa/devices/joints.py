"""What each actuator makes of a stiffness preset, by the name that studies and schedules have for it."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import NamedTuple

from emg2vsa.devices.protocols import Joint
from emg2vsa.errors import ScheduleError


class Export(NamedTuple):
    """How schedules for a joint are written: by the folder of its device.

    joint : its name and full preset to the joint. column, limit : names of the preset of a step and of the full preset
    in a schedule. unit : of both, in words. per_preset : of that unit in the joint's own. whole : they are whole
    numbers. most : largest full preset in that unit.
    """

    joint: Callable[[str, float], Joint]
    column: str
    limit: str
    unit: str
    per_preset: float
    whole: bool
    most: float

    def exported(self, preset: float) -> int | float:
        """A preset, or full preset, in the joint's own unit, as a schedule has it."""
        value = preset * self.per_preset
        return round(value) if self.whole else value


_EXPORTS = {
    "qbmove-advanced": "emg2vsa.devices.qbmove.export",
    "qbmove-maker-pro": "emg2vsa.devices.qbmove.export",
    "dynamixel": "emg2vsa.devices.dynamixel.joint",
}


def joint_names() -> tuple[str, ...]:
    """Of every joint that schedules can be made for."""
    return tuple(_EXPORTS)


def export_of(name: str, where: str = "schedule.actuator") -> Export:
    """How schedules for the joint are written. ScheduleError where none has this name."""
    if name not in _EXPORTS:
        do = "Correct the name of the actuator."
        raise ScheduleError(where, wanted=f"one of {', '.join(_EXPORTS)}", found=repr(name), do=do)
    found: Export = import_module(_EXPORTS[name]).EXPORT
    return found


def joint_of(name: str, full_preset: float) -> Joint:
    """The joint of this name with a full preset in its own unit. ScheduleError as `export_of`."""
    return export_of(name).joint(name, full_preset)
