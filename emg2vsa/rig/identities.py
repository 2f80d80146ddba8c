"""Is a device the one that the rig file means? Asked before anything moves, of the serial number that the file has."""

from __future__ import annotations

from typing import Any, NamedTuple

from emg2vsa.devices.board import Board
from emg2vsa.devices.device_settings import ActuatorSettings
from emg2vsa.devices.qbmove import MotorSettings
from emg2vsa.devices.registry import known
from emg2vsa.devices.serial_line import adapter_number
from emg2vsa.errors import DeviceError

BoardSettings = ActuatorSettings | MotorSettings
EXCHANGED = "he ports of [actuator] and [motor] are exchanged: exchange them in rig.toml."


class Told(NamedTuple):
    """A serial number, empty where there is none, and who tells it."""

    number: str
    by: str = "the device"

    @property
    def text(self) -> str:
        return f"serial number {self.number}, told by {self.by}" if self.number else "no serial number"


def told_by_board(board: Board, settings: BoardSettings) -> Told:
    """By its firmware, else by the USB adapter of its port: a qbmove before 7.1 and a Dynamixel tell none."""
    if number := board.serial_number():
        return Told(number)
    return Told(adapter_number(settings.port) if settings.port else "", "its USB adapter")


def told_by(role: str, device: Any, settings: Any) -> Told:
    """By a force sensor or a camera."""
    return Told(known(role, settings).call("serial_number", device))


def check_number(table: str, where: str, wanted: str | None, told: Told) -> None:
    """DeviceError for another serial number than that of the table, or where none is told."""
    if wanted not in (None, told.number):
        do = "Check port and cable, or correct serial_number in rig.toml."
        if not told.number:
            do = "Leave serial_number out: a device of this kind tells none."
        raise _another(table, where, f"serial number {wanted}", told, do)


def check_board(table: str, where: str, own: BoardSettings, other: BoardSettings | None, told: Told) -> None:
    """As `check_number`, with its DeviceError; ``other`` : the table of the other actuator, whose device may answer on
    this port."""
    if other and told.number == other.serial_number and own.port != other.port and told.number != own.serial_number:
        not_that = f"another device than that of [{'motor' if table == 'actuator' else 'actuator'}]"
        wanted = f"serial number {own.serial_number}" if own.serial_number else not_that
        raise _another(table, where, wanted, told, f"T{EXCHANGED}")
    check_number(table, where, own.serial_number, told)


def _another(table: str, where: str, wanted: str, told: Told, do: str) -> DeviceError:
    return DeviceError(f"[{table}] {where}", wanted=wanted, found=told.text, do=do)
