"""The qbmove on the emulated bench, and the rigid motor: motor 1 of a board that speaks as a qbmove does."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from emg2vsa.devices.qbmove.driver import ON, Qbmove
from emg2vsa.devices.qbmove.packets import Command
from emg2vsa.devices.qbmove.springs import SPRINGS
from emg2vsa.devices.qbmove.ticks import to_ticks
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.worlds.far_ends.actuator_end import FarEnd, Place
from emg2vsa.worlds.far_ends.faults import WIRE_FAULTS, Fault, faults_in
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware, QbmoveFrames
from emg2vsa.worlds.far_ends.qbmove.memory import ADVANCED, MAKER_PRO, Switches
from emg2vsa.worlds.far_ends.qbmove.motors import MotorFaults

DEVICE_ID = 1
# with the rate limit of the factory, 0, a saturated move never starts; the one at which motors do move is a guess
_MODELS = {"maker-pro": MAKER_PRO, "advanced": replace(ADVANCED, max_pwm_rate=10)}
MOTOR_SPEED_RAD_PER_S = 3.0
"""Speed of the gearbox's output at full PWM: a guess. The paper names the motor (Maxon DCX8, GPX8 35:1, 12 V)
without it.
"""
MOTOR_TORQUE_NM, MOTOR_CURRENT_MA = 0.3, 1500.0
"""Torque and current at which the rigid motor stalls, 26 N at the probe with the gear of the emulated rig: guesses.
The catalogue's motor could not press with 7 N through that gear, which is a guess too.
"""
MOTOR_BOARD = replace(
    MAKER_PRO,
    supply_mv=12000,
    motor_speed_rad_per_s=MOTOR_SPEED_RAD_PER_S,
    stall_torque_nm=MOTOR_TORQUE_NM,
    stall_current_ma=MOTOR_CURRENT_MA,
)
"""A qbrobotics board with one motor and one AS5045 encoder (paper, section V.A). Which firmware it runs is not
published; it is taken to be the qbmove's, with motor 1 connected and motor 2 not."""


class DirectQbmove(Qbmove):
    """A driver for which what a run sends and asks in every turn goes straight to the ``firmware`` in this process; all
    else goes over the line. What it says is what `Qbmove` says (tests/worlds/bench/test_virtual_run.py)."""

    def __init__(self, *given: Any, firmware: QbmoveFirmware, **named: Any) -> None:
        super().__init__(*given, **named)
        self._firmware = firmware

    def _tell_ticks(self, command: Command, first: int, second: int) -> None:
        self._firmware.tell(command, first, second)

    def _ask_words(self, command: Command, count: int) -> tuple[int, ...]:
        return self._firmware.ask(command)

    def ask_active(self) -> bool:
        """As `Qbmove.ask_active`."""
        return self._firmware.ask_active() == ON


def _model(place: Place) -> str:
    return place.springs.removeprefix("qbmove-")


def _begun(switches: Switches, place: Place, *, motors: int) -> QbmoveFirmware:
    home_ticks = to_ticks(place.rig.home_deg)
    memory = switches.factory((home_ticks, home_ticks if motors == 2 else 0, home_ticks))
    world = place.world
    return QbmoveFirmware(
        switches, world, place.clock, memory=memory, loads=world.loads_nm, latency_s=place.latency_s,
        serial_number=place.serial_number,
    )  # fmt: skip


def _driver(line: ByteLine, firmware: Any, place: Place, exact: bool, *, rigid: bool = False) -> Qbmove:
    named: dict[str, Any] = {
        "model": "maker-pro" if rigid else _model(place), "rigid": rigid,
        "clock": place.clock, "stiffness_percent": place.rig.stiffness_percent,
    }  # fmt: skip
    if exact:
        return Qbmove(line, DEVICE_ID, **named)
    return DirectQbmove(line, DEVICE_ID, firmware=firmware, **named)


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


_ENCODERS = _encoder(0, "motor-1") | _encoder(1, "motor-2") | _encoder(2, "shaft")
_FAULTS = WIRE_FAULTS | faults_in("firmware.motors.faults", MotorFaults) | _ENCODERS
_FAULTS["current"] = _FAULTS.pop("current")  # the last in a list
QBMOVE = FarEnd(
    springs=SPRINGS.get,
    device=lambda place: _begun(_MODELS[_model(place)], place, motors=2),
    driver=_driver,
    table=lambda place: {"id": DEVICE_ID, "generation": "v6", "model": _model(place)},
    faults=_FAULTS,
    frames=QbmoveFrames(),
)
RIGID_MOTOR = FarEnd(
    springs=lambda name: None,
    device=lambda place: _begun(MOTOR_BOARD, place, motors=1),
    driver=partial(_driver, rigid=True),
    table=lambda place: {"id": DEVICE_ID, "generation": "v6"},
    faults=_FAULTS,
    frames=QbmoveFrames(),
)
