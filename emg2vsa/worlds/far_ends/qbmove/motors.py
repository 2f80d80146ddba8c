"""The two motors of a qbmove, their encoders and the 1 kHz loop that moves them: ``motor_control`` (v6.1), simplified.

PWM is computed as the firmware does in position mode, without the integral, whose gain is 0. A motor's speed is
proportional to it at once, and does not give way to load, until the load reaches what the motor can do: there it
stalls. Current follows the load. Without PWM the gears hold. In the other control modes the motors stand still, and the
input mode in which the shaft drives them does nothing: no run is allowed either.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from emg2vsa.devices.clock import Clock
from emg2vsa.worlds.far_ends.actuator_end import Loads, Shaft, Torques
from emg2vsa.worlds.far_ends.faults import amount, finite, switch
from emg2vsa.worlds.far_ends.qbmove.memory import INTERNAL_PER_TICK, Memory, Switches

INTERNAL_PER_TURN = 65536
INTERNAL_PER_RAD = INTERNAL_PER_TURN / (2 * math.pi)
ENCODER_STEP = 16
"""AS5045, 12 bit: 8 wire ticks."""
PWM_MOST = 100
IDLE_CURRENT_MA = 150
"""Current at full PWM without load: a guess."""
_POSITION_MODE = 0
_SHAFT = 2
_WITHOUT_RATE = 13
"""Parameters of a firmware that knows no greatest PWM rate."""
_STRAINED = 0.5
"""Part of the stall torque from which the load is looked at in every turn."""
_WATCHDOG_MS = [int(counts * 0.04096 * 1000) for counts in range(256)]
"Time of each count of the watchdog; one byte is sent."
_NEVER_MS = 1 << 62

Pair = tuple[int, int]


@dataclass
class MotorFaults:
    """What goes wrong, changed while the motors run. The electronics live on USB.

    frozen : what an encoder goes on reading, internal ticks. jumped_ticks : wire ticks added to what it reads.
    """

    flag_only: bool = switch("flag-only", "an expired watchdog says off, and the motors stay on")
    jammed: bool = switch("jam", "no motor moves, whatever it pulls")
    unsupplied: bool = switch("brown-out", "the motors have no supply, the electronics live on")
    torque_nm: float | None = amount("weak", "no motor does more than N N m", 0.1, math.inf, 0, made=finite)
    frozen: dict[int, int] = field(default_factory=dict)
    jumped_ticks: list[int] = field(default_factory=lambda: [0, 0, 0])
    current_ma: float = amount("current", "both currents read N mA more", 6000, 0, -2e4, 2e4)


class Motors:
    """Positions in internal ticks, in the wire's direction, and what the firmware makes of them."""

    def __init__(self, switches: Switches, angles_rad: Sequence[float]) -> None:
        """``angles_rad``: of motor 1, motor 2 and shaft, at the start."""
        full_step = switches.motor_speed_rad_per_s * INTERNAL_PER_RAD / 1000
        self._steps = {pwm: full_step * pwm / PWM_MOST for pwm in range(-PWM_MOST, PWM_MOST + 1)}
        self._limits_rate = switches.parameters > _WITHOUT_RATE
        # reversed encoders have reversed gains: in the wire's direction they are the same
        self._sign = -1 if switches.counts_backwards else 1
        self._stall_nm, self._stall_ma = switches.stall_torque_nm, switches.stall_current_ma
        self._at = [angle * INTERNAL_PER_RAD for angle in angles_rad]
        self._turns_lost = [0, 0, 0]
        self._seen = [0, 0]
        self.pwm = [0, 0]
        self.faults = MotorFaults()
        self.loads_nm: Torques = (0.0, 0.0)
        "Torque that each motor must do to go on in the direction of its counting."

    @property
    def strained(self) -> bool:
        """Whether a motor may stall soon."""
        first_nm, second_nm = self.loads_nm
        most_nm = _STRAINED * self._most_nm
        return not (-most_nm <= first_nm <= most_nm and -most_nm <= second_nm <= most_nm)

    def freeze(self, sensor: int, frozen: bool) -> None:
        """Encoder 0, 1 or 2, the shaft's, stays where it is, or goes on."""
        if frozen:
            self.faults.frozen.setdefault(sensor, self._raw()[sensor])
        else:
            self.faults.frozen.pop(sensor, None)

    def angles_rad(self) -> tuple[float, float]:
        """Where the motors are, rad."""
        return self._at[0] / INTERNAL_PER_RAD, self._at[1] / INTERNAL_PER_RAD

    def turn_shaft(self, angle_rad: float) -> None:
        """The shaft is where the world has it, rad."""
        self._at[_SHAFT] = angle_rad * INTERNAL_PER_RAD

    def measured(self, memory: Memory) -> tuple[int, int, int]:
        """Encoder readings, internal ticks."""
        raw, jumped, offsets = self._raw(), self.faults.jumped_ticks, memory.offsets
        lost, multipliers = self._turns_lost, memory.multipliers
        first, second, shaft = [
            int((raw[k] + jumped[k] * INTERNAL_PER_TICK + offsets[k] - lost[k] * INTERNAL_PER_TURN) * multipliers[k])
            for k in (0, 1, 2)
        ]
        return first, second, shaft

    def forget_turns(self, memory: Memory) -> None:
        """At a start or new zero: an encoder knows its place only within a turn."""
        self._turns_lost = [0, 0, 0]
        half = INTERNAL_PER_TURN // 2
        self._turns_lost = [(value + half) // INTERNAL_PER_TURN for value in self.measured(memory)]

    def run(self, plan: Sequence[tuple[int, Pair]], memory: Memory, scale: Memory, powered: tuple[bool, bool]) -> None:
        """Milliseconds with the loads as they are.

        plan : numbers of them, and the references that the motors follow. scale : the settings that encoders obey."""
        faults, sign, most_nm, steps, floor = self.faults, self._sign, self._most_nm, self._steps, math.floor
        turns_itself = memory.control_mode == _POSITION_MODE
        stuck, rate = faults.jammed or faults.unsupplied, memory.max_pwm_rate if self._limits_rate else None
        proportional, derivative = sign * memory.position_pid[0], sign * memory.position_pid[2]
        for motor in (0, 1):
            # everything at hand that does not change from turn to turn, as every millisecond of a run comes by here
            shift = faults.jumped_ticks[motor] * INTERNAL_PER_TICK + scale.offsets[motor]
            shift -= self._turns_lost[motor] * INTERNAL_PER_TURN
            multiplier, scaled = scale.multipliers[motor], scale.multipliers[motor] != 1
            on, load_nm, frozen = powered[motor] and turns_itself, self.loads_nm[motor], faults.frozen.get(motor)
            free_up, free_down = load_nm < most_nm and not stuck, -load_nm < most_nm and not stuck
            at, seen, pwm = self._at[motor], self._seen[motor], self.pwm[motor]
            for turns, references in plan:
                reference = references[motor]
                for _ in range(turns):
                    before, pwm_before = seen, pwm
                    seen = (floor(at / ENCODER_STEP) * ENCODER_STEP if frozen is None else frozen) + shift
                    if scaled:
                        seen = int(seen * multiplier)
                    pwm = (proportional * (reference - seen) >> 16) + (derivative * (before - seen) >> 16) if on else 0
                    if not -PWM_MOST < pwm < PWM_MOST:
                        pwm = PWM_MOST if pwm > 0 else -PWM_MOST
                        if rate is not None:
                            # only a saturated move is held back: the compiled firmware does so, not its source
                            pwm = max(pwm_before - rate, min(pwm_before + rate, pwm))
                    if pwm == 0 and pwm_before == 0 and seen == before:
                        break
                    if free_up if pwm >= 0 else free_down:
                        at += steps[pwm]
            self._at[motor], self._seen[motor], self.pwm[motor] = at, seen, pwm

    def currents_ma(self) -> Pair:
        """Motor currents, with the sign of the PWM."""
        return self._current_ma(0), self._current_ma(1)

    def _current_ma(self, motor: int) -> int:
        pwm, faults = self.pwm[motor], self.faults
        if not pwm or faults.unsupplied:
            return int(faults.current_ma)
        way = 1.0 if pwm > 0 else -1.0
        against_nm, stall_ma = way * self.loads_nm[motor], way * self._stall_ma
        current_ma = stall_ma * max(0.0, against_nm) / self._stall_nm + IDLE_CURRENT_MA * pwm / PWM_MOST
        if faults.jammed or against_nm >= self._most_nm:
            current_ma = stall_ma * abs(pwm) / PWM_MOST
        return int(current_ma + faults.current_ma)

    @property
    def _most_nm(self) -> float:
        weak_nm = self.faults.torque_nm
        return self._stall_nm if weak_nm is None else weak_nm

    def _raw(self) -> list[int]:
        """What the three encoders read."""
        floor, (first, second, shaft) = math.floor, self._at
        raw = [
            floor(first / ENCODER_STEP) * ENCODER_STEP,
            floor(second / ENCODER_STEP) * ENCODER_STEP,
            floor(shaft / ENCODER_STEP) * ENCODER_STEP,
        ]
        for sensor, frozen in self.faults.frozen.items():
            raw[sensor] = frozen
        return raw


class References(NamedTuple):
    """Where the motors are to go, internal ticks, and whether they are on."""

    ticks: Pair = (0, 0)
    on: int = 0


class Loop:
    """Motors and references of one device against its clock: references handed on turn by turn, watchdog."""

    def __init__(
        self, switches: Switches, shaft: Shaft, clock: Clock, motors_rad: Torques, loads: Loads, latency_s: float
    ) -> None:
        """``latency_s``: from a command until the loop knows of it."""
        self._switches, self._shaft, self._clock, self._loads = switches, shaft, clock, loads
        start_s = clock.now_s()
        self.motors = Motors(switches, (*motors_rad, shaft.shaft_rad(start_s, motors_rad)))
        self._now_ms = int(start_s * 1000)
        self.new = self.current = self.old = References()
        self.bridge_on: int | None = None
        "Whether the bridge is on after a watchdog that cleared only the flag; None: as the flag says."
        self._watchdog_ms = _NEVER_MS
        self._latency_ms = round(latency_s * 1000)
        self._commanded: deque[tuple[int, Pair]] = deque()

    def command(self, ticks: Pair) -> None:
        """Where the motors are to go, once that is known here."""
        if self._latency_ms:
            self._commanded.append((self._now_ms + self._latency_ms, ticks))
        else:
            self.new = References(ticks, self.new.on)

    def activate(self, references: References) -> None:
        """At once, and instead of what has been commanded before."""
        self._commanded.clear()
        self.new, self.bridge_on = references, None

    def advance(self, current: Memory, shadow: Memory) -> None:
        """Run up to the clock. ``current`` settings move the motors, ``shadow`` ones scale and shift the encoders."""
        until_ms = int(self._clock.now_s() * 1000 + 1e-6)
        if until_ms <= self._now_ms:
            return
        strained = self.motors.strained
        while self._now_ms < until_ms:
            if self._now_ms >= self._watchdog_ms:
                self.bridge_on = self.current.on if self.motors.faults.flag_only else None
                self.new, self._watchdog_ms = self.new._replace(on=0), _NEVER_MS
            while self._commanded and self._commanded[0][0] <= self._now_ms:
                self.new = References(self._commanded.popleft()[1], self.new.on)
            # only the watchdog, a command, or a load that may stall a motor, comes between
            plain = not strained and self.current.on == self.new.on
            next_ms = self._commanded[0][0] if self._commanded else until_ms
            turns = max(1, min(until_ms, self._watchdog_ms, next_ms) - self._now_ms) if plain else 1
            self._turns(turns, current, shadow)
            self._now_ms += turns
            if strained:
                self._turn_shaft()
                strained = self.motors.strained
        self._turn_shaft()

    def feed_watchdog(self, counts: int) -> None:
        """Something was heard. Periods of 0 counts are taken as no watchdog: what they mean is unknown."""
        self._watchdog_ms = self._now_ms + _WATCHDOG_MS[counts] if counts else _NEVER_MS

    def restart(self, on: int) -> None:
        """Power comes back: references 0."""
        self._commanded.clear()
        self.new = self.current = self.old = References(on=on)
        self.bridge_on = None
        self.motors.pwm = [0, 0]

    def _turn_shaft(self) -> None:
        angles_rad = self.motors.angles_rad()
        self.motors.turn_shaft(self._shaft.shaft_rad(self._now_ms / 1000, angles_rad))
        self.motors.loads_nm = self._loads(angles_rad)

    def _turns(self, turns: int, current: Memory, shadow: Memory) -> None:
        """So many turns: the motors follow the newest references from the second on."""
        on = self.current.on if self.bridge_on is None else self.bridge_on
        powered = (on > 0, on > 0) if self._switches.both_motors_or_none else (bool(on & 1), bool(on & 2))
        before, ticks = self.current.ticks, self.new.ticks
        plan = [(turns, ticks)] if before == ticks else [(1, before), (turns - 1, ticks)]
        self.motors.run(plan, current, shadow, powered)
        self.old, self.current = self.current if turns == 1 else self.new, self.new
