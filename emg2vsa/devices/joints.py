"""What each actuator makes of a stiffness preset, by the name that studies and schedules have for it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from emg2vsa.devices.protocols import Joint
from emg2vsa.devices.registry import Kind, each_kind, loaded
from emg2vsa.errors import ScheduleError


class Export(NamedTuple):
    """How schedules for a joint are written: by the folder of its device.

    joint : its name and full preset to the joint. column : name of the preset of a step in a schedule. unit : of it and
    of the full preset, in words. per_preset : of that unit in the joint's own. whole : they are whole numbers. most :
    largest full preset in that unit. remark : what a report says of runs with this joint. limit : name of the full
    preset; of its kind of device, not given here.
    """

    joint: Callable[[str, float], Joint]
    column: str
    unit: str
    per_preset: float
    whole: bool
    most: float
    remark: str = ""
    limit: str = ""

    def exported(self, preset: float) -> int | float:
        """A preset, or full preset, in the joint's own unit, as a schedule has it."""
        value = preset * self.per_preset
        return round(value) if self.whole and math.isfinite(value) else value


def joint_names() -> tuple[str, ...]:
    """Names of every joint that schedules can be made for, those of other packages last."""
    return tuple(name for _, kind in each_kind("actuator") for name in kind.joints)


def kind_with(joint: str) -> Kind | None:
    """The actuator that has a joint of this name; None for none."""
    return next((kind for _, kind in each_kind("actuator") if joint in kind.joints), None)


def export_of(name: str, where: str = "schedule.actuator") -> Export:
    """How schedules for the joint are written. ScheduleError where none has this name."""
    if kind := kind_with(name):
        found: Export = loaded(kind.export)
        return found._replace(limit=kind.full_key)
    do = "Correct the name of the actuator."
    raise ScheduleError(where, wanted=f"one of {', '.join(joint_names())}", found=repr(name), do=do)


def joint_of(name: str, full_preset: float) -> Joint:
    """The joint of this name with a full preset in its own unit. ScheduleError as `export_of`."""
    return export_of(name).joint(name, full_preset)
