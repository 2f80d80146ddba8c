"""The force sensor of a rig file as the source of a session's force: table [session.force]."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from emg2vsa.devices.registry import Kind, Wrong
from emg2vsa.session_settings import SessionForceSettings, Text
from emg2vsa.settings_class import settings_class


@settings_class
class RigForceSettings(SessionForceSettings):
    """The force sensor of a rig, pressed by a finger."""

    kind: Literal["rig"] = "rig"
    rig: Text
    "The rig file, relative to the folder of the study file; its [force] table is used and no other."
    axis: tuple[float, float, float] = (0.0, 0.0, -1.0)
    "Direction, in the sensor's axes, in which a pressing finger pushes."


def _wrong(force: RigForceSettings) -> Iterator[Wrong]:
    if not any(force.axis):
        yield Wrong(("axis",), "a direction", str(list(force.axis)), "A finger that presses along -z has [0, 0, -1].")


RIG = Kind("session-force", RigForceSettings, open="rig_force.driver:open_rig_force", check=_wrong)
