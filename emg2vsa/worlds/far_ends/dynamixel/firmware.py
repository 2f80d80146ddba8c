"""A Dynamixel of the X series, to the byte, as the ROBOTIS e-Manual describes it. The firmware is not public.

Guesses, as the e-Manual is silent: a boot takes 0.3 s, in which nothing is heard; after it the goal is where the shaft
is; torque on keeps the goal that was written before, so the shaft goes there; a change of the operating mode puts the
goal where the shaft is; a change of id is answered under the old one; only instructions for a motor, or for all, feed
its watchdog; an unknown option is a Data Range Error; the shadow id does nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.bus import Bus
from emg2vsa.worlds.far_ends.dynamixel.framing import ALERT, Error, Instruction
from emg2vsa.worlds.far_ends.dynamixel.loop import Loop
from emg2vsa.worlds.far_ends.dynamixel.models import DynamixelModel
from emg2vsa.worlds.far_ends.dynamixel.motor import Motor
from emg2vsa.worlds.far_ends.qbmove.loop import Loads, Shaft, no_loads

BOOT_S = 0.3
_RETURN_DELAY_S = 2e-6
_CLEAR_TURNS = b"\x01\x44\x58\x4c\x22"
_KEPT = {0xFF: (), 0x01: (t.DEVICE_ID,), 0x02: (t.DEVICE_ID, t.BAUD_RATE)}
"""Option of Factory Reset, and what is not reset."""


class DynamixelFirmware:
    """One motor, alone on its bus unless it is given to a `Bus`. A reset keeps EEPROM and forgets RAM.

    Answers come after the Return Delay Time, 0.5 ms from the factory: `due_s` tells when, and a call without bytes
    fetches them."""

    def __init__(
        self,
        model: DynamixelModel,
        shaft: Shaft,
        clock: Clock,
        *,
        motor_id: int = 1,
        home_deg: float = 0.0,
        loads: Loads = no_loads,
        latency_s: float = 0.0,
    ) -> None:
        """``home_deg``: what the encoder reads at the start, where ``shaft`` has its 0. ``loads``: on the motor.
        ``latency_s``: from a goal or gain that is written until the motor knows of it."""
        self._clock = clock
        self.table = t.ControlTable(model)
        self.table.values[t.DEVICE_ID] = motor_id
        self._loop = Loop(self.table, Motor(model, home_deg), shaft, loads, clock, latency_s)
        self._bus = Bus(clock, (self,))
        self._registered: tuple[int, bytes] | None = None
        self._listens_from_s = clock.now_s()

    def __call__(self, data: bytes) -> bytes:
        """Hear ``data`` at the clock's time, and answer as far as answers are due."""
        return self._bus(data)

    @property
    def due_s(self) -> float:
        """When the next answer comes; inf when none is on its way."""
        return self._bus.due_s

    def advance(self) -> None:
        """Run the control loop up to the clock, for those who look at the world and not at the bus."""
        self._loop.advance()

    def reset(self) -> None:
        """Power off and on."""
        self.advance()
        self._boot()

    def angles_rad(self) -> tuple[float, float]:
        """Where the motor is, as its shaft is told."""
        self.advance()
        return self._loop.motor.angle_rad, 0.0

    @property
    def motor(self) -> Motor:
        """With its faults."""
        self.advance()
        return self._loop.motor

    @property
    def device_id(self) -> int:
        return self.table.values[t.DEVICE_ID]

    @property
    def return_delay_s(self) -> float:
        return self.table.values[t.RETURN_DELAY] * _RETURN_DELAY_S

    @property
    def listens(self) -> bool:
        return self._clock.now_s() >= self._listens_from_s

    @property
    def answers_reads(self) -> bool:
        return self.table.values[t.STATUS_LEVEL] >= 1

    def heard(self) -> None:
        self._loop.heard()

    def obey(self, instruction: int, parameters: bytes, broadcast: bool) -> bytes:
        if instruction == Instruction.PING:
            known = self.table.read(t.MODEL_NUMBER, t.FIRMWARE + 1)[1]
            return bytes((self._error(Error.NONE), *known[:2], known[t.FIRMWARE]))
        if instruction == Instruction.READ:
            if broadcast or len(parameters) != 4:
                return self._told(Error.LENGTH)
            error, data = self.read(*(int.from_bytes(parameters[k : k + 2], "little") for k in (0, 2)))
            return bytes((error,)) + data if self.answers_reads else b""
        handlers: dict[int, Callable[[], Error]] = {
            Instruction.WRITE: partial(self._write, parameters),
            Instruction.REG_WRITE: partial(self._register, parameters),
            Instruction.ACTION: self._act,
            Instruction.FACTORY_RESET: partial(self._reset_table, parameters, broadcast),
            Instruction.REBOOT: self._reboot,
            Instruction.CLEAR: partial(self._clear, parameters),
        }
        handler = handlers.get(instruction)
        # what is written may change the level at once
        level = self.table.values[t.STATUS_LEVEL]
        error = handler() if handler else Error.INSTRUCTION
        return bytes((self._error(error),)) if level == 2 else b""

    def spoilt(self) -> bytes:
        return self._told(Error.CRC)

    def read(self, address: int, size: int) -> tuple[int, bytes]:
        self._loop.protect()
        self.table.values.update(self._loop.measured())
        error, data = self.table.read(address, size)
        return self._error(error), data

    def write(self, address: int, data: bytes) -> Error:
        error, changes = self.table.check(address, data)
        return error or self._take(changes)

    def _told(self, error: Error) -> bytes:
        return bytes((self._error(error),)) if self.table.values[t.STATUS_LEVEL] == 2 else b""

    def _error(self, number: Error) -> int:
        return number | (ALERT if self.table.values[t.HARDWARE_ERROR] else 0)

    def _take(self, changes: dict[int, int]) -> Error:
        """Values that may be written."""
        values = self.table.values
        if t.BUS_WATCHDOG in changes and self._loop.motor.faults.deaf_watchdog:
            del changes[t.BUS_WATCHDOG]
        torque = changes.pop(t.TORQUE_ENABLE, None)
        values.update(changes)
        if t.OPERATING_MODE in changes:
            changes |= self._new_mode()
        self._loop.change(changes)
        if torque == 0:
            values[t.TORQUE_ENABLE] = 0
        by_goal = values[t.DRIVE_MODE] & t.TORQUE_ON_BY_GOAL and not changes.keys().isdisjoint(t.GOALS)
        if torque or by_goal:
            return Error.NONE if self._loop.switch_on() else Error.RESULT_FAIL
        return Error.NONE

    def _new_mode(self) -> dict[int, int]:
        """Gains, profile, goals and limits are as after a start (e-Manual, Operating Mode)."""
        values = self.table.values
        self.table.reset(lambda address: t.VELOCITY_I <= address < t.BUS_WATCHDOG)
        if values[t.OPERATING_MODE] == t.POSITION:
            self._loop.forget_turns()
        position = self._loop.position()
        values |= {
            t.PROFILE_VELOCITY: 0, t.PROFILE_ACCELERATION: 0, t.GOAL_VELOCITY: 0, t.GOAL_POSITION: position,
            t.GOAL_PWM: values[t.PWM_LIMIT], t.GOAL_CURRENT: values[t.CURRENT_LIMIT],
        }  # fmt: skip
        self._loop.control.restart(position)
        return dict(values)

    def _write(self, parameters: bytes) -> Error:
        if len(parameters) < 3:
            return Error.LENGTH
        return self.write(int.from_bytes(parameters[:2], "little"), parameters[2:])

    def _register(self, parameters: bytes) -> Error:
        if len(parameters) < 3:
            return Error.LENGTH
        address, data = int.from_bytes(parameters[:2], "little"), parameters[2:]
        error, _ = self.table.check(address, data)
        if not error:
            self._registered, self.table.values[t.REGISTERED] = (address, data), 1
        return error

    def _act(self) -> Error:
        if self._registered is None:
            return Error.INSTRUCTION
        (address, data), self._registered = self._registered, None
        self.table.values[t.REGISTERED] = 0
        return self.write(address, data)

    def _reset_table(self, parameters: bytes, broadcast: bool) -> Error:
        """Not all of all motors at once (firmware 42 on); a reboot follows."""
        option = parameters[0] if len(parameters) == 1 else None
        if option not in _KEPT or (broadcast and option == 0xFF):
            return Error.RANGE
        self.table.reset(lambda address: address not in _KEPT[option])
        return self._reboot()

    def _reboot(self) -> Error:
        """Answered before the device goes."""
        self._boot()
        return Error.NONE

    def _boot(self) -> None:
        self.table.reset(lambda address: address >= t.RAM)
        self._registered = None
        self._listens_from_s = self._clock.now_s() + BOOT_S
        self._loop.restart()

    def _clear(self, parameters: bytes) -> Error:
        if parameters != _CLEAR_TURNS:
            return Error.RANGE
        if self._loop.measured()[t.MOVING]:
            return Error.RESULT_FAIL
        self._loop.forget_turns()
        position = self.table.values[t.GOAL_POSITION] = self._loop.position()
        self._loop.change({t.GOAL_POSITION: position})
        self._loop.control.restart(position)
        return Error.NONE
