"""Open the devices of a rig for a run, and close them again whatever happens."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any

import cv2

from emg2vsa.ati.cal_file import read_calibration
from emg2vsa.devices.addresses import no_address
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import (
    ActuatorSettings,
    CameraSettings,
    DeviceSettings,
    ForceSettings,
    MotorSettings,
)
from emg2vsa.devices.netft.driver import NetFt, open_net_ft
from emg2vsa.devices.ni_daq.gauges import DaqFt
from emg2vsa.devices.ni_daq.volts import NiVolts
from emg2vsa.devices.opencv_camera.driver import OpenCvCamera
from emg2vsa.devices.protocols import Devices, ForceSensor, Identity, Usable
from emg2vsa.devices.qbmove.opening import open_board
from emg2vsa.errors import SettingError
from emg2vsa.rig.plan import RIGID, Condition
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings


@dataclass(frozen=True)
class OpenRig:
    """Devices that answer, force sensor and camera started, motors off; ``rig`` keeps what the device allows."""

    devices: Devices
    rig: RigSettings
    info: Identity
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
        info = board.identify()
        force = open_force(settings.force, rig.guards, clock)
        stack.callback(force.close)
        force.start()
        facts = {"board": asdict(info), "force": _force_facts(force, biased=settings.force.bias)}
        if settings.force.bias:
            force.bias()
        camera = None
        if settings.camera:
            camera = open_camera(settings.camera, rig.guards, clock)
            stack.callback(camera.close)
            camera.start()
            facts["camera"] = asdict(settings.camera) | {"name": camera.name, "set": camera.locked}
        devices = Devices(board.pressing(), force, camera)
        yield OpenRig(devices, within_device(rig, board.usable(info)), info, facts)


def _force_facts(force: ForceSensor, *, biased: bool) -> dict[str, Any]:
    """Of a started sensor, before it is biased."""
    sample = force.read()
    load = {"force_n": sample.force_n.tolist(), "torque_nm": sample.torque_nm.tolist()}
    facts = {"name": force.name, "status": sample.status.code, "biased_by": load if biased else None}
    if isinstance(force, NetFt):
        return facts | asdict(force.config)
    if isinstance(force, DaqFt):
        return facts | {"calibration_serial": force.calibration.serial}
    return facts


def board_settings(settings: DeviceSettings, condition: Condition) -> ActuatorSettings | MotorSettings:
    """The actuator of a condition. SettingError where the rig has none."""
    if condition != RIGID:
        return settings.actuator
    if settings.motor is None:
        do = "Add it to the rig file, or choose another condition."
        raise SettingError("motor", wanted=f"a table [motor] for {RIGID}", found="none", do=do)
    return settings.motor


def open_force(settings: ForceSettings, guards: GuardSettings, clock: Clock) -> ForceSensor:
    """The force sensor, not yet started. DeviceError when it is absent; SettingError when the rig file has no host."""
    # the sensor gives up later than the guard, which tells a late sample from a late loop
    stale_s = 2 * guards.stale_s
    if settings.kind == "net-ft":
        if settings.host is None:
            raise no_address("force.host", "the address of the box", "It leaves the factory with 192.168.1.1.")
        ports = {"rdt_port": settings.rdt_port, "http_port": settings.http_port}
        return open_net_ft(settings.host, clock, buffered=settings.buffered, stale_s=stale_s, **ports)
    calibration = read_calibration(settings.cal_file or "")
    return DaqFt(NiVolts(settings.channels or "", calibration.range_v), calibration, clock, stale_s=stale_s)


def open_camera(settings: CameraSettings, guards: GuardSettings, clock: Clock) -> OpenCvCamera:
    """The camera, not yet started."""
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # the driver says it in words
    shape = settings.height, settings.width
    values = {"exposure": settings.exposure, "gain": settings.gain, "white_balance_k": settings.white_balance_k}
    lock = values if settings.lock or any(value is not None for value in values.values()) else None
    return OpenCvCamera(
        settings.source, clock,
        shape=shape, rate_hz=settings.rate_hz, delay_s=settings.delay_s, lost_s=guards.camera_s, lock=lock,
    )  # fmt: skip


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
