"""The control table of the X series with its access rules.

Source: ROBOTIS e-Manual, Control Table of the XM430-W350, XM430-W210, XH430-W210 and XM540-W270 (docs/en/dxl/x of
ROBOTIS-GIT/emanual), with Startup Configuration and Backup Ready of firmware 45.

Guesses, as the e-Manual is silent: bytes between two items read as 0; a packet that writes several items writes all of
them or none; a write that begins within an item is an Access Error. Protocol 1.0 cannot be
chosen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

from emg2vsa.worlds.far_ends.dynamixel.framing import MOST_ID, Error
from emg2vsa.worlds.far_ends.dynamixel.models import DynamixelModel

MODEL_NUMBER, FIRMWARE, DEVICE_ID, BAUD_RATE, RETURN_DELAY, DRIVE_MODE, OPERATING_MODE = 0, 6, 7, 8, 9, 10, 11
HOMING_OFFSET, MOVING_THRESHOLD, TEMPERATURE_LIMIT, MAX_VOLTAGE, MIN_VOLTAGE = 20, 24, 31, 32, 34
PWM_LIMIT, CURRENT_LIMIT, VELOCITY_LIMIT, MAX_POSITION, MIN_POSITION = 36, 38, 44, 48, 52
STARTUP, SHUTDOWN, RAM = 60, 63, 64
TORQUE_ENABLE, STATUS_LEVEL, REGISTERED, HARDWARE_ERROR = 64, 68, 69, 70
VELOCITY_I, VELOCITY_P, POSITION_D, POSITION_I, POSITION_P, BUS_WATCHDOG = 76, 78, 80, 82, 84, 98
GOAL_PWM, GOAL_CURRENT, GOAL_VELOCITY, GOAL_POSITION = 100, 102, 104, 116
PROFILE_ACCELERATION, PROFILE_VELOCITY, REALTIME_TICK, MOVING, MOVING_STATUS = 108, 112, 120, 122, 123
PRESENT_PWM, PRESENT_CURRENT, PRESENT_VELOCITY, PRESENT_POSITION = 124, 126, 128, 132
VELOCITY_TRAJECTORY, POSITION_TRAJECTORY, PRESENT_VOLTAGE, PRESENT_TEMPERATURE = 136, 140, 144, 146
END = 662
GOALS = (GOAL_PWM, GOAL_CURRENT, GOAL_VELOCITY, GOAL_POSITION)
REVERSE, TIME_BASED, TORQUE_ON_BY_GOAL = 0x01, 0x04, 0x08
"""Bits of Drive Mode. Master and slave (0x02, 540 only) are not emulated."""
CURRENT, VELOCITY, POSITION, EXTENDED_POSITION, CURRENT_BASED_POSITION, PWM = 0, 1, 3, 4, 5, 16
"""Operating modes."""
POSITION_MODES = (POSITION, EXTENDED_POSITION, CURRENT_BASED_POSITION)
GOAL_OF_MODE = {CURRENT: GOAL_CURRENT, VELOCITY: GOAL_VELOCITY, PWM: GOAL_PWM} | dict.fromkeys(
    POSITION_MODES, GOAL_POSITION
)
VELOCITY_UNIT_RAD_PER_S = 0.229 * 2 * math.pi / 60
PWM_MOST = 885
WATCHDOG_ERROR = 255
"""What Bus Watchdog reads after it has expired: -1."""
WATCHDOG_UNIT_MS = 20

_INDIRECT = ((168, 224, 28), (578, 634, 28))
"""First Indirect Address, first Indirect Data, how many."""
_INDIRECT_TO = {data + k: (address + 2 * k) for address, data, count in _INDIRECT for k in range(count)}
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
        Item(MODEL_NUMBER, 2, model.number), Item(2, 4), Item(FIRMWARE, 1, model.firmware_version),
        Item(DEVICE_ID, 1, 1, 0, MOST_ID), Item(BAUD_RATE, 1, 1, 0, 7), Item(RETURN_DELAY, 1, 250, 0, 254),
        Item(DRIVE_MODE, 1, 0, 0, 15), Item(OPERATING_MODE, 1, POSITION, 0, PWM), Item(12, 1, 255, 0, 255),
        Item(13, 1, 2, 2, 2), Item(HOMING_OFFSET, 4, 0, -1_044_479, 1_044_479, True),
        Item(MOVING_THRESHOLD, 4, 10, 0, 1023), Item(TEMPERATURE_LIMIT, 1, 80, 0, 100),
        Item(MAX_VOLTAGE, 2, 160, 95, 160), Item(MIN_VOLTAGE, 2, 95, 95, 160),
        Item(PWM_LIMIT, 2, PWM_MOST, 0, PWM_MOST), Item(CURRENT_LIMIT, 2, model.current_limit, 0, model.current_limit),
        Item(VELOCITY_LIMIT, 4, model.velocity_limit, 0, 1023), Item(MAX_POSITION, 4, 4095, 0, 4095),
        Item(MIN_POSITION, 4, 0, 0, 4095), Item(STARTUP, 1, 0, 0, 3), Item(SHUTDOWN, 1, 52, 0, 0x3F),
        Item(TORQUE_ENABLE, 1, 0, 0, 1), Item(65, 1, 0, 0, 1), Item(STATUS_LEVEL, 1, 2, 0, 2), Item(REGISTERED, 1),
        Item(HARDWARE_ERROR, 1), Item(VELOCITY_I, 2, 1920, 0, _GAIN), Item(VELOCITY_P, 2, 100, 0, _GAIN),
        Item(POSITION_D, 2, 0, 0, _GAIN), Item(POSITION_I, 2, 0, 0, _GAIN),
        Item(POSITION_P, 2, model.position_p_gain, 0, _GAIN), Item(88, 2, 0, 0, _GAIN), Item(90, 2, 0, 0, _GAIN),
        Item(BUS_WATCHDOG, 1, 0, 0, 127), Item(GOAL_PWM, 2, 0, -PWM_MOST, PWM_MOST, True),
        Item(GOAL_CURRENT, 2, 0, -model.current_limit, model.current_limit, True),
        Item(GOAL_VELOCITY, 4, 0, -1023, 1023, True), Item(PROFILE_ACCELERATION, 4, 0, 0, 32767),
        Item(PROFILE_VELOCITY, 4, 0, 0, 32767), Item(GOAL_POSITION, 4, 0, -_TURNS, _TURNS, True),
        Item(REALTIME_TICK, 2), Item(MOVING, 1), Item(MOVING_STATUS, 1), Item(PRESENT_PWM, 2, signed=True),
        Item(PRESENT_CURRENT, 2, signed=True), Item(PRESENT_VELOCITY, 4, signed=True),
        Item(PRESENT_POSITION, 4, signed=True), Item(VELOCITY_TRAJECTORY, 4, signed=True),
        Item(POSITION_TRAJECTORY, 4, signed=True), Item(PRESENT_VOLTAGE, 2), Item(PRESENT_TEMPERATURE, 1), Item(147, 1),
    )  # fmt: skip
    for port in range(model.ports):
        yield from (Item(56 + port, 1, 3, 0, 3), Item(152 + 2 * port, 2, 0, 0, 0xFFFF))
    for data, address in _INDIRECT_TO.items():
        yield from (Item(address, 2, data, RAM, END - 1), Item(data, 1, 0, 0, 255))


class ControlTable:
    """Values by address of their item."""

    def __init__(self, model: DynamixelModel) -> None:
        self._items = {item.address: item for item in _items(model)}
        self._owners = {item.address + k: item for item in self._items.values() for k in range(item.size)}
        self.values = {item.address: item.default for item in self._items.values()}

    def reset(self, chosen: Callable[[int], bool]) -> None:
        """Defaults for the items whose address is ``chosen``."""
        for item in self._items.values():
            if chosen(item.address):
                self.values[item.address] = item.default

    def read(self, address: int, size: int) -> tuple[Error, bytes]:
        """Access Error beyond the table, or where none of it is; no bytes then."""
        end = address + size
        if end > END or not any(at in self._owners for at in range(address, end)):
            return Error.ACCESS, b""
        return Error.NONE, bytes(self._byte(self._real(at)) for at in range(address, end))

    def check(self, address: int, data: bytes) -> tuple[Error, dict[int, int]]:
        """What writing would change, by address, or why it is refused."""
        reals = [self._real(at) for at in range(address, address + len(data))]
        changes: dict[int, int] = {}
        at = 0
        while at < len(data):
            item = self._items.get(reals[at])
            if item is None:
                return Error.ACCESS, {}
            end = at + item.size
            if reals[at:end] != list(range(item.address, item.address + item.size)):
                return Error.LENGTH, {}
            value = int.from_bytes(data[at:end], "little", signed=item.signed)
            error = self._refused(item, value)
            if error:
                return error, {}
            changes[item.address] = value
            at = end
        return Error.NONE, changes

    def _real(self, address: int) -> int:
        """Where Indirect Data is in truth."""
        pointer = _INDIRECT_TO.get(address)
        return address if pointer is None else self.values[pointer]

    def _byte(self, address: int) -> int:
        item = self._owners.get(address)
        if item is None:
            return 0
        bits = 8 * item.size
        return (self.values[item.address] & (1 << bits) - 1) >> 8 * (address - item.address) & 0xFF

    def _refused(self, item: Item, value: int) -> Error:
        values, address = self.values, item.address
        if item.least is None or (address < RAM and values[TORQUE_ENABLE]):
            return Error.ACCESS
        if not item.least <= value <= item.most or (address == OPERATING_MODE and value not in GOAL_OF_MODE):
            return Error.RANGE
        expired = values[BUS_WATCHDOG] == WATCHDOG_ERROR
        # that only 0 may be written after an expiry is a guess
        if expired and (address in GOALS or (address == BUS_WATCHDOG and value)):
            return Error.RANGE
        least, most = self._limits(address)
        return Error.NONE if least <= value <= most else Error.LIMIT

    def _limits(self, address: int) -> tuple[float, float]:
        """Of the goals, by other items; position limits are of Position Control Mode alone."""
        values = self.values
        if address == GOAL_POSITION and values[OPERATING_MODE] == POSITION:
            return values[MIN_POSITION], values[MAX_POSITION]
        limit = {GOAL_PWM: PWM_LIMIT, GOAL_CURRENT: CURRENT_LIMIT, GOAL_VELOCITY: VELOCITY_LIMIT}.get(address)
        return (-math.inf, math.inf) if limit is None else (-values[limit], values[limit])
