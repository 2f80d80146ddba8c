"""A Dynamixel of the X series, to the byte, as the ROBOTIS e-Manual describes it. The firmware is not public.

It is alone on its bus, and answers a packet after its Return Delay Time on the clock. Bytes take no time on the bus,
and the baud rate is not emulated. Guesses, as the e-Manual is silent: a boot takes 0.3 s, in which nothing is heard;
after it the goal is where the shaft is; torque on keeps the goal that was written before, so the shaft goes there; a
change of the operating mode puts the goal where the shaft is; only instructions for a motor, or for all, feed its
watchdog.
"""

from __future__ import annotations

import math
from collections import deque

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.actuator_end import Loads, Shaft, no_loads
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.motor import Loop, Motor
from emg2vsa.worlds.far_ends.dynamixel.packets import (
    ALERT,
    BROADCAST_ID,
    Error,
    Instruction,
    Packet,
    PacketParser,
    packet,
)

BOOT_S = 0.3
_RETURN_DELAY_S = 2e-6
_ROUNDING_S = 1e-9


class DynamixelFirmware:
    """One motor. A reset keeps EEPROM and forgets RAM.

    Answers come after the Return Delay Time, 0.5 ms from the factory: `due_s` tells when, and a call without bytes
    fetches them."""

    def __init__(
        self,
        model: t.DynamixelModel,
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
        self._parser = PacketParser()
        self._coming: deque[tuple[float, bytes]] = deque()
        self._listens_from_s = clock.now_s()

    def __call__(self, data: bytes) -> bytes:
        """Hear ``data`` at the clock's time, and answer as far as answers are due."""
        self.advance()
        now_s = self._clock.now_s()
        for heard in self._parser.feed(data, now_s):
            if now_s < self._listens_from_s:
                continue
            device_id, delay_s = self.table.values[t.DEVICE_ID], self.table.values[t.RETURN_DELAY] * _RETURN_DELAY_S
            if heard.device_id in (device_id, BROADCAST_ID) and (answer := self._answer(heard)):
                at_s = max(now_s, self._coming[-1][0]) if self._coming else now_s
                self._coming.append((at_s + delay_s, packet(device_id, Instruction.STATUS, answer)))
        arrived = b""
        while self._coming and self._coming[0][0] <= now_s + _ROUNDING_S:
            arrived += self._coming.popleft()[1]
        return arrived

    @property
    def due_s(self) -> float:
        """When the next answer comes, s on the clock; inf when none is on its way."""
        return self._coming[0][0] if self._coming else math.inf

    def advance(self) -> None:
        """Run the control loop up to the clock, for those who look at the world and not at the bus."""
        self._loop.advance()

    def reset(self) -> None:
        """Power off and on."""
        self.advance()
        self._coming.clear()
        self.table.reset(lambda address: address >= t.RAM)
        self._listens_from_s = self._clock.now_s() + BOOT_S
        self._loop.restart()

    def angles_rad(self) -> tuple[float, float]:
        """Where the motor is, rad, as its shaft is told."""
        return self.motor.angle_rad, 0.0

    @property
    def motor(self) -> Motor:
        """With its faults."""
        self.advance()
        return self._loop.motor

    def _answer(self, heard: Packet) -> bytes:
        """Error byte and parameters of the status packet; no bytes where there is none. What is for all is answered
        where it is a ping."""
        instruction, parameters, for_all = heard.instruction, heard.parameters, heard.device_id == BROADCAST_ID
        error, data, values = Error.INSTRUCTION, b"", self.table.values
        if not heard.intact:
            error = Error.CRC
        elif instruction == Instruction.STATUS:
            return b""
        else:
            self._loop.heard()
            if instruction == Instruction.PING:
                error, data = Error.NONE, values[t.MODEL_NUMBER].to_bytes(2, "little") + bytes((values[t.FIRMWARE],))
            elif instruction == Instruction.READ and not for_all:
                error, data = self._read(parameters)
            elif instruction == Instruction.WRITE:
                error = self._write(parameters)
        if for_all and not (heard.intact and instruction == Instruction.PING):
            return b""
        return bytes((error | (ALERT if values[t.HARDWARE_ERROR] else 0),)) + data

    def _read(self, parameters: bytes) -> tuple[Error, bytes]:
        if len(parameters) != 4:
            return Error.LENGTH, b""
        self._loop.protect()
        self.table.values.update(self._loop.measured())
        return self.table.read(int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:], "little"))

    def _write(self, parameters: bytes) -> Error:
        if len(parameters) < 3:
            return Error.LENGTH
        return self.write(int.from_bytes(parameters[:2], "little"), parameters[2:])

    def write(self, address: int, data: bytes) -> Error:
        """Write one item, as if a packet had come."""
        error, value = self.table.check(address, data)
        values = self.table.values
        if error or (address == t.BUS_WATCHDOG and self._loop.motor.faults.deaf_watchdog):
            return error
        if address == t.TORQUE_ENABLE and value:
            return Error.NONE if self._loop.switch_on() else Error.RESULT_FAIL
        values[address] = value
        if address == t.OPERATING_MODE:
            self._begin_mode()
        elif address != t.TORQUE_ENABLE:
            self._loop.change({address: value})
        return Error.NONE

    def _begin_mode(self) -> None:
        """Gains, profile and goals are as after a start (e-Manual, Operating Mode)."""
        values = self.table.values
        self.table.reset(lambda address: t.POSITION_D <= address < t.BUS_WATCHDOG)
        values |= {
            t.PROFILE_VELOCITY: 0, t.PROFILE_ACCELERATION: 0, t.GOAL_POSITION: self._loop.position(),
            t.GOAL_PWM: values[t.PWM_LIMIT], t.GOAL_CURRENT: values[t.CURRENT_LIMIT],
        }  # fmt: skip
        self._loop.stand()
        self._loop.change(dict(values))
