"""Faults of the motors and encoders of a qbmove's board, by the name that is typed."""

from __future__ import annotations

import math
from typing import Any

from emg2vsa.worlds.bench.fault import Fault, of_part

_MOTORS = "firmware.motors.faults"


def _encoder(sensor: int, name: str) -> dict[str, Fault]:
    def freeze(bench: Any, on: float) -> None:
        bench.firmware.motors.freeze(sensor, bool(on))

    def jump(bench: Any, ticks: float) -> None:
        bench.firmware.motors.faults.jumped_ticks[sensor] = int(ticks)

    words = f"the encoder of the {name} reads N ticks more"
    return {
        f"frozen-{name}": Fault(f"the encoder of the {name} stays as it is", freeze, "switch"),
        f"jumped-{name}": Fault(words, jump, "amount", 9000, 0, -20000, 20000),
    }


def _torque_nm(torque_nm: float) -> float | None:
    return torque_nm if math.isfinite(torque_nm) else None


MOTOR_FAULTS = {
    "flag-only": Fault("an expired watchdog says off, and the motors stay on", of_part(_MOTORS, "flag_only"), "switch"),
    "jam": Fault("no motor moves, whatever it pulls", of_part(_MOTORS, "jammed"), "switch"),
    "brown-out": Fault("the motors have no supply, the electronics live on", of_part(_MOTORS, "unsupplied"), "switch"),
    "weak": Fault(
        "no motor does more than N N m", of_part(_MOTORS, "torque_nm", _torque_nm), "amount", 0.1, math.inf, 0
    ),
    **_encoder(0, "motor-1"),
    **_encoder(1, "motor-2"),
    **_encoder(2, "shaft"),
    "current": Fault(
        "both currents read N mA more", of_part(_MOTORS, "current_ma", float), "amount", 6000, 0, -2e4, 2e4
    ),
}
