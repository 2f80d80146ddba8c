"""Motor, gear and encoder: current makes torque, torque turns the shaft against load and friction.

The bridge gives a share of the supply (duty). Voltage that the turning motor makes counts against it, so that the
published stall current, stall torque and speed without load are a straight line. With the bridge off no current flows
(guess). A speed is found from the torques where the shaft is, then the angle from that speed (semi-implicit Euler),
which stays stable as long as the stiffest spring at the shaft turns it by less than 2 rad of phase in a step.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.actuator_end import Loads, Shaft
from emg2vsa.worlds.far_ends.dynamixel import table as t
from emg2vsa.worlds.far_ends.dynamixel.table import CURRENT_UNIT_A, PULSES_PER_RAD, PULSES_PER_TURN, DynamixelModel
from emg2vsa.worlds.far_ends.faults import amount, finite, switch

STEP_S = 1e-3
RATED_V = 12.0
UNSUPPLIED_V = 5.0
"""What the electronics still live on while the bridge no longer works (guess)."""
_VOLTAGE, _HEAT, _OVERLOAD = 0x01, 0x04, 0x20
"""Bits of Hardware Error Status and of Shutdown."""
_FULL = 0.95
"""Share of the stall current: what counts as overload (guess) ..."""
_OVERLOADED_MS = 1000
"""... after such a time (guess)."""
_NEVER_MS = 1 << 62
_VELOCITY_UNIT_RAD_PER_S = 0.229 * 2 * math.pi / 60
_RATE = 0.229 * PULSES_PER_TURN / 60_000
"""Pulses in a millisecond, of one unit of velocity."""


@dataclass
class MotorFaults:
    """What goes wrong, changed while the motor runs.

    unsupplied : down to 5 V. hardware_error : bits of Hardware Error Status that have no cause here: 8 encoder, 16
    electrical shock, 32 overload.
    """

    jammed: bool = switch("jam", "the motor does not move, whatever it pulls")
    unsupplied: bool = switch("brown-out", "the supply breaks down, the electronics live on")
    torque_nm: float | None = amount("weak", "the motor does no more than N N m", 0.1, math.inf, 0, made=finite)
    frozen: bool = switch("frozen-shaft", "the encoder stays as it is")
    jumped_deg: float = amount("jumped-shaft", "the encoder reads N degrees more", 90, 0, -360, 360)
    current_ma: float = amount("current", "the current reads N mA more", 2000, 0, -2e4, 2e4)
    flag_only: bool = switch("flag-only", "an expired watchdog says so, and the motor goes on")
    deaf_watchdog: bool = switch("no-watchdog", "a watchdog that is set is acknowledged and forgotten")
    temperature_c: float = amount("hot", "the motor has N degrees C", 90, 35, -20, 125)
    supply_v: float = amount("supply", "the supply has N V", 17, RATED_V, 5, 30)
    hardware_error: int = 0


class Motor:
    """``angle_rad``, ``speed_rad_per_s``, ``current_a``: of the shaft, in the world's direction."""

    def __init__(self, model: DynamixelModel, home_deg: float) -> None:
        """``home_deg``: what the encoder reads with the shaft at 0."""
        self.model, self.faults = model, MotorFaults()
        self._home_rad = math.radians(home_deg)
        self._frozen: int | None = None
        self.angle_rad = self.speed_rad_per_s = self.current_a = self.load_nm = 0.0

    @property
    def volts(self) -> float:
        """Voltage at the motor's plug."""
        return UNSUPPLIED_V if self.faults.unsupplied else self.faults.supply_v

    def pulses(self) -> int:
        """What the encoder has counted; within a turn at a start."""
        pulses = math.floor((self.angle_rad + self._home_rad) * PULSES_PER_RAD + 1e-9)
        if not self.faults.frozen:
            self._frozen = None
        elif self._frozen is None:
            self._frozen = pulses
        jumped = round(self.faults.jumped_deg * PULSES_PER_TURN / 360)
        return (pulses if self._frozen is None else self._frozen) + jumped

    def seen_rad_per_s(self) -> float:
        """Speed, rad/s, as the firmware takes it from the encoder; that it does so without error or delay is a
        guess."""
        return 0.0 if self.faults.frozen else self.speed_rad_per_s

    def step(self, wanted_a: float | None, most_duty: float) -> bool:
        """A step with a wanted current, or with the bridge off where that is None; True when the shaft stands still
        after it. ``most_duty``: of the supply that the model is rated for, at most 1."""
        model, faults = self.model, self.faults
        emf = self.speed_rad_per_s / model.no_load_rad_per_s
        self.current_a = 0.0
        if wanted_a is not None and not faults.unsupplied:
            most_duty *= self.volts / RATED_V
            duty = max(-most_duty, min(most_duty, wanted_a / model.stall_current_a + emf))
            self.current_a = model.stall_current_a * (duty - emf)
        torque_nm = model.torque_constant_nm_per_a * self.current_a
        if faults.torque_nm is not None:
            torque_nm = max(-faults.torque_nm, min(faults.torque_nm, torque_nm))
        per_nm = STEP_S / (model.inertia_kg_m2 + STEP_S * model.viscous_nm_s)
        speed = per_nm * ((torque_nm - self.load_nm) + self.speed_rad_per_s * model.inertia_kg_m2 / STEP_S)
        held = per_nm * model.friction_nm
        speed = 0.0 if abs(speed) <= held or faults.jammed else speed - math.copysign(held, speed)
        self.speed_rad_per_s = speed
        self.angle_rad += speed * STEP_S
        return speed == 0


