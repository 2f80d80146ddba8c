"""A qbmove, or the rigid motor's board, behind the serial port that a rig file names, and what it says of itself."""

from __future__ import annotations

from collections.abc import Iterator

from emg2vsa.devices.board import answering, no_address
from emg2vsa.devices.qbmove import MotorSettings, QbmoveSettings
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.info import QbmoveInfo, QbmoveLimits
from emg2vsa.devices.registry import Around
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError


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
    do = "Check power, cable, id and generation; emg2vsa rig scan lists who answers."
    return answering(board, board.answers, do)


def about(board: Qbmove) -> Iterator[str]:
    """Firmware, limits, state, and whether it is set up for runs. DeviceError when it is absent or of another kind."""
    info = board.identify()
    yield f"firmware {info.firmware}, id {info.device_id}"
    yield f"control mode {info.control_mode}, input mode {info.input_mode}, resolutions {info.resolutions}"
    for motor, (low, high) in enumerate(info.position_limits_ticks, start=1):
        yield f"position limits of motor {motor}: {low} to {high} ticks"
    yield f"full stiffness {info.max_stiffness_ticks} ticks, current limit {info.current_limit_ma} mA"
    yield f"supply {info.voltage_mv / 1000:.1f} V"
    yield from _state(board)
    yield _ready(info, board.where, board.stiffness_percent)


def _state(board: Qbmove) -> Iterator[str]:
    yield f"motors {'on' if board.is_active() else 'off'}"
    at, currents_a = board.ticks(), board.currents_a()
    if board.rigid:  # motor 2 is not connected
        yield f"motor at {at.motor_1} ticks"
        yield f"current {1000 * currents_a[0]:.0f} mA"
        return
    yield "motors at {} and {} ticks, shaft at {}".format(*at)
    yield "currents {:.0f} and {:.0f} mA".format(*(1000 * current_a for current_a in currents_a))


def _ready(info: QbmoveInfo, where: str, stiffness_percent: tuple[float, float]) -> str:
    try:
        QbmoveLimits(where, info, stiffness_percent).check_ready()
    except DeviceError as error:
        return f"not ready for a run: {error}"
    return "set up for runs"
