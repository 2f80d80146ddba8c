"""The control table of the X series, as far as it is used, the models, and the errors in words; what a motor says of
itself, and whether a run may use it. A run checks EEPROM values and never changes them.

Source: ROBOTIS e-Manual, pages of the models and "DYNAMIXEL Protocol 2.0" (emanual.robotis.com, repository
ROBOTIS-GIT/emanual). The zero of the joint is pulse 2048, the middle of a turn, as in the repository
ROBOTIS-GIT/dynamixel_hardware_interface.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

from emg2vsa.devices.dynamixel import DynamixelSettings, Model
from emg2vsa.errors import DeviceError

DEG_PER_PULSE = 360 / 4096
ZERO_PULSE = 2048
LEAST_FIRMWARE = 45
"""Bus Watchdog and Drive Mode came with 38, Startup Configuration and Torque On by Goal Update with 45."""
CURRENT_BASED_POSITION = 5
WATCHDOG_EXPIRED = 255
WATCHDOG_STEP_S = 0.02
VELOCITY_DEG_PER_S = 0.229 * 6
CURRENT_UNIT_A = 2.69e-3
OVERLOAD = 0x20


class Motor(NamedTuple):
    """What differs between the models; tables of control and units of the others are the same."""

    number: int
    "Model Number (0)."
    nm_per_a: float
    "Stall torque over stall current at 12 V, by the e-Manual's specifications."


MOTORS: dict[Model, Motor] = {
    "xm430-w350": Motor(1020, 4.1 / 2.3),
    "xm430-w210": Motor(1030, 3.0 / 2.3),
    "xh430-w350": Motor(1000, 3.4 / 1.3),
    "xh430-w210": Motor(1010, 2.5 / 1.3),
    "xm540-w150": Motor(1130, 7.3 / 4.4),
    "xm540-w270": Motor(1120, 10.6 / 4.4),
}


def model_named(number: int) -> str | None:
    """The model with this Model Number; None for one that the driver does not know."""
    return next((name for name, motor in MOTORS.items() if motor.number == number), None)


def supposed_nm_per_rad(model: Model, gain: int) -> float:
    """Stiffness, N m/rad, at a gain that nobody has measured, for the guards of what measures it, and for nothing else.

    That an error of one pulse times gain / 128 is a current in its unit, A, is a guess.
    """
    return MOTORS[model].nm_per_a * CURRENT_UNIT_A * gain / 128 * 4096 / (2 * math.pi)


class Item(NamedTuple):
    """An item of the control table. range : what a person may set it to. fixed : why it is not set here."""

    address: int
    size: int
    name: str
    range: tuple[int, int] | None = None
    fixed: str = ""

    def value(self, data: bytes) -> int:
        """Value of the bytes on the line; what can be negative is two's complement."""
        return int.from_bytes(data, "little", signed=self in SIGNED)

    def data(self, value: int) -> bytes:
        """The bytes on the line."""
        return value.to_bytes(self.size, "little", signed=value < 0)


_LOST = "the motor would no longer answer to the rig file; use DYNAMIXEL Wizard"
MODEL_NUMBER, FIRMWARE = Item(0, 2, "Model Number"), Item(6, 1, "Firmware Version")
ID = Item(7, 1, "ID", fixed=_LOST)
BAUD_RATE = Item(8, 1, "Baud Rate", fixed=_LOST)
RETURN_DELAY = Item(9, 1, "Return Delay Time", (0, 254))
DRIVE_MODE = Item(10, 1, "Drive Mode", (0, 15))
OPERATING_MODE = Item(11, 1, "Operating Mode", (0, 16))
SECONDARY_ID = Item(12, 1, "Secondary ID", (0, 255))
PROTOCOL = Item(13, 1, "Protocol Type", fixed=_LOST)
HOMING_OFFSET = Item(20, 4, "Homing Offset", (-ZERO_PULSE, ZERO_PULSE))
TEMPERATURE_LIMIT = Item(31, 1, "Temperature Limit", (0, 100))
MAX_VOLTAGE, MIN_VOLTAGE = Item(32, 2, "Max Voltage Limit", (95, 160)), Item(34, 2, "Min Voltage Limit", (95, 160))
PWM_LIMIT, CURRENT_LIMIT = Item(36, 2, "PWM Limit", (0, 885)), Item(38, 2, "Current Limit", (0, 2047))
VELOCITY_LIMIT = Item(44, 4, "Velocity Limit", (0, 1023))
MAX_POSITION, MIN_POSITION = Item(48, 4, "Max Position Limit", (0, 4095)), Item(52, 4, "Min Position Limit", (0, 4095))
STARTUP, SHUTDOWN = Item(60, 1, "Startup Configuration", (0, 3)), Item(63, 1, "Shutdown", (0, 0x3D))
EEPROM = (
    ID, BAUD_RATE, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE, SECONDARY_ID, PROTOCOL, HOMING_OFFSET, TEMPERATURE_LIMIT,
    MAX_VOLTAGE, MIN_VOLTAGE, PWM_LIMIT, CURRENT_LIMIT, VELOCITY_LIMIT, MAX_POSITION, MIN_POSITION, STARTUP, SHUTDOWN,
)  # fmt: skip
"""What keeps its value without power, and can be set with the torque off."""

