"""The control table of the X series, as far as it is used, the models, and the errors in words.

Source: ROBOTIS e-Manual, pages of the models and "DYNAMIXEL Protocol 2.0" (emanual.robotis.com, repository
ROBOTIS-GIT/emanual). The zero of the joint is pulse 2048, the middle of a turn, as in the repository
ROBOTIS-GIT/dynamixel_hardware_interface.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from emg2vsa.devices.dynamixel.settings import Model

DEG_PER_PULSE = 360 / 4096
ZERO_PULSE = 2048
LEAST_FIRMWARE = 45
"""Bus Watchdog and Drive Mode came with 38, Startup Configuration and Torque On by Goal Update with 45."""
CURRENT_BASED_POSITION = 5
WATCHDOG_EXPIRED = 255
WATCHDOG_STEP_S = 0.02
VELOCITY_DEG_PER_S = 0.229 * 6
OVERLOAD = 0x20


class Motor(NamedTuple):
    """What differs between the models; tables of control and units of the others are the same."""

    number: int
    "Model Number (0)."
    most_current: int
    "Largest Current Limit (38), in units of ``current_unit_a``."
    nm_per_a: float
    "Stall torque over stall current at 12 V, by the e-Manual's specifications."
    current_unit_a: float = 2.69e-3


MOTORS: dict[Model, Motor] = {
    "xm430-w350": Motor(1020, 1193, 4.1 / 2.3),
    "xm430-w210": Motor(1030, 1193, 3.0 / 2.3),
    "xh430-w350": Motor(1000, 648, 3.4 / 1.3),
    "xh430-w210": Motor(1010, 648, 2.5 / 1.3),
    "xm540-w150": Motor(1130, 2047, 7.3 / 4.4),
    "xm540-w270": Motor(1120, 2047, 10.6 / 4.4),
}


def supposed_nm_per_rad(model: Model, gain: int) -> float:
    """Stiffness at a gain that nobody has measured, for the guards of what measures it, and for nothing else.

    That an error of one pulse times gain / 128 is a current in its unit is a guess."""
    motor = MOTORS[model]
    return motor.nm_per_a * motor.current_unit_a * gain / 128 * 4096 / (2 * math.pi)


class Item(NamedTuple):
    """An item of the control table. range : what a person may set it to. fixed : why it is not set here."""

    address: int
    size: int
    name: str
    range: tuple[int, int] | None = None
    fixed: str = ""

    def value(self, data: bytes) -> int:
        """Of the bytes on the line; what can be negative is two's complement."""
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
