"""What the devices of a rig say of themselves, in lines; the motors stay as they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, nullcontext
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

from casr.errors import PluginError
from emg2vsa.devices.clock import Clock, WallClock
from emg2vsa.devices.device_settings import CameraSettings, ForceSettings
from emg2vsa.devices.protocols import Measurements, Parameter
from emg2vsa.devices.qbmove.conversation import qbmove_ports
from emg2vsa.devices.registry import Kind, kinds, known
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError, InputError, SettingError
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.rig_lock import rig_lock
from emg2vsa.rig.identities import Told, told_by, told_by_board
from emg2vsa.rig.open_rig import (
    about_board,
    board_settings,
    open_camera,
    open_force,
    open_own_board,
    with_full_preset,
    within_device,
)
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import GuardSettings
from emg2vsa.rig_file import RigFile

_WATCH_S = 1.0
"How long frames are counted."
_CONDITIONS: dict[str, Condition] = {"actuator": "modular", "motor": RIGID}
"""Table to a condition in which its device presses."""
Lines = Iterator[str]


@dataclass(frozen=True)
class DeviceState:
    """One device. usable : it answers, and a run may use it. problem : why not; None where it is. lines : what it says
    of itself, each a fact."""

    device: str
    usable: bool
    problem: str | None
    lines: tuple[str, ...]


def info(file: RigFile, person: Person = NOBODY) -> tuple[DeviceState, ...]:
    """Every device of the rig file: firmware, limits, parameters and readings. DeviceError where the rig is in use."""
    clock, devices = WallClock(), file.devices
    titled: dict[str, Callable[[], Lines]] = {
        f"[{name}] {board.port or 'without a port'}, id {board.id}": partial(_board, file, condition, clock)
        for name, condition in _CONDITIONS.items()
        if (board := getattr(devices, name))
    }
    with rig_lock(file.path):
        return tuple(_told(titled | _sensors(file, clock), person))


def scan(
    file: RigFile | None = None, *, ports: Sequence[str] = (), kind: str = "qbmove", baud: int | None = None,
    ids: Sequence[int] = (), wait_s: float = 0.005, person: Person = NOBODY,
) -> tuple[DeviceState, ...]:  # fmt: skip
    """Serial adapters as actuators have; who answers on ``ports`` and those of the rig file; its sensor and camera.

    kind : of actuator that is asked for on ``ports``. baud : of ``ports``; None: as the kind has it.
    ids : the only ones to ask; none: all that there are. wait_s : for each answer, s.
    SettingError : no such kind. DeviceError : the rig of the file is in use.
    Nothing is sent to a port or address that is not named.
    """
    clock = WallClock()
    boards = [board for board in (file.devices.actuator, file.devices.motor) if board] if file else []
    asked = {board.port: (getattr(board, "kind", "qbmove"), board.baud) for board in boards if board.port}
    asked |= dict.fromkeys(ports, (kind, baud or _usual_baud(kind)))
    adapters = [port for port in qbmove_ports() if port not in asked]
    found = list(_told(dict.fromkeys(adapters, _adapter), person))
    titled: dict[str, Callable[[], Lines]] = {
        port: partial(_answers, port, *how, ids, wait_s, clock) for port, how in asked.items()
    }
    with rig_lock(file.path) if file else nullcontext():
        return (*found, *_told(titled | (_sensors(file, clock) if file else {}), person))


def _sensors(file: RigFile, clock: Clock) -> dict[str, Callable[[], Lines]]:
    guards, camera = file.rig.guards, file.devices.camera
    titled: dict[str, Callable[[], Lines]] = {"[force]": partial(_force, file.devices.force, guards, clock)}
    if camera:
        titled[f"[camera] {getattr(camera, 'source', camera.kind)}"] = partial(_camera, camera, guards, clock)
    return titled


def _told(titled: Mapping[str, Callable[[], Lines]], person: Person) -> Iterator[DeviceState]:
    """Device after device as they answer; that one is not usable, and why, where that is so."""
    for title, said in titled.items():
        lines, problem = list[str](), None
        person.say(title)
        try:
            for line in said():
                lines.append(line.strip())
                person.say(f"  {line}")
        except (InputError, PluginError) as error:
            problem = str(error)
            person.say(f"  not usable: {error}")
        yield DeviceState(title, problem is None, problem, tuple(lines))


def _adapter() -> Lines:
    yield "an adapter as actuators have; ask it with --port"


def scanned_kind(name: str) -> Kind:
    """A kind of actuator that can be looked for. SettingError where there is none of this name."""
    known = {each: kind for each, kind in kinds("actuator").items() if kind.scan}
    if name not in known:
        do = "Choose one of these."
        raise SettingError("--kind", wanted=f"one of {', '.join(known)}", found=name, do=do)
    return known[name]


def _usual_baud(kind: str) -> int:
    usual: dict[str, Any] = {each.name: each.default for each in fields(scanned_kind(kind).settings)}
    return int(usual["baud"])


def _answers(port: str, kind: str, baud: int, ids: Sequence[int], wait_s: float, clock: Clock) -> Lines:
    with closing(SerialLine(port, baud)) as line:
        found = scanned_kind(kind).call("scan", line, clock, ids, wait_s)
    if not found:
        do = "Check power, cable and --baud; a slow line may need --wait-ms 20."
        raise DeviceError(port, wanted=f"a {kind} that answers", found="none", do=do)
    yield from found


def _board(file: RigFile, condition: Condition, clock: Clock) -> Lines:
    """Info text, state, what a run may use, and parameters. DeviceError when the board is absent, or another's."""
    settings = board_settings(file.devices, condition)
    with closing(open_own_board(file.devices, condition, file.rig, clock)) as board:
        yield from about_board(board, settings)
        yield from _number(told_by_board(board, settings))
        says = board.usable(board.identify())
        usable = within_device(with_full_preset(file.rig, says, settings), says)
        yield "a run may use: positions {:.6g} to {:.6g} degrees".format(*usable.position_deg) + (
            "" if board.rigid else ", {:.3g} to {:.3g} % of full stiffness".format(*usable.stiffness_percent)
        )
        yield "parameters:"
        for parameter in board.parameters().values():
            yield f"  {parameter_line(parameter)}"