TORQUE, HARDWARE_ERROR = Item(64, 1, "Torque Enable"), Item(70, 1, "Hardware Error Status")
STATUS_RETURN = Item(68, 1, "Status Return Level")
D_GAIN, I_GAIN, P_GAIN = Item(80, 2, "Position D Gain"), Item(82, 2, "Position I Gain"), Item(84, 2, "Position P Gain")
FEEDFORWARD_2, FEEDFORWARD_1 = Item(88, 2, "Feedforward 2nd Gain"), Item(90, 2, "Feedforward 1st Gain")
WATCHDOG = Item(98, 1, "Bus Watchdog")
GOAL_PWM, GOAL_CURRENT = Item(100, 2, "Goal PWM"), Item(102, 2, "Goal Current")
PROFILE_ACCELERATION, PROFILE_VELOCITY = Item(108, 4, "Profile Acceleration"), Item(112, 4, "Profile Velocity")
GOAL_POSITION = Item(116, 4, "Goal Position")
PRESENT = Item(126, 10, "Present Current, Velocity and Position")
"""Three neighbours: 2 bytes at 126, 4 at 128, 4 at 132; units as of Current Limit, 0.229 rpm, pulses."""
PRESENT_POSITION = Item(132, 4, "Present Position")
VOLTAGE, TEMPERATURE = Item(144, 2, "Present Input Voltage"), Item(146, 1, "Present Temperature")
SIGNED = frozenset((HOMING_OFFSET, GOAL_PWM, GOAL_CURRENT, GOAL_POSITION, PRESENT_POSITION))

ALERT = 0x80
CRC_ERROR, DATA_RANGE_ERROR, DATA_LIMIT_ERROR = 3, 4, 6
ERRORS = {
    1: "that it failed",
    2: "that it does not know the instruction",
    CRC_ERROR: "a wrong checksum",
    DATA_RANGE_ERROR: "a value outside its range",
    5: "a wrong length",
    DATA_LIMIT_ERROR: "a value outside its limits",
    7: "that it cannot be written or read now",
}
"""Error numbers of a status packet."""
_SUPPLY = "Check the supply: 10 to 14.8 V, enough current."
_FAULTS = {
    0x01: ("input voltage", _SUPPLY),
    0x04: ("overheating", "Let it cool, and press less or more seldom."),
    0x08: ("motor encoder", "Have the motor repaired."),
    0x10: ("electrical shock", _SUPPLY),
    OVERLOAD: ("overload", "Take the load off, and see what held the shaft."),
}
"""Bits of Hardware Error Status (70)."""


def fault_words(status: int) -> tuple[str, str]:
    """What the bits of Hardware Error Status say, and what to do."""
    faults = [fault for bit, fault in _FAULTS.items() if status & bit] or [(f"status 0x{status:02x}", _SUPPLY)]
    steps = dict.fromkeys(step for _, step in faults)
    return ", ".join(name for name, _ in faults), f"{' '.join(steps)} Then reboot it: power off and on."


def _told(item: Item, to: Callable[[int], float] = int, *, new: bool = False) -> Any:
    """By an item; ``to`` : what its number becomes. new : older firmware lacks it, and refuses to tell it."""
    return field(metadata={"item": item, "to": to, "new": new})


@dataclass(frozen=True)
class DynamixelInfo:
    """Values that a run depends on, as the motor has them."""

    model_number: int = _told(MODEL_NUMBER)
    firmware: int = _told(FIRMWARE)
    device_id: int = _told(ID)
    protocol: int = _told(PROTOCOL)
    operating_mode: int = _told(OPERATING_MODE)
    drive_mode: int = _told(DRIVE_MODE, new=True)
    "Bits: 1 reverse, 2 slave, 4 time-based profile, 8 torque on by a goal."
    homing_pulses: int = _told(HOMING_OFFSET)
    "Added to the encoder; 4096 to a turn."
    limits_pulses: tuple[int, int] = _told(MIN_POSITION)
    "Lowest and highest position; the motor itself keeps them only in position control, not in the mode of a run."
    pwm_limit: int = _told(PWM_LIMIT)
    "Limit of the PWM, of 885."
    current_limit_a: float = _told(CURRENT_LIMIT, lambda number: number * CURRENT_UNIT_A)
    startup: int = _told(STARTUP, new=True)
    shutdown: int = _told(SHUTDOWN)
    "Hardware errors that switch the torque off, as bits."
    status_return: int = _told(STATUS_RETURN)
    hardware_error: int = _told(HARDWARE_ERROR)
    p_gain: int = _told(P_GAIN)
    i_gain: int = _told(I_GAIN)
    d_gain: int = _told(D_GAIN)
    voltage_v: float = _told(VOLTAGE, lambda number: number / 10)
    temperature_c: int = _told(TEMPERATURE)

    def limits_deg(self) -> tuple[float, float]:
        """The position limits as angles of the joint, degrees, whose zero is the middle of a turn."""
        low, high = ((pulses - ZERO_PULSE) * DEG_PER_PULSE for pulses in self.limits_pulses)
        return low, high


