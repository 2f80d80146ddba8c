"""The far end of an actuator's wire: what the emulated bench needs of each kind of actuator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

from emg2vsa.devices.board import Board
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.qbmove.springs import Springs
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.far_ends.faults import Device, Fault, Frames

Torques = tuple[float, float]
Loads = Callable[[tuple[float, float]], Torques]
"""Torque on each motor, N m, that it must do to go on the way it counts, with the motors at these angles, rad."""


def no_loads(motors_rad: tuple[float, float]) -> Torques:
    """Motors, at angles in rad, that nothing holds back: 0 N m."""
    return 0.0, 0.0


class Shaft(Protocol):
    """What the motors pull at: springs, shaft, and whatever the shaft touches."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        """Angle of the shaft, rad, with the motors there since ``time_s``; times never go back."""


class World(Shaft, Protocol):
    """Shaft and loads in one."""

    def loads_nm(self, motors_rad: tuple[float, float]) -> Torques:
        """As `Loads`: N m on each motor, at angles in rad."""


class ActuatorEnd(Device, Protocol):
    """A device that moves the world."""

    def advance(self) -> None:
        """Its motors run up to the clock."""


class Place(NamedTuple):
    """Where a far end is. settings : of the actuator, as its driver has them. springs : name of a qbmove's, whatever
    stands here. latency_s : from a command until it is obeyed. serial_number : that it tells; "" for none."""

    settings: Any
    springs: str
    rig: RigSettings
    world: World
    clock: Clock
    latency_s: float
    serial_number: str = ""


@dataclass(frozen=True)
class FarEnd:
    """One kind.

    springs : by name, between its motors and the shaft; None where a motor turns the shaft itself. device : that begins
    retracted. driver : the real one on a line in this process, asked byte for byte where ``exact``. table : keys of its
    settings with which a rig file leads to it. faults : of its motors and its wire, by name. frames : of its packets.
    """

    springs: Callable[[str], Springs | None]
    device: Callable[[Place], ActuatorEnd]
    driver: Callable[[ByteLine, Any, Place, bool], Board]
    table: Callable[[Place], dict[str, Any]]
    faults: Mapping[str, Fault]
    frames: Frames
