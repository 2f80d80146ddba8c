"""Open the devices of a rig for a run, and close them again whatever happens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeVar, cast

from emg2vsa.devices.board import Board
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import ActuatorSettings, CameraSettings, ForceSettings
from emg2vsa.devices.protocols import Camera, Devices, ForceSensor, Identity, Usable
from emg2vsa.devices.qbmove import MotorSettings
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.opening import about, open_qbmove
from emg2vsa.devices.registry import Around, known
from emg2vsa.errors import DeviceError, InputError, SettingError
from emg2vsa.rig.identities import EXCHANGED, BoardSettings, Told, check_board, check_number, told_by, told_by_board
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import DeviceSettings, GuardSettings, RigSettings

D = TypeVar("D", ForceSensor, Camera)


@dataclass(frozen=True)
class OpenRig:
    """Devices that answer, force sensor and camera started, motors off; ``rig`` keeps what the device allows."""

    devices: Devices
    rig: RigSettings
    info: Identity
    facts: dict[str, Any]
    "What the devices say of themselves, for the record of the run."
    numbers: dict[str, Told]
    "Serial numbers by table."

    @property
    def serial_numbers(self) -> dict[str, str]:
        """By table; empty where a device tells none."""
        return {table: told.number for table, told in self.numbers.items()}


@contextmanager
def open_rig(settings: DeviceSettings, rig: RigSettings, condition: Condition, clock: Clock) -> Iterator[OpenRig]:
    """The rig for a run under ``condition``: with the rigid motor for high-stiffness, else with the qbmove.

    At the end the motors are switched off and everything is closed.

    Raises
    ------
    DeviceError : a device is absent, silent, of another generation or model, or not set up for runs; what was open is
    closed again.
    SettingError : the rig has no rigid motor and needs one.
    """
    with ExitStack() as stack:
        actuator = board_settings(settings, condition)
        board = stack.enter_context(closing(open_own_board(settings, condition, rig, clock)))
        stack.enter_context(board)
        info = board.identify()
        force = open_force(settings.force, rig.guards, clock)
        stack.callback(force.close)
        force.start()
        numbers = {
            "motor" if condition == RIGID else "actuator": told_by_board(board, actuator),
            "force": told_by("force", force, settings.force),
        }
        facts = {"board": asdict(info), "force": _force_facts(force, settings.force)}
        facts["serial_numbers"] = {table: told._asdict() for table, told in numbers.items()}
        if settings.force.bias:
            force.bias()
        camera = None
        if settings.camera:
            camera = open_camera(settings.camera, rig.guards, clock)
            stack.callback(camera.close)
            camera.start()
            said = known("camera", settings.camera).call("facts", camera, settings.camera)
            facts["camera"] = said | {"name": camera.name}
        devices, usable = Devices(board.pressing(), force, camera), board.usable(info)
        yield OpenRig(devices, within_device(with_full_preset(rig, usable, actuator), usable), info, facts, numbers)


def _force_facts(force: ForceSensor, settings: ForceSettings) -> dict[str, Any]:
    """Facts of a started sensor, before it is biased."""
    sample = force.read()
    load = {"force_n": sample.force_n.tolist(), "torque_nm": sample.torque_nm.tolist()}
    said: dict[str, Any] = known("force", settings).call("facts", force, settings)
    return {"name": force.name, "status": sample.status.code, "biased_by": load if settings.bias else None} | said


def board_settings(settings: DeviceSettings, condition: Condition) -> BoardSettings:
    """The actuator of a condition. SettingError where the rig has none."""
    if condition != RIGID:
        return settings.actuator
    if settings.motor is None:
        do = "Add it to the rig file, or choose another condition."
        raise SettingError("motor", wanted=f"a table [motor] for {RIGID}", found="none", do=do)
    return settings.motor


def open_board(settings: BoardSettings, rig: RigSettings, clock: Clock) -> Board:
    """An actuator that answers; nothing is switched, and its user closes it. DeviceError, SettingError as its kind."""
    around = Around(clock, stiffness_percent=rig.stiffness_percent)
    if isinstance(settings, MotorSettings):
        return open_qbmove(settings, around)
    board: Board = known("actuator", settings).opened(settings, around)
    return board


def open_own_board(settings: DeviceSettings, condition: Condition, rig: RigSettings, clock: Clock) -> Board:
    """The actuator of a condition, and no other: by its serial number, where the file has one, and by what it says.

    DeviceError, SettingError as `open_board` and `Board.identify`; it tells of exchanged ports, where these explain it.
    """
    own, name = board_settings(settings, condition), "motor" if condition == RIGID else "actuator"
    other = settings.actuator if condition == RIGID else settings.motor
    with ExitStack() as stack:
        try:
            board = stack.enter_context(closing(open_board(own, rig, clock)))
            check_board(name, board.where, own, other, told_by_board(board, own))
            board.identify()
        except DeviceError as error:
            stack.close()
            if other and own.port != other.port and EXCHANGED not in error.do and _answers_on(other, own, rig, clock):
                do = f"{error.do} Or t{EXCHANGED}"
                raise DeviceError(error.where, wanted=error.wanted, found=error.found, do=do) from error
            raise
        stack.pop_all()
        return board


def _answers_on(other: BoardSettings, own: BoardSettings, rig: RigSettings, clock: Clock) -> bool:
    """Does the device of the other table answer on the port of this one, in the other's words?"""
    try:
        with closing(open_board(replace(other, port=own.port), rig, clock)) as board:
            board.identify()
            return True
    except InputError:
        return False