class Loop:
    """The 1 kHz loop of one motor against a clock: goals, watchdog, protection, motor and world, turn by turn, by the
    values of its table. ``latency_s``: from a goal or gain that is written until the motor knows of it.

    Source: ROBOTIS e-Manual, Position PID Gain, What is the Profile. Every operating mode acts as Current-based
    Position Control, the only one in which the driver switches the torque on, with a profile that is a step or
    rectangular. The integral, both feedforward gains, Profile Acceleration and the bits of Drive Mode are kept and do
    nothing, as the driver sets them to 0. That P and D are per pulse and per pulse in a millisecond, and that they put
    out units of current, is a guess.

    The world is asked in every turn while the shaft moves or bears a load, as a load may grow steeply with the angle.
    """

    def __init__(
        self, table: t.ControlTable, motor: Motor, shaft: Shaft, loads: Loads, clock: Clock, latency_s: float
    ) -> None:
        self._table, self._shaft, self._loads, self._clock = table, shaft, loads, clock
        self.motor = motor
        self._now_ms = int(clock.now_s() * 1000)
        self._latency_ms = round(latency_s * 1000)
        self._coming: deque[tuple[int, dict[int, int]]] = deque()
        self._acting = dict(table.values)
        self._heard_ms = self._full_ms = self._whole = 0
        self._meet_world()
        self.restart()

    def restart(self) -> None:
        """Power comes back: RAM is at its defaults, the encoder knows its place within a turn."""
        self._shut_down, self._full_ms = False, 0
        self._halted = False
        "Stopped by the watchdog: until a goal is written."
        self._coming.clear()
        self._whole = self.motor.pulses() // PULSES_PER_TURN * PULSES_PER_TURN
        values = self._table.values
        values[t.GOAL_PWM], values[t.GOAL_CURRENT] = values[t.PWM_LIMIT], values[t.CURRENT_LIMIT]
        values[t.GOAL_POSITION] = self.position()
        self._acting.update(values)
        self.stand()

    def stand(self) -> None:
        """Begin from a standstill here: the trajectory begins where the shaft is."""
        self._trajectory = self._held = self._aim = float(self.position())
        self._rate = self._most_rate = 0.0

    def position(self) -> int:
        """Present Position. A homing offset beyond 1024 does nothing in Position Control Mode."""
        values = self._table.values
        offset = values[t.HOMING_OFFSET]
        if values[t.OPERATING_MODE] == t.POSITION and abs(offset) > 1024:
            offset = 0
        return self.motor.pulses() - self._whole + offset

    def heard(self) -> None:
        """An instruction came."""
        self._heard_ms = self._now_ms

    def switch_on(self) -> bool:
        """Torque on; False after a shutdown, which only a reboot ends. What has been commanded holds."""
        if self._shut_down:
            return False
        values = self._table.values
        if not values[t.TORQUE_ENABLE]:
            values[t.TORQUE_ENABLE] = 1
            self._coming.clear()
            self._acting.update(values)
            self.stand()
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

    def measured(self) -> dict[int, int]:
        """What the table says of the motor now."""
        motor = self.motor
        return {
            t.PRESENT_CURRENT: round((motor.current_a + motor.faults.current_ma / 1000) / CURRENT_UNIT_A),
            t.PRESENT_VELOCITY: round(motor.seen_rad_per_s() / _VELOCITY_UNIT_RAD_PER_S),
            t.PRESENT_POSITION: self.position(),
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
            self._halted = True
            self.stand()

    @property
    def _expires_ms(self) -> int:
        values = self._table.values
        watched = values[t.TORQUE_ENABLE] and 0 < values[t.BUS_WATCHDOG] < t.WATCHDOG_ERROR
        return self._heard_ms + values[t.BUS_WATCHDOG] * t.WATCHDOG_UNIT_MS if watched else _NEVER_MS

    def _take_over(self) -> None:
        while self._coming and self._coming[0][0] <= self._now_ms:
            changes = self._coming.popleft()[1]
            self._acting.update(changes)
            if t.GOAL_POSITION in changes:
                self._halted = False

    def _turn(self) -> bool:
        """One millisecond; True when more of them would change nothing."""
        self.protect()
        motor, acting = self.motor, self._acting
        on = bool(self._table.values[t.TORQUE_ENABLE])
        wanted_a = None
        if on:
            wanted_a = self._current() * CURRENT_UNIT_A
        else:
            self.stand()
        stands = motor.step(wanted_a, acting[t.PWM_LIMIT] / t.PWM_MOST)
        full = abs(motor.current_a) >= _FULL * motor.model.stall_current_a
        self._full_ms = self._full_ms + 1 if full else 0
        return stands and (not on or (self._trajectory == self._aim and not self._full_ms and not motor.load_nm))

    def _current(self) -> float:
        """Current that pulls the shaft to its trajectory, units of 2.69 mA."""
        acting = self._acting
        self._follow(self._held if self._halted else acting[t.GOAL_POSITION])
        most = min(abs(acting[t.GOAL_CURRENT]), acting[t.CURRENT_LIMIT])
        error = self._trajectory - self.position()
        slowness = self._rate - self.motor.seen_rad_per_s() * PULSES_PER_RAD * STEP_S
        wanted = acting[t.POSITION_P] / 128 * error + acting[t.POSITION_D] / 16 * slowness
        return max(-most, min(most, wanted))

    def _follow(self, goal: float) -> None:
        """The next millisecond of the profile, which is made when the goal changes."""
        if goal != self._aim:
            self._aim, self._most_rate = goal, self._acting[t.PROFILE_VELOCITY] * _RATE
        left = self._aim - self._trajectory
        self._rate = math.copysign(self._most_rate, left)
        self._trajectory += self._rate
        if not self._most_rate or (self._aim - self._trajectory) * left <= 0:
            self._trajectory, self._rate = self._aim, 0.0

    def _meet_world(self) -> None:
        angles_rad = self.motor.angle_rad, 0.0
        self._shaft.shaft_rad(self._now_ms / 1000, angles_rad)
        self.motor.load_nm = self._loads(angles_rad)[0]
