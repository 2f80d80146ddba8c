"""The 1 kHz loop of a Dynamixel against a clock: goals, watchdog, protection, motor and world, turn by turn.

The world is asked in every turn while the shaft moves or bears a load, as a load may grow steeply with the angle.
"""

from __future__ import annotations

from collections import deque

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.control import Control
from emg2vsa.worlds.far_ends.dynamixel.models import CURRENT_UNIT_A, PULSES_PER_RAD, PULSES_PER_TURN
from emg2vsa.worlds.far_ends.dynamixel.motor import STEP_S, Motor
from emg2vsa.worlds.far_ends.qbmove.loop import Loads, Shaft

_VOLTAGE, _HEAT, _OVERLOAD = 0x01, 0x04, 0x20
"""Bits of Hardware Error Status and of Shutdown."""
_FULL = 0.95
"""Of the stall current: what counts as overload (guess) ..."""
_OVERLOADED_MS = 1000
"""... after such a time (guess)."""
_NEVER_MS = 1 << 62


class Loop:
    """Runs one motor by the values of its table. ``latency_s``: from a goal or gain that is written until the motor
    knows of it."""

    def __init__(
        self, table: t.ControlTable, motor: Motor, shaft: Shaft, loads: Loads, clock: Clock, latency_s: float
    ) -> None:
        self._table, self._shaft, self._loads, self._clock = table, shaft, loads, clock
        self.motor, self.control = motor, Control()
        self._now_ms = int(clock.now_s() * 1000)
        self._latency_ms = round(latency_s * 1000)
        self._coming: deque[tuple[int, dict[int, int]]] = deque()
        self._acting = dict(table.values)
        self._heard_ms = self._full_ms = self._whole = 0
        self._meet_world()
        self.restart()

    def restart(self) -> None:
        """Power comes back: RAM is at its defaults, the encoder knows its place within a turn."""
        self._shut_down, self.control.halted, self._full_ms = False, False, 0
        self._coming.clear()
        self.forget_turns()
        values = self._table.values
        values[t.GOAL_PWM], values[t.GOAL_CURRENT] = values[t.PWM_LIMIT], values[t.CURRENT_LIMIT]
        values[t.GOAL_POSITION] = self.position()
        self._acting.update(values)
        self.control.restart(self.position())
        if values[t.STARTUP] & 1:
            self.switch_on()

    def forget_turns(self) -> None:
        """Present Position is within one turn again, but for the homing offset."""
        self._whole = self._sign * self.motor.pulses() // PULSES_PER_TURN * PULSES_PER_TURN

    def position(self) -> int:
        """Present Position. A homing offset beyond 1024 does nothing in Position Control Mode."""
        values = self._table.values
        offset = values[t.HOMING_OFFSET]
        if values[t.OPERATING_MODE] == t.POSITION and abs(offset) > 1024:
            offset = 0
        return self._sign * self.motor.pulses() - self._whole + offset

    def heard(self) -> None:
        """An instruction came."""
        self._heard_ms = self._now_ms

    def switch_on(self) -> bool:
        """Torque on; False after a shutdown, which only a reboot ends. What has been commanded holds."""
        if self._shut_down:
            return False
        values = self._table.values
        if values[t.TORQUE_ENABLE]:
            return True
        values[t.TORQUE_ENABLE] = 1
        if values[t.OPERATING_MODE] == t.POSITION:
            self.forget_turns()
        self._coming.clear()
        self._acting.update(values)
        self.control.restart(self.position())
        return True

    def change(self, changes: dict[int, int]) -> None:
        """Goals, gains or settings have been written."""
        self._coming.append((self._now_ms + self._latency_ms, changes))
        self._take_over()

    def advance(self) -> None:
        """Run up to the clock."""
        until_ms = int(self._clock.now_s() * 1000 + 1e-6)
        while self._now_ms < until_ms:
            self._watch()
            self._take_over()
            rests = self._turn()
            self._now_ms += 1
            if rests:
                next_ms = min(self._expires_ms, self._coming[0][0] if self._coming else _NEVER_MS)
                self._now_ms = max(self._now_ms, min(until_ms, next_ms))
            self._meet_world()

    @property
    def _sign(self) -> int:
        return -1 if self._table.values[t.DRIVE_MODE] & t.REVERSE else 1

    def _rate(self) -> float:
        """Speed of the shaft, pulses in a millisecond, as the table has it."""
        return self._sign * self.motor.seen_rad_per_s() * PULSES_PER_RAD * STEP_S

    def measured(self) -> dict[int, int]:
        """What the table says of the motor now."""
        motor, control, sign = self.motor, self.control, self._sign
        unit = t.VELOCITY_UNIT_RAD_PER_S
        velocity = round(sign * motor.seen_rad_per_s() / unit)
        moving = abs(velocity) > self._table.values[t.MOVING_THRESHOLD] or not control.arrived
        position = self.position()
        near = abs(control.trajectory - position) < 10  # which deviation is small is a guess
        status = control.shape << 4 | (not control.arrived) << 1 | (near and control.arrived)
        current_a = sign * motor.current_a + motor.faults.current_ma / 1000
        return {
            t.REALTIME_TICK: self._now_ms % 32768,
            t.MOVING: int(moving),
            t.MOVING_STATUS: status,
            t.PRESENT_PWM: round(sign * motor.duty * t.PWM_MOST),
            t.PRESENT_CURRENT: round(current_a / CURRENT_UNIT_A),
            t.PRESENT_VELOCITY: velocity,
            t.PRESENT_POSITION: position,
            t.VELOCITY_TRAJECTORY: round(control.rate / PULSES_PER_RAD / STEP_S / unit),
            t.POSITION_TRAJECTORY: round(control.trajectory),
            t.PRESENT_VOLTAGE: round(motor.volts * 10),
            t.PRESENT_TEMPERATURE: round(motor.faults.temperature_c),
        }

    def protect(self) -> None:
        """Errors of the hardware stay until a reboot; those of the Shutdown mask switch off."""
        values, motor = self._table.values, self.motor
        bits = motor.faults.hardware_error
        if not values[t.MIN_VOLTAGE] <= motor.volts * 10 <= values[t.MAX_VOLTAGE]:
            bits |= _VOLTAGE
        if motor.faults.temperature_c > values[t.TEMPERATURE_LIMIT]:
            bits |= _HEAT
        if self._full_ms >= _OVERLOADED_MS:
            bits |= _OVERLOAD
        values[t.HARDWARE_ERROR] |= bits
        if bits & values[t.SHUTDOWN]:
            self._shut_down = True
            values[t.TORQUE_ENABLE] = 0

    def _watch(self) -> None:
        if self._now_ms < self._expires_ms:
            return
        self._table.values[t.BUS_WATCHDOG] = t.WATCHDOG_ERROR
        if not self.motor.faults.flag_only:
            self._coming.clear()
            self.control.halt(self.position())

    @property
    def _expires_ms(self) -> int:
        values = self._table.values
        watched = values[t.TORQUE_ENABLE] and 0 < values[t.BUS_WATCHDOG] < t.WATCHDOG_ERROR
        return self._heard_ms + values[t.BUS_WATCHDOG] * t.WATCHDOG_UNIT_MS if watched else _NEVER_MS

    def _take_over(self) -> None:
        while self._coming and self._coming[0][0] <= self._now_ms:
            changes = self._coming.popleft()[1]
            self._acting.update(changes)
            if t.GOAL_OF_MODE[self._table.values[t.OPERATING_MODE]] in changes:
                self.control.halted = False

    def _turn(self) -> bool:
        """One millisecond; True when more of them would change nothing."""
        self.protect()
        motor, acting, control = self.motor, self._acting, self.control
        on = bool(self._table.values[t.TORQUE_ENABLE])
        wanted_a, duty = None, 0.0
        if on:
            current, pwm = control.output(acting, self.position(), self._rate())
            wanted_a = None if current is None else self._sign * current * CURRENT_UNIT_A
            duty = self._sign * pwm / t.PWM_MOST
        else:
            control.restart(self.position())
        stands = motor.step(on, wanted_a, duty, acting[t.PWM_LIMIT] / t.PWM_MOST)
        full = abs(motor.current_a) >= _FULL * motor.model.stall_current_a
        self._full_ms = self._full_ms + 1 if full else 0
        steady = not on or (control.arrived and not self._full_ms and not acting[t.POSITION_I])
        return stands and steady and (not on or not motor.load_nm) and acting[t.OPERATING_MODE] != t.VELOCITY

    def _meet_world(self) -> None:
        angles_rad = self.motor.angle_rad, 0.0
        self._shaft.shaft_rad(self._now_ms / 1000, angles_rad)
        self.motor.load_nm = self._loads(angles_rad)[0]
