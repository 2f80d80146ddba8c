"""The two motors of a qbmove, their encoders and the 1 kHz loop that moves them: ``motor_control`` (v6.1), simplified.

PWM is computed as the firmware does in position, deflection and PWM mode, without the integral, whose gain is 0. A
motor's speed is proportional to it at once, and does not give way to load, until the load reaches what the motor can
do: there it stalls. Current follows the load. Without PWM the gears hold. In the current modes (2, 3, 5) the motors
stand still: the study never uses them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from emg2vsa.worlds.far_ends.qbmove.memory import INTERNAL_PER_TICK, Memory
from emg2vsa.worlds.far_ends.qbmove.switches import Switches

INTERNAL_PER_TURN = 65536
INTERNAL_PER_RAD = INTERNAL_PER_TURN / (2 * math.pi)
ENCODER_STEP = 16
"""AS5045, 12 bit: 8 wire ticks."""
PWM_MOST = 100
IDLE_CURRENT_MA = 150
"""Current at full PWM without load: a guess."""
_POSITION, _PWM, _DEFLECTION = 0, 1, 4
_SHAFT = 2
_WITHOUT_RATE = 13
"""Parameters of a firmware that knows no greatest PWM rate."""

Pair = tuple[int, int]
Torques = tuple[float, float]
_STRAINED = 0.5
"""Part of the stall torque from which the load is looked at in every turn."""


@dataclass
class MotorFaults:
    """What goes wrong, changed while the motors run.

    jammed : no motor moves, whatever pulls. unsupplied : nor draws it current; the electronics live on USB.
    torque_nm : most that a motor can do; None is what it is built for.
    frozen : what an encoder goes on reading, internal ticks. jumped_ticks : wire ticks added to what it reads.
    current_ma : added to the measured currents. flag_only : an expired watchdog leaves the motors on.
    """

    jammed: bool = False
    unsupplied: bool = False
    torque_nm: float | None = None
    frozen: dict[int, int] = field(default_factory=dict)
    jumped_ticks: list[int] = field(default_factory=lambda: [0, 0, 0])
    current_ma: float = 0.0
    flag_only: bool = False


class Motors:
    """Positions in internal ticks, in the wire's direction, and what the firmware makes of them."""

    def __init__(self, switches: Switches, angles_rad: Sequence[float]) -> None:
        """``angles_rad``: of motor 1, motor 2 and shaft, at the start."""
        self._full_step = switches.motor_speed_rad_per_s * INTERNAL_PER_RAD / 1000
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
            self.faults.frozen.setdefault(sensor, self._raw(sensor))
        else:
            self.faults.frozen.pop(sensor, None)

    def angles_rad(self) -> tuple[float, float]:
        """Where the motors are."""
        return self._at[0] / INTERNAL_PER_RAD, self._at[1] / INTERNAL_PER_RAD

    def turn_shaft(self, angle_rad: float) -> None:
        """The shaft is where the world has it."""
        self._at[_SHAFT] = angle_rad * INTERNAL_PER_RAD

    def measured(self, memory: Memory) -> tuple[int, int, int]:
        """Encoder readings, internal ticks."""
        return self._reading(0, memory), self._reading(1, memory), self._reading(_SHAFT, memory)

    def forget_turns(self, memory: Memory) -> None:
        """At a start or new zero: an encoder knows its place only within a turn."""
        self._turns_lost = [0, 0, 0]
        half = INTERNAL_PER_TURN // 2
        self._turns_lost = [(value + half) // INTERNAL_PER_TURN for value in self.measured(memory)]

    def step(self, references: Pair, memory: Memory, scale: Memory, powered: tuple[bool, bool]) -> bool:
        """One millisecond; True when another would change nothing. ``scale``: the settings that encoders obey."""
        still = True
        for motor in (0, 1):
            seen = self._reading(motor, scale)
            wanted = self._pwm(motor, references[motor], seen, memory) if powered[motor] else 0
            pwm = self._rate_limited(wanted, self.pwm[motor], memory) if self._limits_rate else wanted
            still = still and pwm == self.pwm[motor] == 0 and seen == self._seen[motor]
            self.pwm[motor], self._seen[motor] = pwm, seen
            if not self._blocked(motor):
                self._at[motor] += self._full_step * pwm / PWM_MOST
        return still

    def run(self, plan: Sequence[tuple[int, Pair]], memory: Memory, scale: Memory, powered: tuple[bool, bool]) -> None:
        """Many times `step`, with the loads as they are.

        plan : numbers of steps, and the references that they follow."""
        faults = self.faults
        if memory.control_mode != _POSITION or self._limits_rate or faults.frozen or faults.jammed or faults.unsupplied:
            for turns, references in plan:
                for _ in range(turns):
                    if self.step(references, memory, scale, powered):
                        break
            return
        for motor in (0, 1):
            # as in `step`, with everything at hand that does not change from turn to turn
            shift = faults.jumped_ticks[motor] * INTERNAL_PER_TICK + scale.offsets[motor]
            lost, multiplier = self._turns_lost[motor] * INTERNAL_PER_TURN, scale.multipliers[motor]
            proportional, derivative = self._sign * memory.position_pid[0], self._sign * memory.position_pid[2]
            on, full_step, load_nm, most_nm = powered[motor], self._full_step, self.loads_nm[motor], self._most_nm
            free_up, free_down = load_nm < most_nm, -load_nm < most_nm
            at, seen, pwm = self._at[motor], self._seen[motor], self.pwm[motor]
            for turns, references in plan:
                reference = references[motor]
                for _ in range(turns):
                    before, pwm_before = seen, pwm
                    seen = int((math.floor(at / ENCODER_STEP) * ENCODER_STEP + shift - lost) * multiplier)
                    pwm = (proportional * (reference - seen) >> 16) + (derivative * (before - seen) >> 16) if on else 0
                    if not -PWM_MOST <= pwm <= PWM_MOST:
                        pwm = PWM_MOST if pwm > 0 else -PWM_MOST
                    if pwm == pwm_before == 0 and seen == before:
                        break
                    if free_up if pwm >= 0 else free_down:
                        at += full_step * pwm / PWM_MOST
            self._at[motor], self._seen[motor], self.pwm[motor] = at, seen, pwm

    def currents_ma(self) -> Pair:
        """Motor currents, with the sign of the PWM."""
        return self._current_ma(0), self._current_ma(1)

    def _current_ma(self, motor: int) -> int:
        pwm, current_ma = self.pwm[motor], 0.0
        if pwm and not self.faults.unsupplied:
            stall_ma = math.copysign(self._stall_ma, pwm)
            load_nm = max(0.0, math.copysign(1.0, pwm) * self.loads_nm[motor])
            current_ma = stall_ma * load_nm / self._stall_nm + IDLE_CURRENT_MA * pwm / PWM_MOST
            if self._blocked(motor):
                current_ma = stall_ma * abs(pwm) / PWM_MOST
        return int(current_ma + self.faults.current_ma)

    @property
    def _most_nm(self) -> float:
        weak_nm = self.faults.torque_nm
        return self._stall_nm if weak_nm is None else weak_nm

    def _blocked(self, motor: int) -> bool:
        against_nm = math.copysign(1.0, self.pwm[motor]) * self.loads_nm[motor]
        return self.faults.jammed or self.faults.unsupplied or against_nm >= self._most_nm

    def _raw(self, sensor: int) -> int:
        if sensor in self.faults.frozen:
            return self.faults.frozen[sensor]
        return math.floor(self._at[sensor] / ENCODER_STEP) * ENCODER_STEP

    def _reading(self, sensor: int, memory: Memory) -> int:
        jumped = self.faults.jumped_ticks[sensor] * INTERNAL_PER_TICK
        raw = self._raw(sensor) + jumped + memory.offsets[sensor]
        return int((raw - self._turns_lost[sensor] * INTERNAL_PER_TURN) * memory.multipliers[sensor])

    def _pwm(self, motor: int, reference: int, seen: int, memory: Memory) -> int:
        if memory.control_mode == _PWM:
            wanted = reference >> memory.resolutions[motor]
        elif memory.control_mode in (_POSITION, _DEFLECTION):
            shaft = self._reading(_SHAFT, memory) if memory.control_mode == _DEFLECTION else 0
            proportional, derivative = self._sign * memory.position_pid[0], self._sign * memory.position_pid[2]
            wanted = (proportional * (reference + shaft - seen) >> 16) + (derivative * (self._seen[motor] - seen) >> 16)
        else:
            wanted = 0
        return max(-PWM_MOST, min(PWM_MOST, wanted))

    @staticmethod
    def _rate_limited(wanted: int, before: int, memory: Memory) -> int:
        # only a saturated move is held back; from the behaviour of the compiled firmware, not from its source
        if abs(wanted) < PWM_MOST:
            return wanted
        return max(before - memory.max_pwm_rate, min(before + memory.max_pwm_rate, wanted))
