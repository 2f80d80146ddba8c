"""Open the devices of a rig for a run, and close them again whatever happens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import CameraSettings, ForceSettings
from emg2vsa.devices.protocols import Camera, Devices, ForceSensor
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.info import QbmoveInfo, check_kind
from emg2vsa.devices.qbmove.limits import roomy_positions
from emg2vsa.devices.qbmove.rigid_motor import RigidMotor
from emg2vsa.devices.qbmove.settings import ActuatorSettings, Generation, MotorSettings
from emg2vsa.devices.registry import Around, known
from emg2vsa.devices.rig_devices import DeviceSettings
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings


@dataclass(frozen=True)
class OpenRig:
    """Devices that answer, force sensor and camera started, motors off; ``rig`` keeps what the device allows."""

    devices: Devices
    rig: RigSettings
    info: QbmoveInfo
    facts: dict[str, Any]
    "What the devices say of themselves, for the record of the run."


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
        board = stack.enter_context(open_board(board_settings(settings, condition), rig.stiffness_percent, clock))
        stack.enter_context(board)
        info = board_info(board)
        if condition != RIGID:
            check_kind(info, settings.actuator.model, board.where)
        force = open_force(settings.force, rig.guards, clock)
        stack.callback(force.close)
        force.start()
        facts = {"board": asdict(info), "force": _force_facts(force, settings.force)}
        if settings.force.bias:
            force.bias()
        camera = None
        if settings.camera:
            camera = open_camera(settings.camera, rig.guards, clock)
            stack.callback(camera.close)
            camera.start()
            said = known("camera", settings.camera).call("facts", camera, settings.camera)
            facts["camera"] = said | {"name": camera.name}
        rigid = condition == RIGID
        devices = Devices(RigidMotor(board) if rigid else board, force, camera)
        yield OpenRig(devices, within_device(rig, info, rigid), info, facts)


def _force_facts(force: ForceSensor, settings: ForceSettings) -> dict[str, Any]:
    """Of a started sensor, before it is biased."""
    sample = force.read()
    load = {"force_n": sample.force_n.tolist(), "torque_nm": sample.torque_nm.tolist()}
    said: dict[str, Any] = known("force", settings).call("facts", force, settings)
    return {"name": force.name, "status": sample.status.code, "biased_by": load if settings.bias else None} | said


def board_settings(settings: DeviceSettings, condition: Condition) -> ActuatorSettings | MotorSettings:
    """The actuator of a condition. SettingError where the rig has none."""
    if condition != RIGID:
        return settings.actuator
    if settings.motor is None:
        do = "Add it to the rig file, or choose another condition."
        raise SettingError("motor", wanted=f"a table [motor] for {RIGID}", found="none", do=do)
    return settings.motor


@contextmanager
def open_board(
    settings: ActuatorSettings | MotorSettings, stiffness_percent: tuple[float, float], clock: Clock
) -> Iterator[Qbmove]:
    """The board behind its serial port; nothing is switched.

    DeviceError : no such port or id. SettingError : the rig file names no port: none is guessed.
    """
    if settings.port is None:
        table = "actuator" if isinstance(settings, ActuatorSettings) else "motor"
        raise _no_address(f"{table}.port", "the serial port of the device", "emg2vsa rig scan lists the ports.")
    line = SerialLine(settings.port, settings.baud)
    try:
        board = Qbmove(
            line,
            settings.id,
            generation=settings.generation,
            model=settings.model if isinstance(settings, ActuatorSettings) else "maker-pro",
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


def board_info(board: Qbmove) -> QbmoveInfo:
    """What the board says of itself. DeviceError where it is silent, or not of the generation of the rig file.

    The generations frame this text in different ways, so that a board asked in the wrong one seems to be silent; it is
    then asked in the other.
    """
    said, troubles = board.generation, []
    generations: tuple[Generation, ...] = ("v7", "v6") if said == "v7" else ("v6", "v7")
    for board.generation in generations:
        try:
            info = board.info()
        except DeviceError as error:
            troubles.append(error)
            continue
        finally:
            board.generation = said
        if info.generation != said:
            do = f'Set generation = "{info.generation}" in the rig file.'
            raise DeviceError(f"{board.where}, generation", wanted=f"firmware {said}", found=info.firmware, do=do)
        return info
    raise troubles[0]


def open_force(settings: ForceSettings, guards: GuardSettings, clock: Clock) -> ForceSensor:
    """The force sensor, not yet started. DeviceError when it is absent; SettingError when the rig file has no host."""
    # the sensor gives up later than the guard, which tells a late sample from a late loop
    sensor: ForceSensor = known("force", settings).opened(settings, Around(clock, lost_s=2 * guards.stale_s))
    return sensor


def _no_address(key: str, wanted: str, do: str) -> SettingError:
    do = f"Write it into the rig file, or use the emulated rig (--virtual). {do}"
    return SettingError(key, wanted=wanted, found="none", do=do)


def open_camera(settings: CameraSettings, guards: GuardSettings, clock: Clock) -> Camera:
    """The camera, not yet started."""
    camera: Camera = known("camera", settings).opened(settings, Around(clock, lost_s=guards.camera_s))
    return camera


def within_device(rig: RigSettings, info: QbmoveInfo, rigid: bool) -> RigSettings:
    """``rig`` with the limits of the device, and of those no wider than its own."""
    low, high = info.position_limits_ticks[0] if rigid else roomy_positions(info)
    first, last = rig.position_ticks
    # presets are ticks in the end: of both ranges, what they have in common, as percent of the device's maximum
    share = rig.max_preset_ticks / info.max_stiffness_ticks
    least, most = rig.stiffness_percent
    return replace(
        rig,
        position_ticks=(max(first, low), min(last, high)),
        max_preset_ticks=info.max_stiffness_ticks,
        stiffness_percent=(least * max(1.0, share), most * min(1.0, share)),
    )