def about_board(board: Board, settings: BoardSettings) -> Iterator[str]:
    """What an actuator says of itself, in lines. DeviceError: it is silent, or not as the rig file describes it."""
    if isinstance(settings, MotorSettings):
        yield from about(cast(Qbmove, board))
    else:
        yield from known("actuator", settings).call("about", board)


def open_force(settings: ForceSettings, guards: GuardSettings, clock: Clock) -> ForceSensor:
    """The force sensor, not yet started. DeviceError when it is absent; SettingError when the rig file has no host."""
    # the sensor gives up later than the guard, which tells a late sample from a late loop
    sensor: ForceSensor = known("force", settings).opened(settings, Around(clock, lost_s=2 * guards.stale_s))
    return _own("force", sensor, settings)


def open_camera(settings: CameraSettings, guards: GuardSettings, clock: Clock) -> Camera:
    """The camera, not yet started."""
    camera: Camera = known("camera", settings).opened(settings, Around(clock, lost_s=guards.camera_s))
    return _own("camera", camera, settings)


def _own(role: str, device: D, settings: ForceSettings | CameraSettings) -> D:
    try:
        check_number(role, device.name, settings.serial_number, told_by(role, device, settings))
    except BaseException:
        device.close()
        raise
    return device


def with_full_preset(rig: RigSettings, usable: Usable, settings: BoardSettings) -> RigSettings:
    """``rig`` with the full preset of the device, where none has been measured: nothing else says how much it is."""
    unmeasured = isinstance(settings, ActuatorSettings) and settings.unmeasured
    return replace(rig, full_preset=usable.full_preset) if unmeasured else rig


def within_device(rig: RigSettings, usable: Usable) -> RigSettings:
    """``rig`` with the limits of the device, and of those no wider than its own."""
    (low, high), (first, last) = usable.position_deg, rig.position_deg
    # of both ranges of stiffness, what they have in common, as percent of the device's maximum
    share = rig.full_preset / usable.full_preset
    least, most = rig.stiffness_percent
    return replace(
        rig,
        position_deg=(max(first, low), min(last, high)),
        full_preset=usable.full_preset,
        stiffness_percent=(least * max(1.0, share), most * min(1.0, share)),
    )
