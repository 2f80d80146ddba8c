"""A qbmove, or the rigid motor's board, behind the serial port that a rig file names."""

from __future__ import annotations

from emg2vsa.devices.addresses import no_address
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.settings import MotorSettings, QbmoveSettings
from emg2vsa.devices.registry import Around
from emg2vsa.devices.serial_line import SerialLine


def open_qbmove(settings: QbmoveSettings | MotorSettings, around: Around) -> Qbmove:
    """The board, which answers; nothing is switched. Its user closes it.

    DeviceError : no such port or id. SettingError : the rig file names no port: none is guessed.
    """
    rigid = isinstance(settings, MotorSettings)
    if settings.port is None:
        table = "motor" if rigid else "actuator"
        raise no_address(f"{table}.port", "the serial port of the device", "emg2vsa rig scan lists the ports.")
    board = Qbmove(
        SerialLine(settings.port, settings.baud),
        settings.id,
        generation=settings.generation,
        model="maker-pro" if isinstance(settings, MotorSettings) else settings.model,
        rigid=rigid,
        clock=around.clock,
        stiffness_percent=around.stiffness_percent,
        watchdog_s=settings.watchdog_s,
        reply_s=settings.reply_s,
    )
    return board.answering("Check power, cable, id and generation; emg2vsa rig scan lists who answers.")
