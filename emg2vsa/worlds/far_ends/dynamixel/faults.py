"""Faults of the emulated Dynamixel by name. Those of its wire are in ``emg2vsa.worlds.bench.wire_faults``."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

from emg2vsa.worlds.bench.fault import Fault, of_part
from emg2vsa.worlds.far_ends.dynamixel.motor import RATED_V, MotorFaults

_of_motor = partial(of_part, "firmware.motor.faults")


def _freeze(bench: Any, on: float) -> None:
    bench.firmware.motor.freeze(bool(on))


def _hardware(bit: int) -> Callable[[Any, float], None]:
    def strike(bench: Any, on: float) -> None:
        faults: MotorFaults = bench.firmware.motor.faults
        faults.hardware_error = faults.hardware_error | bit if on else faults.hardware_error & ~bit

    return strike


_COOL_C = MotorFaults().temperature_c
MOTOR_FAULTS = {
    "jam": Fault("the motor does not move, whatever it pulls", _of_motor("jammed"), "switch"),
    "brown-out": Fault("the supply breaks down, the electronics live on", _of_motor("unsupplied"), "switch"),
    "weak": Fault(
        "the motor does no more than N N m",
        _of_motor("torque_nm", lambda torque_nm: torque_nm if math.isfinite(torque_nm) else None),
        "amount", 0.1, math.inf, 0,
    ),
    "frozen-shaft": Fault("the encoder stays as it is", _freeze, "switch"),
    "jumped-shaft": Fault(
        "the encoder reads N degrees more", _of_motor("jumped_deg", float), "amount", 90, 0, -360, 360
    ),
    "current": Fault("the current reads N mA more", _of_motor("current_ma", float), "amount", 2000, 0, -2e4, 2e4),
    "flag-only": Fault("an expired watchdog says so, and the motor goes on", _of_motor("flag_only"), "switch"),
    "no-watchdog": Fault("a watchdog that is set is acknowledged and forgotten", _of_motor("deaf_watchdog"), "switch"),
    "hot": Fault("the motor has N degrees C", _of_motor("temperature_c", float), "amount", 90, _COOL_C, -20, 125),
    "supply": Fault("the supply has N V", _of_motor("supply_v", float), "amount", 17, RATED_V, 5, 30),
    "overload": Fault("the motor says that it is overloaded", _hardware(0x20), "switch"),
    "shock": Fault("the motor says that its electronics had a shock", _hardware(0x10), "switch"),
    "broken-encoder": Fault("the motor says that its encoder is broken", _hardware(0x08), "switch"),
}  # fmt: skip
"""By the name that is typed. ``bench.firmware`` is a `DynamixelFirmware`."""
