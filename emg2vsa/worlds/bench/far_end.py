"""The far end of an actuator's wire: what the emulated bench needs of each kind of actuator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple, Protocol

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Board
from emg2vsa.devices.qbmove.springs import Springs
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.errors import SettingError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.fault import Fault
from emg2vsa.worlds.bench.faults import Device, Frames
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.world import World


class ActuatorEnd(Device, Protocol):
    """A device that moves the world."""

    def advance(self) -> None:
        """Its motors run up to the clock."""


class Place(NamedTuple):
    """Where a far end is. settings : of the actuator, as its driver has them. latency_s : from a command until it is
    obeyed."""

    settings: Any
    emulated: EmulatedSettings
    rig: RigSettings
    world: World
    clock: Clock
    latency_s: float


@dataclass(frozen=True)
class FarEnd:
    """One kind.

    springs : between its motors and the shaft; None where a motor turns the shaft itself. device : that begins
    retracted. driver : the real one on a line in this process, asked byte for byte where ``exact``. table : keys of its
    settings with which a rig file leads to it. faults : of its motors and its wire, by name. frames : of its packets.
    """

    springs: Callable[[EmulatedSettings], Springs | None]
    device: Callable[[Place], ActuatorEnd]
    driver: Callable[[ByteLine, ActuatorEnd, Place, bool], Board]
    table: Callable[[Place], dict[str, Any]]
    faults: Mapping[str, Fault]
    frames: Frames


_FAR_ENDS = {
    "qbmove": "emg2vsa.worlds.far_ends.qbmove.far_end:FAR_END",
    "motor": "emg2vsa.worlds.far_ends.qbmove.motor_board:FAR_END",
    "dynamixel": "emg2vsa.worlds.far_ends.dynamixel.far_end:FAR_END",
}


def far_end_of(kind: str) -> FarEnd:
    """That of an actuator of this kind, or of the rigid motor, "motor". SettingError where it has none."""
    if kind not in _FAR_ENDS:
        do = "Run it on the device itself, or name another kind under [actuator]."
        raise SettingError(
            "actuator.kind", wanted=f"one that can be emulated: {', '.join(_FAR_ENDS)}", found=kind, do=do
        )
    module, _, name = _FAR_ENDS[kind].partition(":")
    found: FarEnd = getattr(import_module(module), name)
    return found
