"""A Dynamixel on the emulated bench, set up as docs/how-to/dynamixel.md says."""

from __future__ import annotations

from typing import Any, get_args

from emg2vsa.devices.dynamixel import Baud
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.errors import SettingError
from emg2vsa.worlds.far_ends.actuator_end import FarEnd, Place
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.firmware import DynamixelFirmware
from emg2vsa.worlds.far_ends.dynamixel.motor import MotorFaults
from emg2vsa.worlds.far_ends.dynamixel.packets import DynamixelFrames
from emg2vsa.worlds.far_ends.faults import WIRE_FAULTS, Fault, Strike, faults_in

_MIDDLE_DEG = 180.0
"""What the encoder reads where the joint's angle is 0."""
_KEYS = (
    "kind", "id", "model", "full_gain", "d_gain", "full_stiffness_nm_per_rad", "goal_current_a", "watchdog_s",
    "reply_s",
)  # fmt: skip


def _device(place: Place) -> DynamixelFirmware:
    settings, model = place.settings, t.MODELS.get(place.settings.model.upper())
    if model is None:
        do = "Choose one of these, or use the motor itself."
        raise SettingError(
            "actuator.model", wanted=", ".join(name.lower() for name in t.MODELS), found=settings.model, do=do
        )
    device = DynamixelFirmware(
        model, place.world, place.clock, motor_id=settings.id, home_deg=_MIDDLE_DEG + place.rig.home_deg,
        loads=place.world.loads_nm, latency_s=place.latency_s,
    )  # fmt: skip
    baud = get_args(Baud).index(settings.baud)
    device.table.values |= {t.OPERATING_MODE: t.CURRENT_BASED_POSITION, t.RETURN_DELAY: 0, t.BAUD_RATE: baud}
    return device


def _table(place: Place) -> dict[str, Any]:
    return {key: value for key in _KEYS if (value := getattr(place.settings, key)) is not None}


def _hardware(bit: int) -> Strike:
    def strike(bench: Any, on: float) -> None:
        faults: MotorFaults = bench.firmware.motor.faults
        faults.hardware_error = faults.hardware_error | bit if on else faults.hardware_error & ~bit

    return strike


MOTOR_FAULTS = faults_in("firmware.motor.faults", MotorFaults) | {
    "overload": Fault("the motor says that it is overloaded", _hardware(0x20), "switch"),
    "shock": Fault("the motor says that its electronics had a shock", _hardware(0x10), "switch"),
    "broken-encoder": Fault("the motor says that its encoder is broken", _hardware(0x08), "switch"),
}
DYNAMIXEL = FarEnd(
    springs=lambda name: None,
    device=_device,
    driver=lambda line, device, place, exact: Dynamixel(line, place.settings, clock=place.clock),
    table=_table,
    faults=WIRE_FAULTS | MOTOR_FAULTS,
    frames=DynamixelFrames(),
)
