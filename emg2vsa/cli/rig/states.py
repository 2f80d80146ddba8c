"""What the devices of a rig say of themselves, in lines; the motors stay as they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from casr.command_line import print_json
from emg2vsa.errors import DeviceError, InputError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.device_settings import ActuatorSettings, CameraSettings, ForceSettings, MotorSettings
from emg2vsa.rig.force.net_ft import NetFt
from emg2vsa.rig.open_rig import board_info, open_board, open_camera, open_force, within_device
from emg2vsa.rig.qbmove.driver import Qbmove
from emg2vsa.rig.qbmove.info import QbmoveInfo, check_kind
from emg2vsa.rig.qbmove.limits import QbmoveLimits
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings

_WATCH_S = 1.0
"How long frames are counted."
Lines = Iterator[str]


class Telling:
    """Prints device after device as they answer, or all of them as JSON at the end."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self._devices: list[dict[str, Any]] = []

    def say(self, title: str, lines: Callable[[], Lines]) -> None:
        """``title`` and the lines of one device; that it is not usable, and why, where that is so."""
        told: dict[str, Any] = {"device": title, "usable": True, "problem": None, "lines": []}
        self._devices.append(told)
        self._print(title)
        try:
            for line in lines():
                told["lines"].append(line.strip())
                self._print(f"  {line}")
        except InputError as error:
            told |= {"usable": False, "problem": str(error)}
            self._print(f"  not usable: {error}")

    def remark(self, text: str) -> None:
        """Something of no one device."""
        self._print(text)

    def end(self, *, good: bool = True) -> int:
        """Exit status: 0 where ``good`` and all devices are usable."""
        if self._as_json:
            print_json({"devices": self._devices})
        return int(not (good and all(told["usable"] for told in self._devices)))

    def _print(self, text: str) -> None:
        if not self._as_json:
            print(text, flush=True)


def board_lines(settings: ActuatorSettings | MotorSettings, rig: RigSettings, clock: Clock) -> Lines:
    """Info text, state, what a run may use, and parameters. DeviceError when the board is absent."""
    rigid = isinstance(settings, MotorSettings)
    with open_board(settings, rig.stiffness_percent, clock) as board:
        info = board_info(board)
        yield from _facts(info)
        if isinstance(settings, ActuatorSettings):
            check_kind(info, settings.model, board.where)
        yield from _state(board, rigid)
        yield _ready(info, board.where, rig)
        usable = within_device(rig, info, rigid)
        yield "a run may use: positions {} to {} ticks".format(*usable.position_ticks) + (
            "" if rigid else ", {:.3g} to {:.3g} % of full stiffness".format(*usable.stiffness_percent)
        )
        yield "parameters:"
        for parameter in board.parameters().values():
            values = ", ".join(f"{value:g}" for value in parameter.values)
            yield f"  {parameter.number:>2} {parameter.name:<28} {values}"


def force_lines(settings: ForceSettings, guards: GuardSettings, clock: Clock) -> Lines:
    """Configuration, one sample and its status. DeviceError when the sensor is absent or silent."""
    sensor = open_force(settings, guards, clock)
    try:
        yield sensor.name
        if isinstance(sensor, NetFt):
            config = sensor.config
            yield f"{1 / config.n_per_count:g} counts/N, {1 / config.nm_per_count:g} counts/(N m)"
            yield f"{config.rate_hz:g} records a second, calibration {config.calibration_serial or 'not told'}"
        sensor.start()
        sample = sensor.read()
        yield "force {:.3f}, {:.3f}, {:.3f} N".format(*sample.force_n)
        remarks = "; ".join((*sample.status.faults, *sample.status.warnings))
        yield f"status 0x{sample.status.code:08x}: {remarks or 'good'}"
    finally:
        sensor.close()


def camera_lines(settings: CameraSettings, guards: GuardSettings, clock: Clock) -> Lines:
    """Size and true rate of its frames. DeviceError when it is absent or gives none."""
    camera = open_camera(settings, guards, clock)
    try:
        camera.start()
        clock.sleep_until(clock.now_s() + _WATCH_S)
        frames = camera.frames()
        height, width = camera.shape
        yield f"frames of {height} x {width} pixels, {len(frames)} in {_WATCH_S:g} s"
        yield f"mean grey level {frames[-1].image.mean():.0f} of 255"
    finally:
        camera.close()


def _facts(info: QbmoveInfo) -> Lines:
    yield f"firmware {info.firmware}, id {info.device_id}"
    yield f"control mode {info.control_mode}, input mode {info.input_mode}, resolutions {info.resolutions}"
    for motor, (low, high) in enumerate(info.position_limits_ticks, start=1):
        yield f"position limits of motor {motor}: {low} to {high} ticks"
    yield f"full stiffness {info.max_stiffness_ticks} ticks, current limit {info.current_limit_ma} mA"
    yield f"supply {info.voltage_mv / 1000:.1f} V"


def _state(board: Qbmove, rigid: bool) -> Lines:
    yield f"motors {'on' if board.is_active() else 'off'}"
    at = board.measurements()
    if rigid:  # motor 2 is not connected
        yield f"motor at {at.motor_1} ticks"
        yield f"current {board.currents_ma()[0]} mA"
        return
    yield "motors at {} and {} ticks, shaft at {}".format(*at)
    yield "currents {} and {} mA".format(*board.currents_ma())


def _ready(info: QbmoveInfo, where: str, rig: RigSettings) -> str:
    try:
        QbmoveLimits(where, info, rig.stiffness_percent).check_ready()
    except DeviceError as error:
        return f"not ready for a run: {error}"
    return "set up for runs"
