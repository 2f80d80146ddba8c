"""The models of the X series, and their control table with its access rules, as far as the driver uses it.

Source of the table: ROBOTIS e-Manual, Control Table of the XM430-W350, XM430-W210, XH430-W210 and XM540-W270
(docs/en/dxl/x of ROBOTIS-GIT/emanual), with Startup Configuration and Backup Ready of firmware 45.

Guesses, as the e-Manual is silent: bytes between two items read as 0; a write that begins within an item, or goes
beyond one, is an error. Protocol 1.0 cannot be chosen.

Source of the models: ROBOTIS e-Manual, a page a model, its control table and its specifications at 12 V
(_data/dxl_x_info.yml of ROBOTIS-GIT/emanual). Nobody at ROBOTIS publishes inertia and friction. Those of the XM430-W350
are the joint of google-deepmind/mujoco_menagerie, robotis_op3/op3.xml: armature 0.045 kg m2, friction loss 0.03 N m,
damping 1.084 N m s/rad. Of that damping the voltage behind the motor makes 0.85, its stall torque over its speed
without load; the rest is the gear's. All of the other models is a guess: the same rotor behind another gear, a rotor of
three times the inertia in the 540.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from emg2vsa.worlds.far_ends.dynamixel.packets import MOST_ID, Error

PULSES_PER_TURN = 4096
PULSES_PER_RAD = PULSES_PER_TURN / (2 * math.pi)
CURRENT_UNIT_A = 2.69e-3
_RAD_PER_S_PER_RPM = 2 * math.pi / 60


@dataclass(frozen=True)
class DynamixelModel:
    """One model. Torque, speed and inertia are of the shaft."""

    name: str
    number: int
    stall_torque_nm: float
    stall_current_a: float
    no_load_rad_per_s: float
    inertia_kg_m2: float
    current_limit: int = 1193
    "Default and greatest Current Limit, units of 2.69 mA."
    velocity_limit: int = 200
    position_p_gain: int = 800
    friction_nm: float = 0.03
    viscous_nm_s: float = 0.2
    firmware_version: int = 45

    @property
    def torque_constant_nm_per_a(self) -> float:
        """Stall torque over stall current, N m/A, as nothing else is published; the friction of the gear is in it."""
        return self.stall_torque_nm / self.stall_current_a

    def stiffness_nm_per_rad(self, position_p_gain: float) -> float:
        """Torque over deflection in Current-based Position Control Mode, below the goal current.

        That a position error of one pulse times gain / 128 (e-Manual, Position PID Gain) is a current in units of
        2.69 mA is a guess. It agrees with the position mode of the op3, 21 N m/rad at a gain of 800."""
        return self.torque_constant_nm_per_a * CURRENT_UNIT_A * position_p_gain / 128 * PULSES_PER_RAD


XM430_W350 = DynamixelModel("XM430-W350", 1020, 4.1, 2.3, 46 * _RAD_PER_S_PER_RPM, 0.045)
XM430_W210 = DynamixelModel("XM430-W210", 1030, 3.0, 2.3, 77 * _RAD_PER_S_PER_RPM, 0.0163, velocity_limit=330)
XH430_W210 = DynamixelModel(
    "XH430-W210", 1010, 2.5, 1.3, 50 * _RAD_PER_S_PER_RPM, 0.0163, 648, velocity_limit=210, position_p_gain=900
)
XM540_W150 = DynamixelModel(
    "XM540-W150", 1130, 7.3, 4.4, 53 * _RAD_PER_S_PER_RPM, 0.025, 2047, velocity_limit=230, viscous_nm_s=0.5
)
XM540_W270 = DynamixelModel(
    "XM540-W270", 1120, 10.6, 4.4, 30 * _RAD_PER_S_PER_RPM, 0.08, 2047, velocity_limit=128, viscous_nm_s=0.5
)
MODELS = {model.name: model for model in (XM430_W350, XM430_W210, XH430_W210, XM540_W150, XM540_W270)}

MODEL_NUMBER, FIRMWARE, DEVICE_ID, BAUD_RATE, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE = 0, 6, 7, 8, 9, 10, 11
HOMING_OFFSET, TEMPERATURE_LIMIT, MAX_VOLTAGE, MIN_VOLTAGE = 20, 31, 32, 34
PWM_LIMIT, CURRENT_LIMIT, VELOCITY_LIMIT, MAX_POSITION, MIN_POSITION = 36, 38, 44, 48, 52
STARTUP, SHUTDOWN, RAM = 60, 63, 64
TORQUE_ENABLE, LED, STATUS_LEVEL, HARDWARE_ERROR = 64, 65, 68, 70
POSITION_D, POSITION_I, POSITION_P, BUS_WATCHDOG = 80, 82, 84, 98
GOAL_PWM, GOAL_CURRENT, PROFILE_ACCELERATION, PROFILE_VELOCITY, GOAL_POSITION = 100, 102, 108, 112, 116
PRESENT_CURRENT, PRESENT_VELOCITY, PRESENT_POSITION, PRESENT_VOLTAGE, PRESENT_TEMPERATURE = 126, 128, 132, 144, 146
GOALS = (GOAL_PWM, GOAL_CURRENT, GOAL_POSITION)
POSITION, CURRENT_BASED_POSITION = 3, 5
_MODES = (0, 1, POSITION, 4, CURRENT_BASED_POSITION, 16)
PWM_MOST = 885
WATCHDOG_ERROR = 255
"""What Bus Watchdog reads after it has expired: -1."""
WATCHDOG_UNIT_MS = 20
_GAIN = 16383
_TURNS = 1_048_575


class Item(NamedTuple):
    """One item; ``least`` and ``most`` are what it can be written as, None of one that is only read."""

    address: int
    size: int
    default: int = 0
    least: int | None = None
    most: int = 0
    signed: bool = False


def _items(model: DynamixelModel) -> Iterator[Item]:
    yield from (
        Item(MODEL_NUMBER, 2, model.number), Item(FIRMWARE, 1, model.firmware_version),
        Item(DEVICE_ID, 1, 1, 0, MOST_ID), Item(BAUD_RATE, 1, 1, 0, 7), Item(RETURN_DELAY, 1, 250, 0, 254),
        Item(DRIVE_MODE, 1, 0, 0, 15), Item(OPERATING_MODE, 1, POSITION, 0, max(_MODES)), Item(12, 1, 255, 0, 255),
        Item(13, 1, 2, 2, 2), Item(HOMING_OFFSET, 4, 0, -1_044_479, 1_044_479, True),
        Item(TEMPERATURE_LIMIT, 1, 80, 0, 100), Item(MAX_VOLTAGE, 2, 160, 95, 160), Item(MIN_VOLTAGE, 2, 95, 95, 160),
        Item(PWM_LIMIT, 2, PWM_MOST, 0, PWM_MOST), Item(CURRENT_LIMIT, 2, model.current_limit, 0, model.current_limit),
        Item(VELOCITY_LIMIT, 4, model.velocity_limit, 0, 1023), Item(MAX_POSITION, 4, 4095, 0, 4095),
        Item(MIN_POSITION, 4, 0, 0, 4095), Item(STARTUP, 1, 0, 0, 3), Item(SHUTDOWN, 1, 52, 0, 0x3F),
        Item(TORQUE_ENABLE, 1, 0, 0, 1), Item(LED, 1, 0, 0, 1), Item(STATUS_LEVEL, 1, 2, 0, 2), Item(HARDWARE_ERROR, 1),
        Item(POSITION_D, 2, 0, 0, _GAIN), Item(POSITION_I, 2, 0, 0, _GAIN),
        Item(POSITION_P, 2, model.position_p_gain, 0, _GAIN), Item(88, 2, 0, 0, _GAIN), Item(90, 2, 0, 0, _GAIN),
        Item(BUS_WATCHDOG, 1, 0, 0, 127), Item(GOAL_PWM, 2, 0, -PWM_MOST, PWM_MOST, True),
        Item(GOAL_CURRENT, 2, 0, -model.current_limit, model.current_limit, True),
        Item(PROFILE_ACCELERATION, 4, 0, 0, 32767), Item(PROFILE_VELOCITY, 4, 0, 0, 32767),
        Item(GOAL_POSITION, 4, 0, -_TURNS, _TURNS, True), Item(PRESENT_CURRENT, 2, signed=True),
        Item(PRESENT_VELOCITY, 4, signed=True), Item(PRESENT_POSITION, 4, signed=True), Item(PRESENT_VOLTAGE, 2),
        Item(PRESENT_TEMPERATURE, 1),
    )  # fmt: skip


class ControlTable:
    """Values by address of their item."""

    def __init__(self, model: DynamixelModel) -> None:
        self._items = {item.address: item for item in _items(model)}
        self.values = {item.address: item.default for item in self._items.values()}

    def reset(self, chosen: Callable[[int], bool]) -> None:
        """Defaults for the items whose address is ``chosen``."""
        self.values |= {item.address: item.default for item in self._items.values() if chosen(item.address)}

    def read(self, address: int, size: int) -> tuple[Error, bytes]:
        """Access Error where none of it is; no bytes then."""
        data, end = bytearray(), address + size
        for item in self._items.values():  # in the order of their addresses
            if address < item.address + item.size and item.address < end:
                value = (self.values[item.address] & (1 << 8 * item.size) - 1).to_bytes(item.size, "little")
                before = item.address - address - len(data)
                data += bytes(max(0, before)) + value[max(0, -before) :]
        return (Error.NONE, bytes(data[:size].ljust(size, b"\0"))) if data else (Error.ACCESS, b"")

    def check(self, address: int, data: bytes) -> tuple[Error, int]:
        """The value that would be written, or why it is refused."""
        item, values = self._items.get(address), self.values
        if item is None:
            return Error.ACCESS, 0
        if len(data) != item.size:
            return Error.LENGTH, 0
        value = int.from_bytes(data, "little", signed=item.signed)
        if item.least is None or (address < RAM and values[TORQUE_ENABLE]):
            return Error.ACCESS, 0
        if not item.least <= value <= item.most or (address == OPERATING_MODE and value not in _MODES):
            return Error.RANGE, 0
        # that only 0 may be written after an expiry is a guess
        if values[BUS_WATCHDOG] == WATCHDOG_ERROR and (address in GOALS or (address == BUS_WATCHDOG and value)):
            return Error.RANGE, 0
        limit = {GOAL_PWM: PWM_LIMIT, GOAL_CURRENT: CURRENT_LIMIT}.get(address)
        return (Error.LIMIT if limit is not None and abs(value) > values[limit] else Error.NONE), value