def read_info(get: Callable[[Item], int], where: str) -> DynamixelInfo:
    """What a motor says of itself; ``get`` : asks it. DeviceError for a model that the driver does not know."""
    told: dict[str, Any] = {}
    for each in fields(DynamixelInfo):
        asked = not each.metadata["new"] or told["firmware"] >= LEAST_FIRMWARE
        told[each.name] = each.metadata["to"](get(each.metadata["item"])) if asked else 0
        if each.name == "limits_pulses":
            told[each.name] = told[each.name], get(MAX_POSITION)
        if each.name == "firmware" and model_named(told["model_number"]) is None:
            wanted, found = f"one of {', '.join(MOTORS)}", f"model number {told['model_number']}"
            raise DeviceError(where, wanted=wanted, found=found, do="Check port and id.")
    return DynamixelInfo(**told)


def check_model(info: DynamixelInfo, settings: DynamixelSettings, where: str) -> None:
    """DeviceError for another model than the rig file names: the same gain is another stiffness on it."""
    number = MOTORS[settings.model].number
    if info.model_number != number:
        do = "Correct [actuator] model, and measure the stiffness of this motor."
        wanted = f"{number}, the {settings.model}"
        raise DeviceError(f"{where}, model number", wanted=wanted, found=str(info.model_number), do=do)


def check_ready(info: DynamixelInfo, settings: DynamixelSettings, where: str) -> None:
    """DeviceError at the first value with which a run would not do what it is told."""
    low, high = info.limits_pulses
    check_model(info, settings, where)
    goal_a = settings.goal_current_a
    set_it = "Set it: emg2vsa rig parameters RIG"
    rules = (
        ("firmware", f"{LEAST_FIRMWARE} or newer", info.firmware, info.firmware >= LEAST_FIRMWARE,
         "Update it with DYNAMIXEL Wizard: older ones lack what protects a run."),
        ("id", settings.id, info.device_id, info.device_id == settings.id,
         "It answers to a Secondary ID (12); give the rig file its own id."),
        ("protocol type", 2, info.protocol, info.protocol == 2, "Set Protocol Type (13) with DYNAMIXEL Wizard."),
        ("operating mode", f"{CURRENT_BASED_POSITION}, current-based position control", info.operating_mode,
         info.operating_mode == CURRENT_BASED_POSITION, f"{set_it} --set 11=5."),
        ("drive mode", "0: not reversed, no slave, no time-based profile, no torque by a goal", info.drive_mode,
         info.drive_mode == 0, f"{set_it} --set 10=0."),
        ("homing offset", f"-{ZERO_PULSE} to {ZERO_PULSE} pulses, half a turn", info.homing_pulses,
         abs(info.homing_pulses) <= ZERO_PULSE, "Run emg2vsa rig zero."),
        ("position limits", "two pulses of 0 to 4095, the lower below the higher", f"{low} and {high}",
         0 <= low < high <= 4095, "Set parameters 52 and 48: emg2vsa rig parameters RIG --set 52=0."),
        ("current limit", f"at least goal_current_a, {goal_a:g} A", f"{info.current_limit_a:.3f} A",
         info.current_limit_a >= goal_a, "Lower [actuator] goal_current_a, or raise parameter 38."),
        ("shutdown", f"overload among the errors that switch the torque off, bit 0x{OVERLOAD:02x}",
         f"0x{info.shutdown:02x}", bool(info.shutdown & OVERLOAD), f"{set_it} --set 63=52, as it leaves the factory."),
        ("startup configuration", "0: torque off and no stored values at power-on", info.startup, info.startup == 0,
         f"{set_it} --set 60=0."),
        ("status return level", "2, an answer to everything", info.status_return, info.status_return == 2,
         "Reboot it: power off and on."),
    )  # fmt: skip
    for name, wanted, found, good, do in rules:
        if not good:
            raise DeviceError(f"{where}, {name}", wanted=str(wanted), found=str(found), do=do)
    if info.hardware_error:
        found, do = fault_words(info.hardware_error)
        raise DeviceError(f"{where}, hardware error", wanted="none", found=found, do=do)
