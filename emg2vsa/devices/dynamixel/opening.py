"""A Dynamixel behind the serial port that a rig file names."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.devices.addresses import no_address
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.dynamixel.settings import DynamixelSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.serial_line import SerialLine


def open_dynamixel(settings: DynamixelSettings, around: Around) -> Dynamixel:
    """The motor, which answers; nothing is switched. Its user closes it.

    DeviceError : no such port or id, or no dynamixel-sdk. SettingError : the rig file names no port: none is guessed.
    """
    if settings.port is None:
        do = "emg2vsa rig scan --port PORT --kind dynamixel asks a port."
        raise no_address("actuator.port", "the serial port of the motor", do)
    board = Dynamixel(SerialLine(settings.port, settings.baud), settings, clock=around.clock)
    return board.answering("Check power, cable, id and baud rate; emg2vsa rig scan lists who answers.")


def about(board: Dynamixel) -> Iterator[str]:
    """What the motor says of itself, in lines."""
    return board.about()
