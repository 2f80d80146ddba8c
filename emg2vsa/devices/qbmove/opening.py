"""A qbmove, or the rigid motor's board, behind the serial port that a rig file names."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from emg2vsa.devices.addresses import no_address
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import ActuatorSettings, MotorSettings
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError


@contextmanager
def open_board(
    settings: ActuatorSettings | MotorSettings, stiffness_percent: tuple[float, float], clock: Clock
) -> Iterator[Qbmove]:
    """The board behind its serial port; nothing is switched.

    DeviceError : no such port or id. SettingError : the rig file names no port: none is guessed.
    """
    rigid = isinstance(settings, MotorSettings)
    if settings.port is None:
        table = "motor" if rigid else "actuator"
        raise no_address(f"{table}.port", "the serial port of the device", "emg2vsa rig scan lists the ports.")
    line = SerialLine(settings.port, settings.baud)
    try:
        board = Qbmove(
            line,
            settings.id,
            generation=settings.generation,
            model="maker-pro" if isinstance(settings, MotorSettings) else settings.model,
            rigid=rigid,
            clock=clock,
            stiffness_percent=stiffness_percent,
            watchdog_s=settings.watchdog_s,
            reply_s=settings.reply_s,
        )
        if not board.ping():
            do = "Check power, cable, id and generation; emg2vsa rig scan lists who answers."
            raise DeviceError(board.where, wanted="a device that answers", found="no answer", do=do)
        yield board
    finally:
        line.close()