def _number(told: Told) -> Lines:
    if told.number:
        yield told.text


def angles(at: Measurements) -> str:
    """``motors at 1.00 and 2.00 degrees, shaft at 1.50``."""
    motors = " and ".join(f"{angle_deg:.2f}" for angle_deg in at.motors_deg)
    return f"motor{'s' if len(at.motors_deg) > 1 else ''} at {motors} degrees, shaft at {at.shaft_deg:.2f}"


def parameter_line(parameter: Parameter) -> str:
    """Number, name and values."""
    return f"{parameter.number:>2} {parameter.name:<28} {shown(parameter.values)}"


def shown(values: Sequence[float]) -> str:
    """``1, 2.5``."""
    return ", ".join(f"{value:g}" for value in values)


def _force(settings: ForceSettings, guards: GuardSettings, clock: Clock) -> Lines:
    """Configuration, one sample and its status. DeviceError when the sensor is absent or silent."""
    sensor = open_force(settings, guards, clock)
    try:
        yield sensor.name
        yield from known("force", settings).call("about", sensor)
        yield from _number(told_by("force", sensor, settings))
        sensor.start()
        sample = sensor.read()
        yield "force {:.3f}, {:.3f}, {:.3f} N".format(*sample.force_n)
        remarks = "; ".join((*sample.status.faults, *sample.status.warnings))
        yield f"status 0x{sample.status.code:08x}: {remarks or 'good'}"
    finally:
        sensor.close()


def _camera(settings: CameraSettings, guards: GuardSettings, clock: Clock) -> Lines:
    """Size and true rate of its frames. DeviceError when it is absent or gives none."""
    camera = open_camera(settings, guards, clock)
    try:
        yield from known("camera", settings).call("about", camera)
        yield from _number(told_by("camera", camera, settings))
        camera.start()
        clock.sleep_until(clock.now_s() + _WATCH_S)
        frames = camera.frames()
        height, width = camera.shape
        yield f"frames of {height} x {width} pixels, {len(frames)} in {_WATCH_S:g} s"
        yield f"mean grey level {frames[-1].image.mean():.0f} of 255"
    finally:
        camera.close()
