"""A Dynamixel on the emulated bench, set up as docs/how-to/dynamixel.md says."""

from __future__ import annotations

from typing import Any, get_args

from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.dynamixel.settings import Baud
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.errors import SettingError
from emg2vsa.worlds.bench.far_end import ActuatorEnd, FarEnd, Place
from emg2vsa.worlds.bench.wire_faults import WIRE_FAULTS
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.faults import MOTOR_FAULTS
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.framing import DynamixelFrames
from emg2vsa.worlds.far_ends.dynamixel.models import MODELS

_MIDDLE_DEG = 180.0
"""What the encoder reads where the joint's angle is 0."""


def _device(place: Place) -> DynamixelFirmware:
    settings, model = place.settings, MODELS.get(place.settings.model.upper())
    if model is None:
        do = "Choose one of these, or use the motor itself."
        raise SettingError(
            "actuator.model", wanted=", ".join(name.lower() for name in MODELS), found=settings.model, do=do
        )
    device = DynamixelFirmware(
        model, place.world, place.clock, motor_id=settings.id, home_deg=_MIDDLE_DEG + place.rig.home_deg,
        loads=place.world.loads_nm, latency_s=place.latency_s,
    )  # fmt: skip
    baud = get_args(Baud).index(settings.baud)
    device.table.values |= {t.OPERATING_MODE: t.CURRENT_BASED_POSITION, t.RETURN_DELAY: 0, t.BAUD_RATE: baud}
    return device


def _driver(line: ByteLine, device: ActuatorEnd, place: Place, exact: bool) -> Dynamixel:
    return Dynamixel(line, place.settings, clock=place.clock)


def _table(place: Place) -> dict[str, Any]:
    keys = (
        "kind", "id", "model", "full_gain", "d_gain", "full_stiffness_nm_per_rad", "goal_current_a", "watchdog_s",
        "reply_s",
    )  # fmt: skip
    return {key: value for key in keys if (value := getattr(place.settings, key)) is not None}


FAR_END = FarEnd(
    springs=lambda emulated: None,
    device=_device,
    driver=_driver,
    table=_table,
    faults=WIRE_FAULTS | MOTOR_FAULTS,
    frames=DynamixelFrames(),
)
